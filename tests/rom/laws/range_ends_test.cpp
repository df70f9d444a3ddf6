#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

#include "rom/laws/air_gap.hpp"
#include "rom/laws/bearing_friction.hpp"
#include "rom/laws/contact_conductance.hpp"
#include "rom/laws/coolant_channel.hpp"
#include "rom/laws/motor_loss.hpp"
#include "rom/laws/rotating_surface.hpp"
#include "rom/laws/windage.hpp"
#include "tests/rom/laws/law_checks.hpp"

/// What a law says of itself at exactly the end of its range, at standstill, and at a jump that its source has.
namespace spindle_twin::rom::test {
namespace laws_range_ends_test {

using Flags = std::function<std::uint16_t(double)>;

double next_below(double x) { return std::nextafter(x, -1e300); }
double next_above(double x) { return std::nextafter(x, 1e300); }

/// Inside the range are both of its ends.
void expect_range(const Flags& flags, double low, double high, const char* what) {
  EXPECT_EQ(flags(next_below(low)), below_range) << what;
  EXPECT_EQ(flags(low), in_range) << what;
  EXPECT_EQ(flags(high), in_range) << what;
  EXPECT_EQ(flags(next_above(high)), above_range) << what;
}

/// Where the flag changes between two numbers, to 1e-12 of it.
double changes_at(const Flags& flags, std::uint16_t flag, double from, double to) {
  EXPECT_NE(flags(from) & flag, flags(to) & flag) << "between " << from << " and " << to;
  const int at_first = flags(from) & flag;
  while (std::abs(to - from) > 1e-12 * std::abs(to)) {
    const double middle = 0.5 * (from + to);
    ((flags(middle) & flag) == at_first ? from : to) = middle;
  }
  return to;
}

TEST(RangeEnds, belong_to_the_range) {
  expect_range([](double x) { return range_flags(x, 2.0, 3.0); }, 2.0, 3.0, "any");
  const auto gap = [](double taylor) { return gap_nusselt(LawMode::standard, taylor).flags; };
  EXPECT_EQ(gap(0.0), in_range);
  EXPECT_EQ(gap(1e7), in_range);
  const auto winding = [](double v) { return end_winding_W_per_m2K(LawMode::standard, EndWinding{}, v).flags; };
  EXPECT_EQ(winding(0.0), in_range);
  EXPECT_EQ(winding(-100.0), in_range);
  const auto iron = [](double f, double B) { return iron_loss_W(LawMode::standard, IronLoss{}, f, B).flags; };
  EXPECT_EQ(iron(0.0, 0.0), in_range);
  EXPECT_EQ(iron(0.5, 0.5), in_range);
  EXPECT_EQ(iron(2000.0, 2.0), in_range);
}

TEST(RangeEnds, of_a_channel_are_a_reynolds_and_two_prandtl_numbers) {
  ChannelShape shape;
  shape.hydraulic_diameter_m = 0.008;
  shape.length_m = 3.0;
  const auto flags = [&](double reynolds, double prandtl) {
    return channel_nusselt(LawMode::standard, shape, reynolds, prandtl).flags;
  };
  EXPECT_EQ(flags(0.0, 5.8), in_range) << "no flow";
  EXPECT_EQ(flags(0.5, 5.8), in_range);
  EXPECT_EQ(flags(5e6, 5.8), in_range);
  EXPECT_EQ(flags(next_above(5e6), 5.8), above_range);
  expect_range([&](double prandtl) { return flags(1e4, prandtl); }, 0.5, 2000.0, "Prandtl number");
}

TEST(RangeEnds, of_laminar_flow_in_the_papers_formulas_is_where_the_next_formula_begins) {
  ChannelShape trio;
  trio.formula = ChannelFormula::paper_trio;
  trio.hydraulic_diameter_m = 0.008;
  trio.length_m = 80.0;  // Gz = 1.3, too long for the laminar formula
  const double ratio = 0.008 / 80.0;
  const auto at = [&](double reynolds) { return channel_nusselt(LawMode::as_published, trio, reynolds, 5.8); };
  EXPECT_EQ(at(next_below(2200.0)).flags, below_range);
  EXPECT_EQ(at(2200.0).flags, in_range);
  EXPECT_EQ(at(2200.0).value, hausen_nusselt(2200.0, 5.8, ratio));
  EXPECT_EQ(at(next_below(2200.0)).value, sieder_tate_nusselt(next_below(2200.0) * 5.8 * ratio));
  EXPECT_EQ(at(1e4).value, hausen_nusselt(1e4, 5.8, ratio));
  EXPECT_EQ(at(next_above(1e4)).value, dittus_boelter_nusselt(next_above(1e4), 5.8));
}

/// A helix wound as tightly as its channel is wide turns over late, above where other helices are turbulent.
TEST(RangeEnds, of_the_transition_in_the_tightest_helix_leave_half_of_its_beginning) {
  ChannelShape helix;
  helix.hydraulic_diameter_m = helix.coil_diameter_m = 0.01;
  helix.length_m = 2.0;
  const double low = helix_critical_reynolds(1.0), high = 1.5 * low;
  EXPECT_GT(low, 2.2e4);
  const auto nusselt = [&](LawMode mode, double Re) { return channel_nusselt(mode, helix, Re, 5.8).value; };
  const auto laminar = [&](LawMode mode, double Re) { return laminar_nusselt(mode, 3.66, Re * 5.8 * 0.005); };
  const auto turbulent = [](double Re) { return turbulent_nusselt(Re, 5.8, 0.005); };  // no swirl where d = D
  const double middle = 0.5 * (low + high);
  expect_close(nusselt(LawMode::standard, low), laminar(LawMode::standard, low), "beginning", 1e-12);
  expect_close(nusselt(LawMode::standard, middle), 0.5 * laminar(LawMode::standard, middle) + 0.5 * turbulent(middle),
               "middle", 1e-12);
  expect_close(nusselt(LawMode::as_published, middle),
               0.5 * laminar(LawMode::as_published, low) + 0.5 * turbulent(high), "middle as published", 1e-12);
  expect_close(nusselt(LawMode::standard, next_above(high)), turbulent(high), "end", 1e-12);
  const double quarter = low + 0.25 * (high - low);
  const double weight = 0.0625 * (3.0 - 0.5);
  expect_close(nusselt(LawMode::standard, quarter),
               (1.0 - weight) * laminar(LawMode::standard, quarter) + weight * turbulent(quarter), "quarter", 1e-12);
}

TEST(RangeEnds, nothing_that_rotates_is_out_of_range_at_standstill_or_while_it_creeps) {
  const WindageShape shape{0.04, 0.0005, 0.15};
  const RotatingSurface surface{RotationFormula::standard, 0.04};
  BearingFriction bearing;
  bearing.pitch_diameter_m = 0.08;
  bearing.static_rating_N = 2e4;
  bearing.contact_angle_rad = 0.4;
  for (const double rpm : {0.0, 1e-3, -1e-3}) {
    EXPECT_EQ(gap_windage_W(LawMode::standard, shape, rpm, room_K).flags, in_range) << rpm;
    EXPECT_EQ(end_windage_W(LawMode::standard, shape, rpm, room_K).flags, in_range) << rpm;
    EXPECT_EQ(rotating_cylinder_W_per_m2K(LawMode::standard, surface, rpm, room_K, 5.0).flags, in_range) << rpm;
    EXPECT_EQ(rotating_disc_W_per_m2K(LawMode::standard, surface, rpm, room_K, 5.0).flags, in_range) << rpm;
    EXPECT_EQ(bearing_heat_W(LawMode::standard, bearing, 2e-5, 100.0, 0.0, rpm).flags, in_range) << rpm;
    EXPECT_EQ(air_gap_W_per_m2K(LawMode::standard, {0.04, 5e-4, 0.0}, rpm, room_K, room_K).flags, in_range) << rpm;
  }
}

TEST(RangeEnds, of_an_oil_film_and_of_a_gap_as_wide_as_is_allowed_belong_to_it) {
  BearingFriction bearing;
  bearing.pitch_diameter_m = 0.08;
  bearing.static_rating_N = 2e4;
  bearing.contact_angle_rad = 0.4;
  const auto film = [&](double nu) { return bearing_heat_W(LawMode::standard, bearing, nu, 100.0, 0.0, 600.0).flags; };
  EXPECT_EQ(film(2e-6), in_range);
  EXPECT_EQ(film(next_below(2e-6)), thin_film);
  const auto windage = [](double gap_m) {
    return gap_windage_W(LawMode::standard, {1.0, gap_m, 0.15}, 10.0, room_K).flags;
  };
  EXPECT_EQ(windage(1e-3), in_range);
  EXPECT_EQ(windage(next_below(1e-3)), shape_out_of_range);
  EXPECT_EQ(windage(0.5), in_range);
  EXPECT_EQ(windage(next_above(0.5)), shape_out_of_range);
  const auto air_gap = [](double gap_m, double expansion, double rotor_K) {
    return air_gap_W_per_m2K(LawMode::standard, {1.0, gap_m, expansion}, 1.0, rotor_K, 300.0).flags;
  };
  EXPECT_EQ(air_gap(0.2, 0.0, 300.0) & shape_out_of_range, 0);
  EXPECT_EQ(air_gap(next_above(0.2), 0.0, 300.0) & shape_out_of_range, shape_out_of_range);
  // What is left of 1/8 m when the rotor is 1 K warmer: 1/40 is a fifth.
  EXPECT_EQ(air_gap(0.125, 0.0999, 301.0) & shape_out_of_range, 0);
  EXPECT_EQ(air_gap(0.125, 0.1001, 301.0) & shape_out_of_range, shape_out_of_range);
}

TEST(RangeEnds, of_an_oil_are_two_temperatures_and_two_square_millimetres_per_second) {
  const Lubricant oil = lubricant_through(313.15, 10e-6, 373.15, 2.5e-6);
  const auto flags = [&](double T) { return lubricant_viscosity_m2_per_s(LawMode::as_published, oil, T).flags; };
  const double thin_K = changes_at(flags, thin_film, 330.0, 400.0);
  EXPECT_NEAR(lubricant_viscosity_m2_per_s(LawMode::as_published, oil, thin_K).value, 2e-6, 1e-15);
  EXPECT_EQ(flags(253.15) & temperature_clamped, 0);
  EXPECT_EQ(flags(next_below(253.15)) & temperature_clamped, temperature_clamped);
  EXPECT_EQ(flags(423.15) & temperature_clamped, 0);
  EXPECT_EQ(flags(next_above(423.15)) & temperature_clamped, temperature_clamped);
}

TEST(RangeEnds, of_natural_convection_are_two_rayleigh_numbers) {
  FluidState<double> gas = air(room_K);
  gas.prandtl = gas.viscosity_m2_per_s = 1.0;
  // Ra = 9.81 ΔT L³/T: with T = 9.81 K and L = 1 m the difference itself
  const auto cylinder = [&](double Ra) { return natural_cylinder_nusselt(gas, 9.81, 1.0, Ra).flags; };
  const auto wall = [&](double Ra) { return natural_wall_nusselt(gas, 9.81, 1.0, Ra).flags; };
  EXPECT_NEAR(changes_at(cylinder, below_range, 1.0, 1e-9), 1e-5, 1e-15);
  EXPECT_NEAR(changes_at(cylinder, above_range, 1.0, 1e15), 1e12, 1e2);
  EXPECT_NEAR(changes_at(wall, below_range, 1.0, 1e-9), 0.1, 1e-11);
  EXPECT_NEAR(changes_at(wall, above_range, 1.0, 1e15), 1e12, 1e2);
}

TEST(RangeEnds, of_the_published_law_of_a_cylinder_is_a_reynolds_number_of_a_thousand) {
  const RotatingSurface surface{RotationFormula::standard, 0.04};
  const auto flags = [&](double rpm) {
    return rotating_cylinder_W_per_m2K(LawMode::as_published, surface, rpm, room_K, 5.0).flags;
  };
  const double rpm = changes_at(flags, below_range, 1.0, 1000.0);
  EXPECT_NEAR(rpm * std::numbers::pi / 30.0 * 0.0032 / air(room_K).viscosity_m2_per_s, 1000.0, 1e-6);
  EXPECT_EQ(flags(1000.0), in_range);
}

TEST(RangeEnds, of_laminar_flow_on_the_published_disc_is_a_jump_at_three_hundred_thousand) {
  const RotatingSurface disc{RotationFormula::standard, 0.05};
  const auto gas = air(room_K);
  const auto film_at = [&](double reynolds) {
    const double rpm = reynolds * gas.viscosity_m2_per_s / 0.0025 * 30.0 / std::numbers::pi;
    return rotating_disc_W_per_m2K(LawMode::as_published, disc, rpm, room_K, 5.0).value;
  };
  const double scale = gas.conductivity_W_per_mK / 0.05;
  expect_close(film_at(2.999e5), scale * laminar_disc_nusselt(2.999e5), "laminar", 1e-12);
  expect_close(film_at(3.001e5), scale * turbulent_disc_nusselt(3.001e5), "turbulent", 1e-12);
  expect_close(film_at(5e5), scale * turbulent_disc_nusselt(5e5), "turbulent", 1e-12);
}

TEST(RangeEnds, of_the_published_pieces_of_air_friction_belong_to_the_next_piece) {
  const double ratio = 0.0125, g = std::pow(ratio, 0.3);
  const auto friction = [&](double Re) { return gap_friction_times_reynolds(LawMode::as_published, ratio, Re); };
  EXPECT_EQ(friction(next_below(500.0)), g * std::pow(next_below(500.0), 0.4));
  expect_close(friction(500.0), 0.515 * g * std::sqrt(500.0), "at 500", 1e-12);
  expect_close(friction(next_below(1e4)), 0.515 * g * 100.0, "below", 1e-12);
  expect_close(friction(1e4), 0.0325 * g * std::pow(1e4, 0.8), "above", 1e-12);
}

TEST(RangeEnds, of_the_path_through_balls_are_one_and_three_thousand_radians_per_second) {
  const BearingConductance bearing{18.0, 9.52e-3, 0.025};
  const auto flags = [&](double omega) {
    return bearing_conductance_W_per_K(LawMode::standard, bearing, omega * 30.0 / std::numbers::pi).flags;
  };
  EXPECT_NEAR(changes_at(flags, below_range, 100.0, 0.0), 1.0, 1e-9);
  EXPECT_NEAR(changes_at(flags, above_range, 100.0, 1e5), 3000.0, 1e-6);
}

TEST(RangeEnds, nothing_left_of_a_preload_or_a_fit_is_an_open_joint) {
  BearingPreload spring;
  spring.initial_N = 256.0;
  spring.spring_N_per_m = 1024.0;
  const auto pressed = [&](double axial_m) { return preload_N(spring, 0.0, 0.0, 0.0, axial_m); };
  EXPECT_EQ(pressed(-0.25).flags, joint_open) << "256 N less 1024 N/m times 0.25 m";
  expect_close(pressed(-0.25).value, 0.25 * 2.56, "rounded within a hundredth of the preload", 1e-12);
  EXPECT_EQ(pressed(next_above(-0.25)).flags, in_range);
  BearingPreload rigid;
  rigid.balls = 18.0;
  rigid.ball_diameter_m = 0.01;
  rigid.contact_angle_rad = 0.4;
  EXPECT_EQ(preload_N(rigid, 0.0, 0.0, 0.0, 0.0).flags, joint_open);
  EXPECT_EQ(preload_N(rigid, 0.0, 0.0, 0.0, 0.0).value, 0.0);
  rigid.initial_N = 1e-9;
  EXPECT_EQ(preload_N(rigid, 0.0, 0.0, 0.0, 0.0).flags, in_range);
  InterferenceFit fit{0.0, 0.04, 0.05, 219e9, 0.3, 1.2e-5, 209e9, 0.269, 1.17e-5};
  for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
    EXPECT_EQ(fit_state(mode, fit, 0.0, 0.0, 0.0).flags, joint_open);
  }
  EXPECT_EQ(fit_state(LawMode::as_published, fit, 0.0, 0.0, 0.0).gap_m, 0.0);
  EXPECT_EQ(pressure_resistance_ratio(LawMode::standard, 0.0, 1e6).flags, joint_open);
  EXPECT_EQ(pressure_resistance_ratio(LawMode::standard, 0.0, 1e6).value, 10.0);
}

TEST(RangeEnds, of_a_ratio_of_resistances_are_a_tenth_and_ten) {
  const auto at = [](double ratio) { return pressure_resistance_ratio(LawMode::standard, 1e6 * ratio, 1e6, 1.0); };
  for (const double ratio : {0.102, 9.8}) {
    EXPECT_EQ(at(ratio).flags, in_range) << ratio;
  }
  for (const double ratio : {0.0999, 10.001, 1e-3, 1e3}) EXPECT_EQ(at(ratio).flags, above_range) << ratio;
  expect_close(at(2.0).value, 0.5, "in between", 1e-14);
  expect_close(at(1e-3).value, 10.0, "held", 1e-12);
  expect_close(at(1e3).value, 0.1, "held", 1e-12);
  // Rounded over a factor e^0.1: in the middle of the corner a quarter of that is lost.
  expect_close(at(10.0).value, 0.1 * std::exp(0.025), "corner", 1e-12);
  expect_close(at(0.1).value, 10.0 * std::exp(-0.025), "corner", 1e-12);
}

TEST(RangeEnds, of_a_contact_pressure_are_a_millionth_and_23_thousandths_of_the_hardness) {
  ContactSurfaces surfaces = ContactLaw::example().surfaces;
  surfaces.hardness_Pa = 1e6;  // 1 Pa and 23 kPa
  const auto flags = [&](double P) { return contact_conductance_W_per_m2K(LawMode::standard, surfaces, P, 0.0).flags; };
  expect_range(flags, 1e-6 * 1e6, 2.3e-2 * 1e6, "pressure");
  EXPECT_EQ(contact_conductance_W_per_m2K(LawMode::standard, surfaces, 100.0, 1e-9).flags, joint_open);
}

/// Each of these has a place where standstill is set aside; it is zero, not one.
TEST(RangeEnds, nothing_is_set_aside_at_a_speed_a_frequency_or_a_flow_of_one) {
  const WindageShape shape{0.04, 0.0005, 0.15};
  for (const double rpm : {1.0, 30.0 / std::numbers::pi, std::nextafter(30.0 / std::numbers::pi, 10.0)}) {
    EXPECT_GT(gap_windage_W(LawMode::standard, shape, rpm, room_K).value, 0.0) << rpm;
    EXPECT_GT(end_windage_W(LawMode::standard, shape, rpm, room_K).value, 0.0) << rpm;
  }
  IronLoss thick;
  thick.lamination_m = 0.04;
  const double x = 0.04 * std::numbers::pi * std::sqrt(4e-7 * 1000.0 / 5.2e-7);
  expect_close(eddy_loss_W_per_kg(LawMode::standard, thick, 1.0, 1.0),
               eddy_loss_W_per_kg(LawMode::as_published, thick, 1.0, 1.0) * skin_factor(x), "1 Hz", 1e-12);
  EXPECT_LT(skin_factor(x), 0.9);
  const RotatingSurface surface{RotationFormula::standard, 0.04};
  const double creeping_rpm = 0.01;
  const auto gas = air(room_K);
  const double Re = creeping_rpm * std::numbers::pi / 30.0 * 0.0032 / gas.viscosity_m2_per_s;
  EXPECT_LT(Re, 1.0);
  expect_close(rotating_cylinder_W_per_m2K(LawMode::as_published, surface, creeping_rpm, room_K, 5.0).value,
               becker_nusselt(Re, gas.prandtl) * gas.conductivity_W_per_mK / 0.08, "creeping", 1e-12);
  EXPECT_EQ(rotating_cylinder_W_per_m2K(LawMode::as_published, surface, 0.0, room_K, 5.0).value, 0.0);
}

TEST(RangeEnds, rings_of_a_fit_and_temperatures_of_a_liquid_are_apart) {
  ContactLaw law = ContactLaw::example();
  law.fit.emplace();
  const auto taken = [&](double bore_m, double joint_m, double outer_m) {
    law.fit->bore_radius_m = bore_m;
    law.fit->joint_radius_m = joint_m;
    law.fit->outer_radius_m = outer_m;
    return law.fault().empty();
  };
  EXPECT_TRUE(taken(0.037, 0.04, 0.05));
  EXPECT_FALSE(taken(0.04, 0.04, 0.05));
  EXPECT_FALSE(taken(0.037, 0.05, 0.05));
  EXPECT_FALSE(taken(0.06, 0.04, 0.05));
  EXPECT_FALSE(taken(0.037, 0.06, 0.05));
  ChannelLaw channel = ChannelLaw::example();
  channel.liquid.hottest_K = channel.liquid.coldest_K + 2.0;
  EXPECT_NE(channel.fault(), "") << "by more than two kelvin";
}

TEST(RangeEnds, a_number_that_nobody_gave_is_zero_and_in_range) {
  EXPECT_EQ(Dual<2>().value, 0.0);
  EXPECT_EQ(Dual<2>().slope[1], 0.0);
  EXPECT_EQ(LawValue<double>{}.value, 0.0);
  EXPECT_EQ(LawValue<double>{}.flags, in_range);
  EXPECT_EQ(LawState{}.load, 0.0);
}

}  // namespace laws_range_ends_test
}  // namespace spindle_twin::rom::test
