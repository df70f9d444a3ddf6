// Thermoelastic growth against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/verification/concentric_rings.hpp"
#include "tests/verification/nominal.hpp"

namespace spindle_twin::fem_offline {
namespace closed_form_growth_test {

DeformationOutput output(const std::string& name, const Box& face, Direction direction) {
  DeformationOutput result;
  result.name = name;
  result.face = face;
  result.direction = direction;
  return result;
}

/// One part of revolution, u_z = 0 on its face z = 0, film to 20 degC all around.
Spindle standing_cylinder(double r0_m, double r1_m, double length_m, double expansion_per_K) {
  Spindle spindle;
  spindle.name = "cylinder";
  spindle.materials = {steel("steel", 48.0)};
  spindle.materials[0].youngs_modulus_Pa = 219e9;
  spindle.materials[0].poisson_ratio = 0.3;
  spindle.materials[0].expansion_per_K = expansion_per_K;
  Part part;
  part.name = "cylinder";
  part.shapes = {rectangle(r0_m, r1_m, 0.0, length_m)};
  spindle.parts = {part};
  Surrounding room;
  room.name = "room";
  spindle.surroundings = {room};
  Film film;
  film.name = "outside";
  film.coefficient_W_per_m2K = 10.0;
  film.regions = {{0.0, r1_m, -1.0, 0.0}, {0.0, r1_m, length_m, 1.0}, {r1_m, 1.0, 0.0, length_m}};
  if (r0_m > 0.0) film.regions.push_back({0.0, r0_m, 0.0, length_m});
  spindle.films = {film};
  Support support;
  support.face = {r0_m, r1_m, 0.0, 0.0};
  spindle.supports = {support};
  spindle.operating.reference_temperature_K = 293.15;
  spindle.operating.surrounding_K = {293.15};
  return spindle;
}

template <typename Rise>
Eigen::VectorXd rises(const AffineModel& model, Rise rise_K) {
  Eigen::VectorXd field_K(static_cast<Eigen::Index>(model.places.size()));
  for (Eigen::Index i = 0; i < field_K.size(); ++i) field_K[i] = rise_K(model.places[static_cast<std::size_t>(i)]);
  return field_K;
}

TEST(FreeBar, uniform_rise_grows_it_by_alpha_L) {
  Spindle spindle = standing_cylinder(0.0, 0.02, 0.4, 1.17e-5);
  spindle.deformations = {output("tip", {0.0, 0.02, 0.4, 0.4}, Direction::axial)};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = rises(model.affine(), [](const DofPlace&) { return 10.0; });
  EXPECT_NEAR(model.affine().deformations[0].row_m_per_K.dot(field_K), 46.8e-6, 1e-12);
}

/// Exact for any radius: the adjoint state of the mean tip displacement is uniaxial tension.
TEST(FreeBar, linear_rise_grows_it_by_alpha_times_the_mean) {
  Spindle spindle = standing_cylinder(0.0, 0.02, 0.1, 1.17e-5);
  spindle.deformations = {output("tip", {0.0, 0.02, 0.1, 0.1}, Direction::axial)};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = rises(model.affine(), [](const DofPlace& at) { return 15.19 * at.z_m / 0.1; });
  EXPECT_NEAR(model.affine().deformations[0].row_m_per_K.dot(field_K), 8.88615e-6, 1e-12);
}

TEST(HollowRing, uniform_rise_widens_both_radii_by_alpha_r) {
  Spindle spindle = standing_cylinder(0.03, 0.05, 0.04, 1.2e-5);
  spindle.deformations = {output("bore", {0.03, 0.03, 0.0, 0.04}, Direction::radial),
                          output("outside", {0.05, 0.05, 0.0, 0.04}, Direction::radial)};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = rises(model.affine(), [](const DofPlace&) { return 1.0; });
  EXPECT_NEAR(model.affine().deformations[0].row_m_per_K.dot(field_K), 1.2e-5 * 0.03, 1e-13);
  EXPECT_NEAR(model.affine().deformations[1].row_m_per_K.dot(field_K), 1.2e-5 * 0.05, 1e-13);
}

/// Timoshenko's long hollow cylinder with a logarithmic rise, 10 K at the bore, 0 outside, ends free on average. The
/// radii are read in the middle of a length of eight radii, where the ends no longer count.
TEST(HollowCylinder, logarithmic_rise_gives_timoshenko_growth) {
  constexpr double a_m = 0.02, b_m = 0.04, length_m = 0.32;
  Spindle spindle = standing_cylinder(a_m, b_m, length_m, 1.2e-5);
  spindle.mesh.element_size_m = 0.0025;
  spindle.deformations = {output("tip", {a_m, b_m, length_m, length_m}, Direction::axial),
                          output("bore", {a_m, a_m, 0.159, 0.161}, Direction::radial),
                          output("outside", {b_m, b_m, 0.159, 0.161}, Direction::radial)};
  const FeModel model(spindle, build_section(spindle));
  const AffineModel& affine = model.affine();
  const Eigen::VectorXd field_K =
      rises(affine, [](const DofPlace& at) { return 10.0 * std::log(b_m / at.r_m) / std::log(b_m / a_m); });
  EXPECT_NEAR(affine.deformations[0].row_m_per_K.dot(field_K), 3.2 * 4.656170e-6, 2e-10);
  EXPECT_NEAR(affine.deformations[1].row_m_per_K.dot(field_K), 0.9312340e-6, 2e-10);
  EXPECT_NEAR(affine.deformations[2].row_m_per_K.dot(field_K), 1.8624681e-6, 2e-10);
}

/// The same as generalised plane strain: one slice between two faces that stay plane, so that no end disturbs it.
TEST(HollowCylinder, logarithmic_rise_gives_timoshenko_stresses_in_a_slice_that_stays_plane) {
  constexpr double a_m = 0.02, b_m = 0.04, length_m = 0.1;
  Spindle spindle = standing_cylinder(a_m, b_m, length_m, 1.2e-5);
  spindle.mesh.element_size_m = 0.0005;
  Support plane;
  plane.face = {a_m, b_m, length_m, length_m};
  plane.hold_z = Hold::plane;
  spindle.supports.push_back(plane);
  spindle.imposed_temperature = ImposedTemperature{"10 * ln(0.04 / r) / ln(2)", {}};
  spindle.deformations = {output("tip", {a_m, b_m, length_m, length_m}, Direction::axial),
                          output("bore", {a_m, a_m, 0.0, length_m}, Direction::radial),
                          output("outside", {b_m, b_m, 0.0, length_m}, Direction::radial)};
  spindle.stress_probes = {{"bore", 0, {a_m, 0.05}, {}}, {"outside", 0, {b_m, 0.05}, {}}};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd steady_K = solve_steady(model.affine(), nominal_values(model.affine()));
  const Eigen::VectorXd rises_K = steady_K.array() - 293.15;
  EXPECT_NEAR(model.affine().deformations[0].row_m_per_K.dot(rises_K), 4.656170e-6, 1e-6 * 4.656170e-6);
  EXPECT_NEAR(model.affine().deformations[1].row_m_per_K.dot(rises_K), 0.9312340e-6, 1e-6 * 0.9312340e-6);
  EXPECT_NEAR(model.affine().deformations[2].row_m_per_K.dot(rises_K), 1.8624681e-6, 1e-6 * 1.8624681e-6);
  const auto probed = model.probed_stresses(steady_K);
  EXPECT_NEAR(probed[0].stress.tt_Pa, -22.97570e6, 1e-3 * 22.97570e6);
  EXPECT_NEAR(probed[0].stress.zz_Pa, -22.97570e6, 1e-3 * 22.97570e6);
  EXPECT_NEAR(probed[0].stress.rr_Pa, 0.0, 1e-3 * 22.97570e6);
  EXPECT_NEAR(von_mises_Pa(probed[0].stress), 22.97570e6, 1e-3 * 22.97570e6);
  EXPECT_NEAR(probed[1].stress.tt_Pa, 14.56716e6, 1e-3 * 14.56716e6);
  EXPECT_NEAR(probed[1].stress.zz_Pa, 14.56716e6, 1e-3 * 14.56716e6);
}

/// NAFEMS LE11: solid cylinder, taper and sphere, rise r + z in metres, both ends held along z.
TEST(NafemsLe11, axial_stress_at_the_inner_corner_is_minus_105_MPa) {
  Spindle spindle = standing_cylinder(0.7, 1.4, 1.79711, 2.3e-4);
  spindle.materials[0].youngs_modulus_Pa = 210e9;
  Polygon outline;
  const auto add_arc = [&](double radius_m, double from, double to) {
    constexpr int chords = 24;
    for (int k = 0; k <= chords; ++k) {
      const double angle = from + (to - from) * k / chords;
      outline.push_back({radius_m * std::cos(angle), radius_m * std::sin(angle)});
    }
  };
  add_arc(1.4, 0.0, std::atan2(0.7071, 1.2083));
  outline.push_back({1.0, 1.39711});
  outline.push_back({1.0, 1.79711});
  outline.push_back({0.70711, 1.79711});
  add_arc(1.0, std::numbers::pi / 4.0, 0.0);
  spindle.parts[0].shapes = {outline};
  spindle.films.clear();
  Adiabatic all;
  all.name = "all";
  all.regions = {{0.0, 10.0, -10.0, 10.0}};
  spindle.adiabatics = {all};
  spindle.mesh.element_size_m = 0.05;
  spindle.supports[0].face = {0.0, 2.0, 0.0, 0.0};
  Support top = spindle.supports[0];
  top.face = {0.0, 2.0, 1.79711, 1.79711};
  spindle.supports.push_back(top);
  spindle.imposed_temperature = ImposedTemperature{"r + z", {}};
  spindle.stress_probes = {{"A", 0, {1.0, 0.0}, {}}};
  const FeModel model(spindle, build_section(spindle));
  const auto probed = model.probed_stresses(solve_steady(model.affine(), nominal_values(model.affine())));
  EXPECT_NEAR(probed[0].stress.zz_Pa, -105e6, 0.015 * 105e6);
}

/// Fin: base heat Q, film h on the side, adiabatic tip. Whatever the length, all heat leaves through the side, so the
/// surface's rise integrates to Q/(h π D) along z and the growth is α Q/(h π D), up to the Biot number.
TEST(Fin, growth_is_alpha_Q_over_h_pi_D) {
  for (const double conductivity_W_per_mK : {15.0, 48.0}) {
    Spindle spindle = standing_cylinder(0.0, 0.02, 0.3, 1.17e-5);
    spindle.materials[0].conductivity_r_W_per_mK = spindle.materials[0].conductivity_z_W_per_mK = conductivity_W_per_mK;
    spindle.films[0].coefficient_W_per_m2K = 20.0;
    spindle.films[0].regions = {{0.02, 1.0, 0.0, 0.3}};
    Adiabatic ends;
    ends.name = "ends";
    ends.regions = {{0.0, 0.02, -1.0, 0.0}, {0.0, 0.02, 0.3, 1.0}};
    spindle.adiabatics = {ends};
    HeatSource base;
    base.name = "base";
    base.heat_W = 50.0;
    HeatShare share;
    share.on_face = Box{0.0, 0.02, 0.0, 0.0};
    base.shares = {share};
    spindle.heats = {base};
    spindle.deformations = {output("tip", {0.0, 0.02, 0.3, 0.3}, Direction::axial)};
    const FeModel model(spindle, build_section(spindle));
    const Eigen::VectorXd steady_K = solve_steady(model.affine(), nominal_values(model.affine()));
    // The film sees the surface, the growth the volume: integrated over z, the radial drop adds exactly h R / 4k.
    const double growth_m = model.affine().deformations[0].row_m_per_K.dot((steady_K.array() - 293.15).matrix());
    const double exact_m = 232.764104e-6 * (1.0 + 20.0 * 0.02 / (4.0 * conductivity_W_per_mK));
    EXPECT_NEAR(growth_m, exact_m, 1e-7 * exact_m);
  }
}

TEST(FreeBar, without_support_is_an_error_that_names_the_part) {
  Spindle spindle = standing_cylinder(0.0, 0.02, 0.1, 1.17e-5);
  spindle.deformations = {output("tip", {0.0, 0.02, 0.1, 0.1}, Direction::axial)};
  const Section section = build_section(spindle);
  spindle.supports.clear();
  try {
    const FeModel model(spindle, section);
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cylinder: free to move along z"), std::string::npos) << error.what();
  }
}

}  // namespace closed_form_growth_test
}  // namespace spindle_twin::fem_offline
