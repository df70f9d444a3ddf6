#include "firmware/acquire/conversion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace spindle_twin::firmware {
namespace acquire_conversion_test {

// IEC 60751, table of the standard: R(t) of a Pt100.
constexpr std::array<std::pair<double, double>, 9> table{{{-200.0, 18.52},
                                                          {-150.0, 39.72},
                                                          {-100.0, 60.2558},
                                                          {-50.0, 80.31},
                                                          {0.0, 100.0},
                                                          {100.0, 138.5055},
                                                          {200.0, 175.86},
                                                          {500.0, 280.98},
                                                          {850.0, 390.481}}};

TEST(Pt100, resistances_are_those_of_the_standards_table) {
  for (const auto& [temperature_degC, resistance_ohm] : table) {
    EXPECT_NEAR(pt100_ohm(temperature_degC), resistance_ohm, 0.005) << temperature_degC;
  }
  EXPECT_NEAR(pt100_ohm(-100.0), 60.2558, 5e-5);
  EXPECT_NEAR(pt100_ohm(100.0), 138.5055, 5e-5);
  EXPECT_NEAR(pt100_ohm(850.0), 390.4811, 5e-5);
}

TEST(Pt100, both_directions_are_each_others_inverse_over_the_whole_range) {
  for (double t = -200.0; t <= 850.0; t += 0.5) EXPECT_NEAR(pt100_degC(pt100_ohm(t)), t, 1e-6) << t;
}

Conversion pt100() {
  Conversion conversion;
  conversion.kind = ConversionKind::pt100;
  conversion.unit = {1.0, 273.15};
  return conversion;
}

TEST(Pt100, broken_and_shorted_wires_show_the_ends_of_the_range) {
  const double span_ohm = pt100_ohm(850.0) - pt100_ohm(-200.0);
  const auto at = [&](double share) { return convert(pt100(), pt100_ohm(-200.0) + share * span_ohm); };
  EXPECT_NEAR(convert(pt100(), 107.7935).value, 293.15, 1e-3);
  EXPECT_EQ(at(-0.026).fault, WireFault::shorted);
  EXPECT_EQ(convert(pt100(), 0.0).fault, WireFault::shorted);
  EXPECT_DOUBLE_EQ(convert(pt100(), 0.0).value, 73.15);
  EXPECT_EQ(at(-0.01).fault, WireFault::under);
  EXPECT_DOUBLE_EQ(at(-0.01).value, 73.15);
  EXPECT_EQ(at(1.02).fault, WireFault::over);
  EXPECT_DOUBLE_EQ(at(1.02).value, 1123.15);
  EXPECT_EQ(at(1.063).fault, WireFault::open);
  EXPECT_EQ(convert(pt100(), std::numeric_limits<double>::infinity()).fault, WireFault::open);
  EXPECT_TRUE(std::isnan(convert(pt100(), std::numeric_limits<double>::quiet_NaN()).value));
}

TEST(Pt100, the_whole_range_with_both_ends_is_good_and_what_lies_beyond_is_judged_like_a_current) {
  for (double t = -200.0; t <= 850.0; t += 10.0) {
    EXPECT_EQ(convert(pt100(), pt100_ohm(t)).fault, WireFault::none) << t;
    EXPECT_NEAR(convert(pt100(), pt100_ohm(t)).value, 273.15 + t, 1e-6) << t;
  }
  // As shares of the span from 4 to 20 mA: 3.6 and 21 mA.
  const double lowest_ohm = pt100_ohm(-200.0), span_ohm = pt100_ohm(850.0) - lowest_ohm;
  const auto fault_at = [&](double share) { return convert(pt100(), lowest_ohm + share * span_ohm).fault; };
  constexpr double little = 1e-9;
  EXPECT_EQ(fault_at(-0.4 / 16.0 - little), WireFault::shorted);
  EXPECT_EQ(fault_at(-0.4 / 16.0 + little), WireFault::under);
  EXPECT_EQ(fault_at(-little), WireFault::under);
  EXPECT_EQ(fault_at(1.0 + little), WireFault::over);
  EXPECT_EQ(fault_at(17.0 / 16.0 - little), WireFault::over);
  EXPECT_EQ(fault_at(17.0 / 16.0 + little), WireFault::open);
}

TEST(Current, is_judged_after_namur_ne_43) {
  Conversion conversion;
  conversion.kind = ConversionKind::ma_4_20;
  conversion.at_4mA = -50.0;
  conversion.at_20mA = 150.0;
  const auto at = [&](double current_mA) { return convert(conversion, current_mA); };
  EXPECT_DOUBLE_EQ(at(4.0).value, -50.0);
  EXPECT_DOUBLE_EQ(at(12.0).value, 50.0);
  EXPECT_DOUBLE_EQ(at(20.0).value, 150.0);
  EXPECT_DOUBLE_EQ(at(3.8).value, -52.5) << "from 3.8 to 20.5 mA the value is measured";
  EXPECT_DOUBLE_EQ(at(20.5).value, 156.25);
  EXPECT_EQ(at(3.8).fault, WireFault::none);
  EXPECT_EQ(at(20.5).fault, WireFault::none);
  EXPECT_DOUBLE_EQ(at(3.7).value, -52.5) << "and held there to the failure currents";
  EXPECT_EQ(at(3.7).fault, WireFault::under);
  EXPECT_DOUBLE_EQ(at(20.8).value, 156.25);
  EXPECT_EQ(at(20.8).fault, WireFault::over);
  for (const double failed_mA : {-1.0, 0.0, 3.6, 21.0, 24.0}) {
    EXPECT_TRUE(std::isnan(at(failed_mA).value)) << failed_mA;
    EXPECT_EQ(at(failed_mA).fault, failed_mA < 4.0 ? WireFault::shorted : WireFault::open) << failed_mA;
  }
}

TEST(Linear, scale_and_offset_come_before_the_unit) {
  EXPECT_DOUBLE_EQ(convert({ConversionKind::linear, 0.01, 0.5, 0.0, 0.0, {2.0, 10.0}}, 2500.0).value, 61.0);
  const Conversion conversion{ConversionKind::linear, 0.01, 0.5, 0.0, 0.0, {1.0, 273.15}};
  EXPECT_DOUBLE_EQ(convert(conversion, 2500.0).value, 298.65);
  EXPECT_DOUBLE_EQ(step_of(conversion), 0.01);
}

TEST(Conversions, a_step_of_the_number_is_that_change_of_the_value_whichever_way_it_goes) {
  Conversion current{ConversionKind::ma_4_20, -0.004, 20.0, 150.0, -50.0, {}};
  const double change = convert(current, 1.0).value - convert(current, 0.0).value;
  EXPECT_NEAR(change, 0.05, 1e-12);
  EXPECT_NEAR(step_of(current), 0.05, 1e-12);
  Conversion ohm{ConversionKind::pt100, -0.01, 100.0, 0.0, 0.0, {}};
  EXPECT_NEAR(convert(ohm, -1.0).value, step_of(ohm), 1e-5) << "at 0 degC";
  EXPECT_DOUBLE_EQ(step_of({ConversionKind::linear, -0.25, 7.0, 0.0, 0.0, {}}), 0.25);
}

TEST(Conversions, what_is_no_number_is_no_fault_of_the_wire) {
  for (const ConversionKind kind : {ConversionKind::linear, ConversionKind::pt100, ConversionKind::ma_4_20}) {
    Conversion conversion;
    conversion.kind = kind;
    const Converted converted = convert(conversion, std::numeric_limits<double>::quiet_NaN());
    EXPECT_TRUE(std::isnan(converted.value));
    EXPECT_EQ(converted.fault, WireFault::none);
  }
}

TEST(Conversions, without_any_setting_a_number_is_its_value) {
  EXPECT_EQ(convert({}, 12.5).value, 12.5);
  EXPECT_EQ(convert({}, 0.0).value, 0.0);
}

}  // namespace acquire_conversion_test
}  // namespace spindle_twin::firmware
