#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "rom/laws/air_gap.hpp"
#include "rom/laws/bearing_friction.hpp"
#include "rom/laws/contact_conductance.hpp"
#include "rom/laws/fluid.hpp"
#include "rom/laws/motor_loss.hpp"
#include "rom/laws/rotating_surface.hpp"
#include "rom/laws/windage.hpp"
#include "tests/rom/laws/law_checks.hpp"

/// Each law says that it is outside its range from the number on that its header states, and not before.
namespace spindle_twin::rom::test {
namespace laws_ranges_test {

/// Where, between a number that is not flagged and one that is, `flag` is raised, to 1e-9 of it.
double raised_at(const std::function<std::uint16_t(double)>& flags, std::uint16_t flag, double without, double with) {
  EXPECT_EQ(flags(without) & flag, 0) << without;
  EXPECT_NE(flags(with) & flag, 0) << with;
  while (std::abs(with - without) > 1e-9 * std::abs(with)) {
    const double middle = 0.5 * (without + with);
    ((flags(middle) & flag) != 0 ? with : without) = middle;
  }
  return with;
}

double omega(double speed_rpm) { return speed_rpm * std::numbers::pi / 30.0; }

TEST(Ranges, of_air_friction_end_at_the_reynolds_numbers_that_are_said) {
  const WindageShape shape{0.04, 0.0005, 0.15};
  const double viscosity_m2_per_s = air(room_K).viscosity_m2_per_s;
  const auto gap = [&](double rpm) { return gap_windage_W(LawMode::standard, shape, rpm, room_K).flags; };
  const double gap_rpm = raised_at(gap, above_range, 6000.0, 1e8);
  EXPECT_NEAR(omega(gap_rpm) * 0.04 * 0.0005 / viscosity_m2_per_s, 1e6, 1.0);
  const auto end = [&](double rpm) { return end_windage_W(LawMode::standard, shape, rpm, room_K).flags; };
  const double end_rpm = raised_at(end, above_range, 6000.0, 1e8);
  EXPECT_NEAR(omega(end_rpm) * 0.04 * 0.04 / viscosity_m2_per_s, 1e7, 10.0);
}

TEST(Ranges, of_rotating_surfaces_end_at_the_reynolds_numbers_that_are_said) {
  const RotatingSurface surface{RotationFormula::standard, 0.04};
  const double viscosity_m2_per_s = air(room_K).viscosity_m2_per_s;
  const auto cylinder = [&](double rpm) {
    return rotating_cylinder_W_per_m2K(LawMode::standard, surface, rpm, room_K, 20.0).flags;
  };
  const double cylinder_rpm = raised_at(cylinder, above_range, 6000.0, 1e8);
  EXPECT_NEAR(omega(cylinder_rpm) * 2.0 * 0.04 * 0.04 / viscosity_m2_per_s, 4e5, 1.0);
  const auto disc = [&](double rpm) {
    return rotating_disc_W_per_m2K(LawMode::standard, surface, rpm, room_K, 20.0).flags;
  };
  const double disc_rpm = raised_at(disc, above_range, 6000.0, 1e8);
  EXPECT_NEAR(omega(disc_rpm) * 0.04 * 0.04 / viscosity_m2_per_s, 1e7, 10.0);
}

TEST(Ranges, of_the_air_gap_and_the_end_windings_end_at_a_taylor_number_and_a_speed) {
  const auto gap = [](double taylor) { return gap_nusselt(LawMode::standard, taylor).flags; };
  EXPECT_NEAR(raised_at(gap, above_range, 1e6, 1e9), 1e7, 1.0);
  const auto winding = [](double speed_m_per_s) {
    return end_winding_W_per_m2K(LawMode::standard, EndWinding{}, speed_m_per_s).flags;
  };
  EXPECT_NEAR(raised_at(winding, above_range, 10.0, 1000.0), 100.0, 1e-5);
  EXPECT_NEAR(raised_at(winding, above_range, -10.0, -1000.0), -100.0, 1e-5);
}

TEST(Ranges, of_motor_losses_end_at_a_frequency_a_flux_and_two_temperatures) {
  const auto iron = [](double frequency_Hz, double flux_T) {
    return iron_loss_W(LawMode::standard, IronLoss{}, frequency_Hz, flux_T).flags;
  };
  EXPECT_NEAR(raised_at([&](double f_Hz) { return iron(f_Hz, 1.0); }, above_range, 100.0, 1e5), 2000.0, 1e-4);
  EXPECT_NEAR(raised_at([&](double flux_T) { return iron(100.0, flux_T); }, above_range, 1.0, 10.0), 2.0, 1e-7);
  const auto copper = [](double T_K) { return copper_loss_W(LawMode::standard, CopperLoss{}, 1.0, T_K).flags; };
  EXPECT_NEAR(raised_at(copper, temperature_clamped, room_K, 1000.0), 493.15, 1e-5);
  EXPECT_NEAR(raised_at(copper, temperature_clamped, room_K, 100.0), 223.15, 1e-5);
}

TEST(Ranges, of_bearings_and_joints_end_at_a_speed_a_film_and_two_pressures) {
  BearingFriction bearing;
  bearing.pitch_diameter_m = 0.08;
  const auto by_speed = [&](double rpm) {
    return bearing_heat_W(LawMode::standard, bearing, 2e-5, 100.0, 0.0, rpm).flags;
  };
  EXPECT_NEAR(raised_at(by_speed, above_range, 6000.0, 1e6), 1e6 / 80.0, 1e-3);
  const auto by_film = [&](double viscosity_m2_per_s) {
    return bearing_heat_W(LawMode::standard, bearing, viscosity_m2_per_s, 100.0, 0.0, 6000.0).flags;
  };
  EXPECT_NEAR(raised_at(by_film, thin_film, 2e-5, 1e-7), 2e-6, 1e-13);
  bearing.inlet_shear = true;
  EXPECT_EQ(by_speed(1e6) & above_range, 0) << "with the inlet shear factor";
  const ContactSurfaces surfaces;
  const auto joint = [&](double pressure_Pa) {
    return contact_conductance_W_per_m2K(LawMode::standard, surfaces, pressure_Pa, 0.0).flags;
  };
  const double middle_Pa = 1e-3 * surfaces.hardness_Pa;
  EXPECT_NEAR(raised_at(joint, above_range, middle_Pa, surfaces.hardness_Pa) / surfaces.hardness_Pa, 2.3e-2, 1e-9);
  EXPECT_NEAR(raised_at(joint, below_range, middle_Pa, 1e-9 * surfaces.hardness_Pa) / surfaces.hardness_Pa, 1e-6,
              1e-13);
}

}  // namespace laws_ranges_test
}  // namespace spindle_twin::rom::test
