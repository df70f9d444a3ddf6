#include "rom/laws/bearing_friction.hpp"
#include "rom/laws/bearing_preload.hpp"
#include "rom/laws/fluid.hpp"
#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {
namespace laws_bearing_test {

constexpr double degree = std::numbers::pi / 180.0;

BearingFriction reference_bearing(double contact_angle_deg = 25.0) {
  BearingFriction bearing;
  bearing.pitch_diameter_m = 0.065;
  bearing.static_rating_N = 20000.0;
  bearing.contact_angle_rad = contact_angle_deg * degree;
  return bearing;
}

Lubricant reference_oil(const std::string& name) {
  return name == "VG32" ? lubricant_through(313.15, 32e-6, 373.15, 5.4e-6)
                        : lubricant_through(313.15, 68e-6, 373.15, 8.7e-6);
}

TEST(Lubricant, reference_values) {
  for (const ReferenceRow& row : reference_rows("walther_constants")) {
    expect_close(reference_oil(row.oil).walther_a, row["a"], row.oil);
    expect_close(reference_oil(row.oil).walther_b, row["b"], row.oil);
  }
  for (const ReferenceRow& row : reference_rows("lubricant")) {
    const Lubricant oil = reference_oil(row.oil);
    const double T = row["temperature_C"] + celsius_zero_K, nu = row["viscosity_mm2_per_s"];
    for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
      const auto law = [&](const auto& t) { return lubricant_viscosity_m2_per_s(mode, oil, t).value; };
      expect_close(1e6 * law(T), nu, row.oil);
      expect_close(1e6 * slope(law, T), row["slope_mm2_per_sK"], row.oil);
      expect_close(slope(law, T) / law(T), row["log_slope_per_K"], row.oil);
      const double b = -slope(law, 313.15) / law(313.15);
      expect_close(1e6 * reynolds_viscosity_m2_per_s(law(313.15), b, 313.15, T), row["reynolds_law_mm2_per_s"],
                   row.oil);
    }
  }
}

TEST(Lubricant, slopes_smoothness_and_flags) {
  const Lubricant oil = reference_oil("VG68");
  const auto law = [&](const auto& T) { return lubricant_viscosity_m2_per_s(LawMode::standard, oil, T).value; };
  expect_slope(law, {240.0, 252.0, 255.0, 300.0, 350.0, 422.0, 424.0}, "Walther");
  expect_smooth(law, 200.0, 500.0, "Walther");
  EXPECT_TRUE(lubricant_viscosity_m2_per_s(LawMode::standard, oil, 450.0).flags & temperature_clamped);
  EXPECT_TRUE(lubricant_viscosity_m2_per_s(LawMode::as_published, reference_oil("VG32"), 450.0).flags & thin_film);
}

TEST(BearingFriction, viscous_torque_reference_values) {
  const BearingFriction bearing = reference_bearing();
  for (const ReferenceRow& row : reference_rows("viscous_torque")) {
    const double nu = row["viscosity_mm2_per_s"] * 1e-6, n = row["speed_rpm"];
    expect_close(1e3 * viscous_torque_Nm(LawMode::as_printed, bearing, nu, n), row["as_printed_Nmm"], "as printed");
    expect_close(1e3 * viscous_torque_Nm(LawMode::as_published, bearing, nu, n), row["as_published_Nmm"],
                 "as published");
    expect_close(1e3 * viscous_torque_Nm(LawMode::standard, bearing, nu, n), row["standard_Nmm"], "standard");
    BearingFriction unloaded = bearing;
    expect_close(bearing_heat_W(LawMode::as_printed, unloaded, nu, 0.0, 0.0, n).value, row["as_printed_W"],
                 "heat as printed");
    unloaded.load_factor = 0.0;  // the standard load keeps a rounded corner at zero
    expect_close(bearing_heat_W(LawMode::standard, unloaded, nu, 0.0, 0.0, n).value, row["standard_W"], "heat");
    const auto torque = [&](const auto& speed) {
      return viscous_torque_Nm(LawMode::standard, bearing, std::decay_t<decltype(speed)>(nu), speed);
    };
    EXPECT_NEAR(slope(torque, n) * n / torque(n), row["log_slope"], 1e-10);
  }
}

