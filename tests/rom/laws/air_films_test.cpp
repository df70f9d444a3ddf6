#include "rom/laws/air_gap.hpp"
#include "rom/laws/rotating_surface.hpp"
#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {
namespace laws_air_films_test {

double film(LawMode mode, RotationFormula formula, double n) {
  return rotating_cylinder_W_per_m2K(mode, {formula, 0.04}, n, room_K, 5.0).value;
}

TEST(RotatingCylinder, reference_values) {
  const auto gas = air(room_K);
  for (const ReferenceRow& row : reference_rows("rotating_cylinder_r40_mm")) {
    const double n = row["speed_rpm"], Re = n * std::numbers::pi / 30.0 * 0.0032 / gas.viscosity_m2_per_s;
    expect_close(Re, row["reynolds"], "Re");
    expect_close(becker_nusselt(Re, gas.prandtl), row["becker"], "Becker");
    expect_close(film(LawMode::as_published, RotationFormula::standard, n), row["becker_W_per_m2K"], "Becker");
    expect_close(dropkin_carmi_nusselt(Re) * gas.conductivity_W_per_mK / 0.08, row["dropkin_carmi_W_per_m2K"],
                 "Dropkin-Carmi");
    expect_close(film(LawMode::as_published, RotationFormula::dropkin_carmi, n), row["dropkin_carmi_W_per_m2K"],
                 "Dropkin-Carmi");
    expect_close(film(LawMode::as_published, RotationFormula::jungnickel, n), row["jungnickel_W_per_m2K"],
                 "Jungnickel");
    expect_close(jungnickel_cylinder_W_per_m2K(n * std::numbers::pi / 30.0, 0.04), row["jungnickel_W_per_m2K"],
                 "Jungnickel");
    expect_close(natural_cylinder_nusselt(gas, room_K, 0.08, 5.0).value, row["natural_at_5_K"], "natural");
    expect_close(film(LawMode::standard, RotationFormula::standard, n), row["standard_at_5_K_W_per_m2K"], "mixed");
  }
}

TEST(RotatingDisc, reference_values) {
  const auto gas = air(room_K);
  for (const ReferenceRow& row : reference_rows("rotating_disc_r50_mm")) {
    const double n = row["speed_rpm"], omega = n * std::numbers::pi / 30.0,
                 Re = omega * 0.0025 / gas.viscosity_m2_per_s;
    expect_close(Re, row["reynolds"], "Re");
    const double scale = gas.conductivity_W_per_mK / 0.05;
    expect_close(laminar_disc_nusselt(Re) * scale, row["laminar_W_per_m2K"], "laminar");
    expect_close(turbulent_disc_nusselt(Re) * scale, row["turbulent_W_per_m2K"], "turbulent");
    expect_close(jungnickel_disc_W_per_m2K(omega, 0.05), row["jungnickel_W_per_m2K"], "Jungnickel");
    const RotatingSurface rule{RotationFormula::jungnickel, 0.05};
    expect_close(rotating_disc_W_per_m2K(LawMode::as_published, rule, n, room_K, 5.0).value,
                 row["jungnickel_W_per_m2K"], "Jungnickel");
  }
}

TEST(RotatingDisc, far_from_the_crossing_it_is_the_larger_of_the_two_laws) {
  const RotatingSurface disc{RotationFormula::standard, 0.05};
  for (const ReferenceRow& row : reference_rows("rotating_disc_r50_mm")) {
    const double larger = std::max(row["laminar_W_per_m2K"], row["turbulent_W_per_m2K"]);
    if (std::abs(std::log(row["laminar_W_per_m2K"] / row["turbulent_W_per_m2K"])) < 0.2) continue;
    const double natural = natural_wall_nusselt(air(room_K), room_K, 0.05 * std::sqrt(std::numbers::pi), 5.0).value *
                           air(room_K).conductivity_W_per_mK / (0.05 * std::sqrt(std::numbers::pi));
    expect_close(rotating_disc_W_per_m2K(LawMode::standard, disc, row["speed_rpm"], room_K, 5.0).value,
                 std::cbrt(larger * larger * larger + natural * natural * natural), "mixed", 1e-12);
  }
}

template <class Film>
void check_surface(const Film& at, const std::string& what) {
  const auto by_speed = [&](const auto& n) {
    using Scalar = std::decay_t<decltype(n)>;
    return at(n, Scalar(305.0), Scalar(10.0));
  };
  const auto by_difference = [&](const auto& difference) {
    using Scalar = std::decay_t<decltype(difference)>;
    return at(Scalar(60.0), Scalar(305.0), difference);
  };
  const auto by_air = [&](const auto& T) {
    using Scalar = std::decay_t<decltype(T)>;
    return at(Scalar(3000.0), T, Scalar(10.0));
  };
  expect_slope(by_speed, {-6000.0, -1.0, 0.0, 1e-3, 40.0, 1500.0, 3000.0, 24000.0}, what + " by speed");
  expect_slope(by_difference, {-30.0, -0.15, 0.0, 0.05, 0.12, 3.0, 80.0}, what + " by difference");
  expect_slope(by_air, {199.0, 280.0, 350.0, 620.0}, what + " by air");
  expect_smooth(by_speed, -20000.0, 20000.0, what + " by speed");
  expect_smooth(by_speed, -100.0, 100.0, what + " through standstill");
  expect_smooth(by_difference, -50.0, 50.0, what + " by difference");
  expect_smooth(by_difference, -0.5, 0.5, what + " through no difference");
  expect_smooth(by_air, 150.0, 650.0, what + " by air");
  EXPECT_GT(by_speed(0.0), 0.5);  // natural convection remains
}

TEST(RotatingSurfaces, slopes_and_smoothness_of_every_formula) {
  for (const RotationFormula formula :
       {RotationFormula::standard, RotationFormula::dropkin_carmi, RotationFormula::jungnickel}) {
    check_surface(
        [=](const auto& n, const auto& T, const auto& d) {
          return rotating_cylinder_W_per_m2K(LawMode::standard, {formula, 0.04}, n, T, d).value;
        },
        "cylinder");
    check_surface(
        [=](const auto& n, const auto& T, const auto& d) {
          return rotating_disc_W_per_m2K(LawMode::standard, {formula, 0.05}, n, T, d).value;
        },
        "disc");
  }
  const auto still = [](const auto& d) {
    return still_cylinder_W_per_m2K(0.088, std::decay_t<decltype(d)>(300.0), d).value;
  };
  expect_slope(still, {-20.0, -0.1, 0.0, 0.15, 30.0}, "natural convection");
  expect_smooth(still, -40.0, 40.0, "natural convection");
  EXPECT_TRUE(
      rotating_cylinder_W_per_m2K(LawMode::standard, {RotationFormula::standard, 0.04}, 1e5, room_K, 5.0).flags &
      above_range);
}

TEST(AirGap, reference_values) {
  const double nu = air(room_K).viscosity_m2_per_s;
  for (const ReferenceRow& row : reference_rows("air_gap_r40_mm")) {
    const double omega = row["speed_rpm"] * std::numbers::pi / 30.0, delta = row["gap_m"];
    const double Ta = omega * omega * 0.04 * delta * delta * delta / (nu * nu);
    expect_close(Ta, row["taylor"], "Ta");
    expect_close(gap_nusselt(LawMode::as_published, Ta).value, row["as_published"], "as published");
    expect_close(gap_nusselt(LawMode::standard, Ta).value, row["standard"], "standard");
    expect_close(air_gap_W_per_m2K(LawMode::standard, {0.04, delta, 0.0}, row["speed_rpm"], room_K, room_K).value,
                 row["standard_W_per_m2K"], "wall to wall");
  }
}

TEST(AirGap, slopes_smoothness_and_flags) {
  const AirGap gap{0.04, 0.0005, 1.17e-5};
  const auto film_of = [&](const auto& n, const auto& rotor) {
    using Scalar = std::decay_t<decltype(n)>;
    return air_gap_W_per_m2K(LawMode::standard, gap, n, Scalar(rotor), Scalar(310.0)).value;
  };
  const auto by_speed = [&](const auto& n) { return film_of(n, 330.0); };
  const auto by_rotor = [&](const auto& T) {
    using Scalar = std::decay_t<decltype(T)>;
    return film_of(Scalar(5000.0), T);
  };
  expect_slope(by_speed, {-9000.0, 0.0, 2700.0, 3000.0, 7000.0, 8000.0, 30000.0}, "air gap by speed");
  expect_slope(by_rotor, {290.0, 340.0, 500.0, 1300.0, 1500.0}, "air gap by rotor");
  expect_smooth(by_speed, -30000.0, 30000.0, "air gap by speed");
  expect_smooth(by_rotor, 250.0, 1600.0, "air gap by rotor");
  EXPECT_TRUE(air_gap_W_per_m2K(LawMode::standard, gap, 5000.0, 1500.0, 310.0).flags & shape_out_of_range);
  EXPECT_TRUE(gap_nusselt(LawMode::standard, 2e7).flags & above_range);
}

TEST(AirGap, published_pieces_jump_where_they_are_said_to) {
  const auto step = [](double at) {
    return gap_nusselt(LawMode::as_published, at).value / gap_nusselt(LawMode::as_published, at * (1.0 - 1e-12)).value -
           1.0;
  };
  EXPECT_NEAR(step(1700.0), -0.019, 5e-4);
  EXPECT_NEAR(step(1e4), 0.0012, 1e-4);
}

TEST(EndWinding, reference_values_slopes_and_smoothness) {
  for (const ReferenceRow& row : reference_rows("end_winding")) {
    for (const LawMode mode : {LawMode::standard, LawMode::as_published}) {
      expect_close(end_winding_W_per_m2K(mode, EndWinding{}, row["speed_m_per_s"]).value, row["film_W_per_m2K"],
                   "film");
    }
  }
  const auto law = [](const auto& v) { return end_winding_W_per_m2K(LawMode::standard, EndWinding{}, v).value; };
  expect_slope(law, {-20.0, -0.05, 0.0, 0.02, 0.1, 30.0}, "end winding");
  expect_smooth(law, -40.0, 40.0, "end winding");
  expect_smooth(law, -0.3, 0.3, "end winding through standstill");
}

}  // namespace laws_air_films_test
}  // namespace spindle_twin::rom::test
