#include "correction/health/isothermal_tare.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace spindle_twin::correction {
namespace health_isothermal_tare_test {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Three sensors on a machine that cools down with a time constant of 30 minutes.
struct Cooling {
  Cooling() : tare(3, TareLimits{}), samples(3) {}
  void run(double seconds, bool heated = false) {
    for (double end_s = time_s + seconds; time_s < end_s; time_s += 1.0) {
      for (std::size_t i = 0; i < 3; ++i) {
        const double rise_K = (4.0 + static_cast<double>(i)) * std::exp(-time_s / 1800.0);
        samples[i] = {true, 295.0 + rise_K + offset_K[i] + 0.03 * normal(random), 295.0 + rise_K};
      }
      tare.step(samples, heated, 1.0);
    }
  }
  IsothermalTare tare;
  std::vector<TareSample> samples;
  std::array<double, 3> offset_K{0.15, -0.2, 0.05};  // mean 0
  std::mt19937_64 random{4};
  std::normal_distribution<double> normal{0.0, 1.0};
  double time_s = 0.0;
};

TEST(IsothermalTare, is_offered_when_the_machine_has_cooled_and_finds_the_offsets) {
  Cooling cooling;
  SensorTare taken;
  cooling.run(7000.0);
  EXPECT_FALSE(cooling.tare.offered());
  EXPECT_FALSE(cooling.tare.take(not_a_number, 0.03, taken));
  EXPECT_EQ(taken.count, 0U);
  cooling.run(3.0 * 3600.0);
  ASSERT_TRUE(cooling.tare.offered());
  ASSERT_TRUE(cooling.tare.take(not_a_number, 0.03, taken));
  EXPECT_EQ(taken.count, 1U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(taken.offset_K[i], cooling.offset_K[i], 3.0 * taken.deviation_K[i]);
    EXPECT_LT(taken.deviation_K[i], 0.02);
  }
}

TEST(IsothermalTare, an_ambient_shows_the_mean_of_the_offsets_too) {
  Cooling cooling;
  for (double& offset_K : cooling.offset_K) offset_K += 0.1;
  cooling.run(5.0 * 3600.0);
  SensorTare common, ambient;
  ASSERT_TRUE(cooling.tare.take(not_a_number, 0.03, common));
  ASSERT_TRUE(cooling.tare.take(295.0, 0.03, ambient));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(common.offset_K[i], cooling.offset_K[i] - 0.1, 0.01);
    EXPECT_NEAR(ambient.offset_K[i], cooling.offset_K[i], 0.01);
  }
}

TEST(IsothermalTare, heat_or_a_wide_spread_withdraws_the_offer) {
  Cooling cooling;
  cooling.run(5.0 * 3600.0);
  ASSERT_TRUE(cooling.tare.offered());
  cooling.run(1.0, true);
  EXPECT_FALSE(cooling.tare.offered());
  cooling.offset_K[1] = -2.0;  // no class A sensor is so far off
  cooling.run(3.0 * 3600.0);
  EXPECT_FALSE(cooling.tare.offered());
}

TEST(IsothermalTare, a_machine_that_still_changes_is_not_isothermal) {
  Cooling cooling;
  for (double& offset_K : cooling.offset_K) offset_K = 0.0;
  cooling.time_s = -4000.0;  // hot enough to change by more than 0.3 K/h after the rest
  cooling.run(7500.0);
  EXPECT_FALSE(cooling.tare.offered());
}

TEST(IsothermalTare, says_what_it_waits_for_and_which_sensor_it_is) {
  Cooling cooling;
  cooling.run(60.0, true);
  EXPECT_EQ(cooling.tare.outlook().waits_for, TareWait::heat);
  EXPECT_TRUE(std::isnan(cooling.tare.outlook().left_s));
  cooling.run(100.0);
  EXPECT_EQ(cooling.tare.outlook().waits_for, TareWait::rest);
  EXPECT_NEAR(cooling.tare.outlook().left_s, 7100.0, 1.5);
  cooling.run(7200.0);
  for (int n = 0; n < 700; ++n) {
    cooling.offset_K[1] += 2e-4;
    cooling.run(1.0);
  }
  EXPECT_EQ(cooling.tare.outlook().waits_for, TareWait::change);
  EXPECT_EQ(cooling.tare.outlook().channel, 1);
  EXPECT_LE(cooling.tare.outlook().left_s, 300.0);
  cooling.run(5.0 * 3600.0);
  EXPECT_EQ(cooling.tare.outlook().waits_for, TareWait::nothing);
  cooling.offset_K = {0.1, -0.1, 1.4};
  cooling.run(900.0);
  EXPECT_EQ(cooling.tare.outlook().waits_for, TareWait::apart);
  EXPECT_EQ(cooling.tare.outlook().channel, 2);
  cooling.offset_K = {-1.4, 0.1, -0.1};  // one that reads too cold as well
  cooling.run(900.0);
  EXPECT_EQ(cooling.tare.outlook().channel, 0);
  cooling.offset_K = {};
  cooling.tare.step(cooling.samples, true, 1.0);
  EXPECT_EQ(cooling.tare.outlook().waits_for, TareWait::heat);
}

TEST(IsothermalTare, waits_for_the_model_and_for_two_sensors) {
  const auto rested = [](double model_K, bool second) {
    IsothermalTare tare(2, TareLimits{});
    for (int n = 0; n < 8000; ++n) tare.step({{true, 295.0, 295.0}, {second, 295.0, model_K}}, false, 1.0);
    return tare.outlook().waits_for;
  };
  EXPECT_EQ(rested(295.2, true), TareWait::model);
  EXPECT_EQ(rested(295.0, false), TareWait::sensors);
  EXPECT_EQ(rested(295.0, true), TareWait::nothing);
}

TEST(IsothermalTare, clearing_leaves_no_offset) {
  SensorTare tare{1, {0.1, 0.2}, {0.01, 0.01}};
  IsothermalTare::clear(tare);
  EXPECT_EQ(tare.count, 2U);
  EXPECT_EQ(tare.offset_K, (std::vector<double>{0.0, 0.0}));
  EXPECT_EQ(tare.deviation_K, (std::vector<double>{0.0, 0.0}));
}

}  // namespace health_isothermal_tare_test
}  // namespace spindle_twin::correction