TEST(BearingFriction, printed_low_speed_branch_is_1_008e7_times_too_much) {
  BearingFriction bearing = reference_bearing();
  bearing.load_factor = 0.0;
  const double before = viscous_torque_Nm(LawMode::as_printed, bearing, 20e-6, 99.9999999);
  EXPECT_NEAR(before / viscous_torque_Nm(LawMode::as_printed, bearing, 20e-6, 100.0), 1.008e7, 1e3);
  expect_close(bearing_heat_W(LawMode::as_printed, bearing, 20e-6, 0.0, 0.0, 50.0).value, 391044.03, "50 rpm");
  EXPECT_NEAR(bearing_heat_W(LawMode::standard, bearing, 20e-6, 0.0, 0.0, 50.0).value, 0.039, 0.001);
}

TEST(BearingFriction, published_pair_jumps_at_2000) {
  const BearingFriction bearing = reference_bearing();
  EXPECT_NEAR(viscous_torque_Nm(LawMode::as_published, bearing, 20e-6, 100.0) /
                      viscous_torque_Nm(LawMode::as_published, bearing, 20e-6, 99.9999999) -
                  1.0,
              -0.0079, 1e-4);
}

TEST(BearingFriction, printed_heat_is_negative_in_reverse_and_the_others_are_even) {
  const BearingFriction bearing = reference_bearing();
  EXPECT_LT(bearing_heat_W(LawMode::as_printed, bearing, 20e-6, 250.0, 0.0, -6000.0).value, -4e7);
  for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
    EXPECT_EQ(bearing_heat_W(mode, bearing, 20e-6, 250.0, 0.0, -6000.0).value,
              bearing_heat_W(mode, bearing, 20e-6, 250.0, 0.0, 6000.0).value);
  }
}

TEST(BearingFriction, load_torque_reference_values) {
  for (const ReferenceRow& row : reference_rows("load_torque")) {
    BearingFriction bearing = reference_bearing(row["contact_angle_deg"]);
    for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
      const double load_N = friction_load_N(mode, bearing, row["axial_N"], row["radial_N"]);
      expect_close(load_N, row["load_N"], "P1");
      expect_close(1e3 * load_torque_Nm(bearing, load_N), row["torque_Nmm"], "M1");
      expect_close(load_torque_Nm(bearing, load_N) / (load_N * 0.065), row["factor"], "f1");
      bearing.viscous_factor = 0.0;
      expect_close(bearing_heat_W(mode, bearing, 20e-6, row["axial_N"], row["radial_N"], 6000.0).value,
                   row["heat_at_6000_rpm_W"], "Q");
    }
  }
}

/// Oil, viscous and load part together, against the temperature.
TEST(BearingFriction, heat_and_its_slope_by_temperature) {
  const BearingFriction bearing = reference_bearing();
  const Lubricant oil = reference_oil("VG32");
  const auto heat = [&](LawMode mode) {
    return [&, mode](const auto& T) {
      using Scalar = std::decay_t<decltype(T)>;
      const Scalar nu = lubricant_viscosity_m2_per_s(mode, oil, T).value;
      return bearing_heat_W(mode, bearing, nu, Scalar(250.0), 0.0, Scalar(6000.0)).value;
    };
  };
  for (const ReferenceRow& row : reference_rows("bearing_heat")) {
    const double T = row["temperature_C"] + celsius_zero_K;
    expect_close(1e6 * lubricant_viscosity_m2_per_s(LawMode::standard, oil, T).value, row["viscosity_mm2_per_s"], "nu");
    expect_close(heat(LawMode::standard)(T), row["standard_W"], "Q");
    expect_close(slope(heat(LawMode::standard), T), row["slope_W_per_K"], "dQ/dT");
    expect_close(heat(LawMode::as_printed)(T), row["as_printed_W"], "Q with 1.047e-4");
  }
  // A bearing that warms by 13 K loses a third of its heat.
  EXPECT_NEAR(1.0 - heat(LawMode::standard)(313.15) / heat(LawMode::standard)(300.15), 0.3216, 1e-3);
  expect_smooth(heat(LawMode::standard), 230.0, 480.0, "bearing heat by temperature");
}

