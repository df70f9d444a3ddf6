// Supports, outputs, contact pressures and stresses against closed forms.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <utility>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "tests/fem_offline/description/sample_spindle.hpp"
#include "tests/verification/concentric_rings.hpp"
#include "tests/verification/nominal.hpp"

namespace spindle_twin::fem_offline {
namespace model_mechanics_test {

constexpr double reference_K = 293.15;

/// One part of any outline without heat flow, steel of E = 200 GPa, nu = 0.3, alpha = 1.2e-5.
Spindle bare_part(const Polygon& outline, Geometry geometry = Geometry::axisymmetric) {
  Spindle spindle;
  spindle.name = "bare part";
  spindle.geometry = geometry;
  spindle.materials = {steel("steel", 48.0)};
  spindle.materials[0].youngs_modulus_Pa = 200e9;
  spindle.materials[0].poisson_ratio = 0.3;
  spindle.materials[0].expansion_per_K = 1.2e-5;
  Part part;
  part.name = "bar";
  part.shapes = {outline};
  spindle.parts = {part};
  Surrounding room;
  room.name = "room";
  spindle.surroundings = {room};
  Adiabatic all;
  all.name = "all";
  all.regions = {{-10.0, 10.0, -10.0, 10.0}};
  spindle.adiabatics = {all};
  spindle.operating.reference_temperature_K = reference_K;
  spindle.operating.surrounding_K = {reference_K};
  return spindle;
}

Support support_on(const Box& face, Hold hold_r, Hold hold_z, std::size_t part = 0) {
  Support support;
  support.part = part;
  support.face = face;
  support.hold_r = hold_r;
  support.hold_z = hold_z;
  return support;
}

DeformationOutput output_on(const std::string& name, const Box& face, Direction direction) {
  DeformationOutput output;
  output.name = name;
  output.face = face;
  output.direction = direction;
  return output;
}

DeformationOutput output_at(const std::string& name, const Point& at, Direction direction) {
  DeformationOutput output;
  output.name = name;
  output.at = at;
  output.direction = direction;
  return output;
}

Eigen::VectorXd temperatures(const AffineModel& model, const std::function<double(const DofPlace&)>& rise_K) {
  Eigen::VectorXd field_K = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(model.places.size()), reference_K);
  for (Eigen::Index i = 0; i < field_K.size(); ++i) field_K[i] += rise_K(model.places[static_cast<std::size_t>(i)]);
  return field_K;
}

double moved_m(const FeModel& model, std::size_t output, const Eigen::VectorXd& temperatures_K) {
  return model.affine().deformations[output].row_m_per_K.dot((temperatures_K.array() - reference_K).matrix());
}

double pressure_Pa(const FeModel& model, std::size_t output, const Eigen::VectorXd& temperatures_K) {
  const FeContactPressure& pressure = model.affine().contact_pressures[output];
  return pressure.assembly_pressure_Pa + pressure.row_Pa_per_K.dot((temperatures_K.array() - reference_K).matrix());
}

std::string refusal(const Spindle& spindle) {
  try {
    const FeModel model(spindle, build_section(spindle));
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// Bar of stiffness EA/L between the ground and a spring: the spring takes s·u, so u = α ΔT L / (1 + s L/EA).
TEST(Support, spring_against_a_growing_bar_shares_the_growth_by_stiffness) {
  constexpr double radius_m = 0.02, length_m = 0.1;
  const double bar_N_per_m = 200e9 * std::numbers::pi * radius_m * radius_m / length_m;
  for (const double share : {0.1, 1.0, 30.0}) {
    Spindle spindle = bare_part(rectangle(0.0, radius_m, 0.0, length_m));
    spindle.materials[0].poisson_ratio = 0.0;  // the ends stay plane, so that the rod formula is exact
    Support spring = support_on({0.0, radius_m, length_m, length_m}, Hold::free, Hold::spring);
    spring.stiffness_z_N_per_m = share * bar_N_per_m;
    spindle.supports = {support_on({0.0, radius_m, 0.0, 0.0}, Hold::free, Hold::fixed), spring};
    spindle.deformations = {output_on("tip", {0.0, radius_m, length_m, length_m}, Direction::axial)};
    const FeModel model(spindle, build_section(spindle));
    const Eigen::VectorXd field_K = temperatures(model.affine(), [](const DofPlace&) { return 10.0; });
    const double exact_m = 1.2e-5 * 10.0 * length_m / (1.0 + share);
    EXPECT_NEAR(moved_m(model, 0, field_K), exact_m, 1e-9 * exact_m);
  }
}

/// Held at both ends with free sides: σ_zz = −E α ΔT everywhere, nothing else.
TEST(Support, held_bar_carries_E_alpha_dT_and_no_more) {
  Spindle spindle = bare_part(rectangle(0.01, 0.02, 0.0, 0.1));
  spindle.supports = {support_on({0.01, 0.02, 0.0, 0.0}, Hold::free, Hold::fixed),
                      support_on({0.01, 0.02, 0.1, 0.1}, Hold::free, Hold::fixed)};
  spindle.stress_probes = {{"middle", 0, {0.0137, 0.0512}, {}}};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = temperatures(model.affine(), [](const DofPlace&) { return 10.0; });
  const Stress stress = model.probed_stresses(field_K).at(0).stress;
  EXPECT_NEAR(stress.zz_Pa, -200e9 * 1.2e-4, 1.0);
  EXPECT_NEAR(stress.rr_Pa, 0.0, 1.0);
  EXPECT_NEAR(stress.tt_Pa, 0.0, 1.0);
  EXPECT_NEAR(stress.rz_Pa, 0.0, 1.0);
  EXPECT_NEAR(von_mises_Pa(stress), 200e9 * 1.2e-4, 1.0);
  EXPECT_EQ(model.stresses_Pa(field_K).cols(), 4);
}

TEST(FeModel, that_gave_up_displacements_and_stresses_refuses_them_and_keeps_its_rows) {
  Spindle spindle = bare_part(rectangle(0.01, 0.02, 0.0, 0.1));
  spindle.supports = {support_on({0.01, 0.02, 0.0, 0.0}, Hold::free, Hold::fixed)};
  spindle.stress_probes = {{"middle", 0, {0.0137, 0.0512}, {}}};
  FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = temperatures(model.affine(), [](const DofPlace&) { return 10.0; });
  EXPECT_GT(model.displacements_m(field_K).cwiseAbs().maxCoeff(), 0.0);
  model.forget_growth();
  EXPECT_THROW(model.displacements_m(field_K), std::logic_error);
  EXPECT_THROW(model.stresses_Pa(field_K), std::logic_error);
  const auto unknowns = model.affine().places.size();
  EXPECT_EQ(std::move(model).affine().places.size(), unknowns);
}

/// Held at one point of its outline, a free bar grows both ways from there; a point in the middle of a face moves too.
TEST(Support, point_holds_without_straining_and_differences_are_what_grows_between) {
  Spindle spindle = bare_part(rectangle(0.0, 0.02, 0.0, 0.1));
  spindle.mesh.element_size_m = 0.007;
  spindle.supports = {support_on({0.02, 0.02, 0.033, 0.033}, Hold::free, Hold::fixed)};
  spindle.deformations = {output_at("front", {0.02, 0.0}, Direction::axial),
                          output_at("rear", {0.013, 0.1}, Direction::axial),
                          output_at("seat", {0.02, 0.061}, Direction::radial)};
  DeformationOutput shift = output_at("shift", {0.013, 0.1}, Direction::axial);
  shift.minus = 0;
  spindle.deformations.push_back(shift);
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = temperatures(model.affine(), [](const DofPlace&) { return 10.0; });
  EXPECT_NEAR(moved_m(model, 0, field_K), -1.2e-4 * 0.033, 1e-14);
  EXPECT_NEAR(moved_m(model, 1, field_K), 1.2e-4 * 0.067, 1e-14);
  EXPECT_NEAR(moved_m(model, 2, field_K), 1.2e-4 * 0.02, 1e-14);
  EXPECT_NEAR(moved_m(model, 3, field_K), 1.2e-4 * 0.1, 1e-14);
}

TEST(Support, radially_held_bore_turns_all_growth_outwards) {
  Spindle spindle = bare_part(rectangle(0.03, 0.05, 0.0, 0.04));
  spindle.supports = {support_on({0.03, 0.03, 0.0, 0.04}, Hold::fixed, Hold::free),
                      support_on({0.03, 0.05, 0.0, 0.0}, Hold::free, Hold::fixed)};
  spindle.deformations = {output_on("bore", {0.03, 0.03, 0.0, 0.04}, Direction::radial),
                          output_on("outside", {0.05, 0.05, 0.0, 0.04}, Direction::radial)};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = temperatures(model.affine(), [](const DofPlace&) { return 10.0; });
  EXPECT_NEAR(moved_m(model, 0, field_K), 0.0, 1e-16);
  EXPECT_GT(moved_m(model, 1, field_K), 1.2e-4 * 0.02);
}

TEST(Support, free_rigid_motion_is_one_error_that_names_the_part) {
  Spindle spindle = bare_part(rectangle(0.01, 0.02, 0.0, 0.1));
  spindle.deformations = {output_on("tip", {0.01, 0.02, 0.1, 0.1}, Direction::axial)};
  const std::string free_along_z = "bar: free to move along z";
  EXPECT_NE(refusal(spindle).find(free_along_z), std::string::npos) << refusal(spindle);
  spindle.supports = {support_on({0.01, 0.02, 0.0, 0.0}, Hold::free, Hold::plane)};
  EXPECT_NE(refusal(spindle).find(free_along_z), std::string::npos) << refusal(spindle);
  spindle.supports = {support_on({0.01, 0.01, 0.0, 0.1}, Hold::fixed, Hold::free)};
  EXPECT_NE(refusal(spindle).find(free_along_z), std::string::npos) << refusal(spindle);
  spindle.supports[0].hold_z = Hold::spring;
  spindle.supports[0].stiffness_z_N_per_m = 1e6;
  EXPECT_EQ(refusal(spindle), "accepted");

  Spindle plate = bare_part(rectangle(0.01, 0.02, 0.0, 0.1), Geometry::planar);
  plate.deformations = {output_on("tip", {0.01, 0.02, 0.1, 0.1}, Direction::axial)};
  plate.supports = {support_on({0.01, 0.02, 0.0, 0.0}, Hold::free, Hold::fixed)};
  EXPECT_NE(refusal(plate).find("bar: free to move as a rigid body"), std::string::npos) << refusal(plate);
  plate.supports = {support_on({0.01, 0.01, 0.0, 0.0}, Hold::fixed, Hold::fixed)};  // it can still turn about the point
  EXPECT_NE(refusal(plate).find("bar: free to move as a rigid body"), std::string::npos) << refusal(plate);
  plate.supports.push_back(support_on({0.02, 0.02, 0.0, 0.0}, Hold::free, Hold::fixed));
  EXPECT_EQ(refusal(plate), "accepted");
}

/// Plane strain: no strain along the depth, so the section grows by (1 + ν) α ΔT and carries σ = −E α ΔT along it.
TEST(Planar, free_plate_grows_by_one_plus_nu_and_is_pressed_along_its_depth) {
  Spindle spindle = bare_part(rectangle(-0.02, 0.03, -0.01, 0.04), Geometry::planar);
  spindle.supports = {support_on({-0.02, -0.02, -0.01, -0.01}, Hold::fixed, Hold::fixed),
                      support_on({0.03, 0.03, -0.01, -0.01}, Hold::free, Hold::fixed)};
  spindle.deformations = {output_at("x", {0.03, 0.04}, Direction::radial),
                          output_at("y", {0.03, 0.04}, Direction::axial)};
  spindle.stress_probes = {{"inside", 0, {0.0, 0.01}, {}}};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = temperatures(model.affine(), [](const DofPlace&) { return 10.0; });
  EXPECT_NEAR(moved_m(model, 0, field_K), 1.3 * 1.2e-4 * 0.05, 1e-13);
  EXPECT_NEAR(moved_m(model, 1, field_K), 1.3 * 1.2e-4 * 0.05, 1e-13);
  const Stress stress = model.probed_stresses(field_K).at(0).stress;
  EXPECT_NEAR(stress.tt_Pa, -200e9 * 1.2e-4, 1.0);
  EXPECT_NEAR(stress.rr_Pa, 0.0, 1.0);
  EXPECT_NEAR(stress.zz_Pa, 0.0, 1.0);
}

/// Ring of 40..60 mm on a shaft of 20..40 mm, both without strain along z.
Spindle ring_on_shaft(double outer_modulus_Pa) {
  Spindle spindle = concentric_rings({0.02, 0.04, 0.06}, 5000.0, 10.0, reference_K);
  spindle.materials[0].youngs_modulus_Pa = 200e9;
  spindle.materials[1].youngs_modulus_Pa = outer_modulus_Pa;
  for (Material& material : spindle.materials) {
    material.poisson_ratio = 0.3;
    material.expansion_per_K = 1.2e-5;
  }
  spindle.materials[1].poisson_ratio = 0.25;
  spindle.materials[1].expansion_per_K = 1.7e-5;
  spindle.mesh.element_size_m = 0.002;
  spindle.supports.clear();
  for (const std::size_t part : {0U, 1U}) {
    for (const double z_m : {0.0, 0.03}) {
      spindle.supports.push_back(support_on({0.0, 0.06, z_m, z_m}, Hold::free, Hold::fixed, part));
    }
  }
  spindle.contact_pressures = {{"fit", 0, {}}};
  return spindle;
}

/// Radial give per pressure of a ring without strain along z: plane strain turns E into E/(1−ν²), ν into ν/(1−ν).
double give_m_per_Pa(const Material& material, double inner_m, double outer_m, double pressed_m) {
  const double nu = material.poisson_ratio / (1.0 - material.poisson_ratio);
  const double modulus_Pa = material.youngs_modulus_Pa / (1.0 - material.poisson_ratio * material.poisson_ratio);
  const double squares = (outer_m * outer_m + inner_m * inner_m) / (outer_m * outer_m - inner_m * inner_m);
  return pressed_m / modulus_Pa * (squares + (pressed_m == inner_m ? nu : -nu));
}

/// Lamé: radial overlap of the free bodies over the sum of both gives; a hotter ring takes pressure away.
TEST(ContactPressure, shrink_fit_with_a_ring_5_K_hotter_follows_lame) {
  for (const double outer_modulus_Pa : {200e9, 70e9}) {
    Spindle spindle = ring_on_shaft(outer_modulus_Pa);
    spindle.contacts[0].preload_pressure_Pa = 20e6;
    const FeModel model(spindle, build_section(spindle));
    const Material &shaft = spindle.materials[0], &ring = spindle.materials[1];
    const double gives_m_per_Pa = give_m_per_Pa(shaft, 0.02, 0.04, 0.04) + give_m_per_Pa(ring, 0.04, 0.06, 0.04);
    for (const auto& [shaft_K, ring_K] : {std::pair{0.0, 5.0}, {5.0, 0.0}, {3.0, 8.0}}) {
      const Eigen::VectorXd field_K =
          temperatures(model.affine(), [shaft_rise_K = shaft_K, ring_rise_K = ring_K](const DofPlace& at) {
            return at.part == 0 ? shaft_rise_K : ring_rise_K;
          });
      const double overlap_m = 0.04 * (1.3 * 1.2e-5 * shaft_K - 1.25 * 1.7e-5 * ring_K);
      EXPECT_NEAR(pressure_Pa(model, 0, field_K), 20e6 + overlap_m / gives_m_per_Pa,
                  1e-3 * std::abs(overlap_m / gives_m_per_Pa));
      // The stress beside the joint is the same pressure.
      const Stress beside = model.stress_at(1, {0.04, 0.0153}, field_K);
      EXPECT_NEAR(beside.rr_Pa, -overlap_m / gives_m_per_Pa, 0.02 * std::abs(overlap_m / gives_m_per_Pa));
    }
  }
}

/// Two bars end to end, both outer ends held: −E α ΔT is carried through the joint, whatever its number of
/// pieces.
TEST(ContactPressure, held_bar_of_two_parts_carries_E_alpha_dT_through_the_joint) {
  Spindle spindle = bare_part(rectangle(0.0, 0.02, 0.0, 0.04));
  Part second = spindle.parts[0];
  second.name = "second";
  second.shapes = {rectangle(0.0, 0.02, 0.04, 0.1)};
  spindle.parts.push_back(second);
  Contact contact;
  contact.part_a = 0;
  contact.part_b = 1;
  contact.conductance_W_per_m2K = 1000.0;
  spindle.contacts = {contact};
  spindle.supports = {support_on({0.0, 0.02, 0.0, 0.0}, Hold::free, Hold::fixed, 0),
                      support_on({0.0, 0.02, 0.1, 0.1}, Hold::free, Hold::fixed, 1)};
  spindle.contact_pressures = {{"joint", 0, {}}};
  // An output on half of the joint cuts it into two pieces.
  spindle.deformations = {output_on("half", {0.0, 0.011, 0.04, 0.04}, Direction::axial)};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd field_K = temperatures(model.affine(), [](const DofPlace&) { return 10.0; });
  EXPECT_NEAR(pressure_Pa(model, 0, field_K), 200e9 * 1.2e-4, 1e-6 * 200e9 * 1.2e-4);
}

TEST(ImposedTemperature, formula_is_the_steady_field_and_grows_the_bar) {
  Spindle spindle = bare_part(rectangle(0.0, 0.02, 0.0, 0.1));
  spindle.supports = {support_on({0.0, 0.02, 0.0, 0.0}, Hold::free, Hold::fixed)};
  spindle.deformations = {output_on("tip", {0.0, 0.02, 0.1, 0.1}, Direction::axial)};
  spindle.imposed_temperature = ImposedTemperature{"15.19 * z / 0.1 + 0 * r_mm", {"s.toml", 7}};
  const FeModel metres(spindle, build_section(spindle));
  EXPECT_NEAR(moved_m(metres, 0, solve_steady(metres.affine(), nominal_values(metres.affine()))), 1.2e-5 * 0.7595,
              1e-13);
  spindle.imposed_temperature->rise_K = "15.19 * z_mm / 100";
  const FeModel millimetres(spindle, build_section(spindle));
  EXPECT_NEAR(moved_m(millimetres, 0, solve_steady(millimetres.affine(), nominal_values(millimetres.affine()))),
              1.2e-5 * 0.7595, 1e-13);
}

TEST(ImposedTemperature, bad_formula_is_an_error_with_its_line) {
  Spindle spindle = bare_part(rectangle(0.0, 0.02, 0.0, 0.1));
  for (const std::string formula : {"r +", "r + q", "", "1 / (z - z)", "ln(r)", "r, z", "import('x')"}) {
    spindle.imposed_temperature = ImposedTemperature{formula, {"s.toml", 7}};
    const std::string message = refusal(spindle);
    EXPECT_EQ(message.find("s.toml:7: imposed_temperature.rise_K: \"" + formula + "\" "), 0U) << message;
  }
}

}  // namespace model_mechanics_test
}  // namespace spindle_twin::fem_offline