TEST(BearingFriction, slopes_and_smoothness) {
  for (const bool inlet_shear : {false, true}) {
    BearingFriction bearing = reference_bearing();
    bearing.inlet_shear = inlet_shear;
    const auto by_speed = [&](const auto& n) {
      using Scalar = std::decay_t<decltype(n)>;
      return bearing_heat_W(LawMode::standard, bearing, Scalar(20e-6), Scalar(250.0), 100.0, n).value;
    };
    const auto by_axial = [&](const auto& Fa) {
      using Scalar = std::decay_t<decltype(Fa)>;
      return bearing_heat_W(LawMode::standard, bearing, Scalar(20e-6), Fa, 300.0, Scalar(3000.0)).value;
    };
    const auto by_axial_unloaded = [&](const auto& Fa) {
      return load_torque_Nm(bearing, friction_load_N(LawMode::standard, bearing, Fa, 0.0));
    };
    expect_slope(by_speed, {-8000.0, -0.5, 0.0, 0.3, 1.0, 50.0, 99.0, 101.0, 115.0, 24000.0}, "bearing by speed");
    expect_slope(by_axial, {-100.0, 50.0, 170.0, 250.0, 2000.0}, "bearing by axial load");
    expect_smooth(by_speed, -20000.0, 20000.0, "bearing by speed");
    expect_smooth(by_speed, 80.0, 130.0, "bearing through the regime limit");
    expect_smooth(by_speed, -2.0, 2.0, "bearing through standstill");
    expect_smooth(by_axial, -500.0, 1500.0, "bearing by axial load");
    expect_smooth(by_axial_unloaded, -500.0, 500.0, "load torque through zero load");
  }
}

TEST(BearingFriction, inlet_shear_reference_values) {
  for (const ReferenceRow& row : reference_rows("inlet_shear")) {
    expect_close(inlet_shear_factor(0.065, row["viscosity_mm2_per_s"] * 1e-6, row["speed_rpm"]), row["factor"], "phi");
  }
}

BearingPreload reference_preload(double initial_N) {
  BearingPreload preload;
  preload.balls = 18.0;
  preload.ball_diameter_m = 9.525e-3;
  preload.contact_angle_rad = 25.0 * degree;
  preload.initial_N = initial_N;
  preload.inner_radius_m = 0.0275;
  preload.outer_radius_m = 0.0375;
  return preload;
}

TEST(BearingPreload, reference_values) {
  for (const ReferenceRow& row : reference_rows("preload")) {
    const BearingPreload preload = reference_preload(row["initial_N"]);
    expect_close(ball_stiffness_N_per_m15(preload.ball_diameter_m) * std::pow(1e-3, 1.5), row["stiffness_N_per_mm15"],
                 "K");
    expect_close(1e3 * initial_approach_m(preload), row["approach_mm"], "approach");
    expect_close(preload_N(preload, 0.0, 0.0, 0.0, 0.0).value, row["initial_N"], "at assembly");
    expect_close(preload_N(preload, 2.0, 0.0, 0.0, 0.0).value, row["inner_ring_2_K_warmer_N"], "2 K");
    expect_close(preload_N(preload, 5.0, 0.0, 0.0, 0.0).value, row["inner_ring_5_K_warmer_N"], "5 K");
    expect_close(preload_N(preload, 10.0, 0.0, 0.0, 0.0).value, row["inner_ring_10_K_warmer_N"], "10 K");
  }
}

TEST(BearingPreload, slopes_smoothness_and_what_opens_it) {
  const BearingPreload rigid = reference_preload(250.0);
  BearingPreload spring = rigid;
  spring.spring_N_per_m = 1e5;
  for (const BearingPreload& preload : {rigid, spring}) {
    const auto by_inner = [&](const auto& rise) {
      using Scalar = std::decay_t<decltype(rise)>;
      return preload_N(preload, rise, Scalar(3.0), Scalar(2.0), Scalar(0.0)).value;
    };
    const auto by_displacement = [&](const auto& z) {
      using Scalar = std::decay_t<decltype(z)>;
      return preload_N(preload, Scalar(5.0), Scalar(3.0), Scalar(2.0), z).value;
    };
    expect_slope(by_inner, {-20.0, -5.0, 0.0, 30.0}, "preload by inner rise");
    expect_slope(by_displacement, {-3e-3, -2.5e-3, -1e-6, 0.0, 2e-6, 1e-3}, "preload by displacement");
    expect_smooth(by_inner, -30.0, 50.0, "preload by inner rise");
    expect_smooth(by_displacement, -4e-3, 1e-3, "preload by displacement");
    EXPECT_TRUE(preload_N(preload, 0.0, 0.0, 0.0, -1e-2).flags & joint_open);
  }
  // Springs do not feel the rings, and the balls' rise presses a rigid pair harder.
  EXPECT_EQ(preload_N(spring, 50.0, 0.0, 0.0, 0.0).value, 250.0);
  EXPECT_GT(preload_N(rigid, 0.0, 0.0, 5.0, 0.0).value, 250.0);
}

TEST(BearingConductance, reference_values_slopes_and_smoothness) {
  const BearingConductance bearing{18.0, 9.52e-3, 0.025};
  for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
    for (const ReferenceRow& row : reference_rows("bearing_conductance")) {
      expect_close(bearing_conductance_W_per_K(mode, bearing, row["speed_rpm"]).value, row["conductance_W_per_K"], "G");
    }
  }
  const auto law = [&](const auto& n) { return bearing_conductance_W_per_K(LawMode::standard, bearing, n).value; };
  expect_slope(law, {-5000.0, -15.0, 0.0, 5.0, 15.0, 20.0, 3000.0}, "G");
  expect_smooth(law, -3000.0, 3000.0, "G");
  expect_smooth(law, -30.0, 30.0, "G through standstill");
}

/// Where the balls orbit so slowly that the square root's argument would fall below 0.1: it stays there, and no lower.
TEST(BearingConductance, has_a_least_value_at_standstill) {
  const BearingConductance tiny{18.0, 9.52e-3, 1e-6};
  const double least = 590.0 * 18.0 * 9.52e-3 * 9.52e-3 * std::sqrt(0.1);
  expect_close(bearing_conductance_W_per_K(LawMode::standard, tiny, 0.0).value, least, "G");
}

/// Half to each race where the spin of the balls vanishes (90°), more to the inner one at flatter angles.
TEST(BearingFriction, inner_share_of_the_heat) {
  EXPECT_NEAR(inner_heat_share(4.76e-3, 0.0325, 90.0 * degree), 0.5, 1e-5);
  expect_close(inner_heat_share(4.76e-3, 0.0325, 25.0 * degree),
               0.5 + 1.08 * 4.76 / 32.5 * std::pow(1.0 - std::sin(25.0 * degree), 0.37), "25 degrees");
  EXPECT_GT(inner_heat_share(4.76e-3, 0.0325, 15.0 * degree), inner_heat_share(4.76e-3, 0.0325, 25.0 * degree));
}

TEST(FilmThickness, reference_values) {
  for (const ReferenceRow& row : reference_rows("film_thickness")) {
    expect_close(film_thickness_ratio(row["speed"], row["material"], row["load"], row["ellipticity"]), row["thickness"],
                 "H");
  }
}

}  // namespace laws_bearing_test
}  // namespace spindle_twin::rom::test
