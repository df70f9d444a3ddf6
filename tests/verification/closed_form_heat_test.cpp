#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "correction/boundaries/evaluate_boundaries.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "tests/verification/concentric_rings.hpp"

namespace spindle_twin::fem_offline {
namespace {

rom::BoundaryValues nominal_values(const AffineModel& model) {
  rom::BoundaryValues values = correction::make_boundary_values(model.boundaries);
  correction::evaluate_boundaries(model.boundaries, model.boundaries.operating,
                                  correction::no_correction(model.boundaries), values);
  return values;
}

/// Temperature at the unknown of `part` closest to radius r, degC.
double at_radius_degC(const AffineModel& model, const Eigen::VectorXd& temperatures_K, int part, double r_m) {
  int nearest = -1;
  for (const int dof : model.parts[static_cast<std::size_t>(part)].dofs) {
    if (nearest < 0 || std::abs(model.places[dof].r_m - r_m) < std::abs(model.places[nearest].r_m - r_m)) nearest = dof;
  }
  EXPECT_NEAR(model.places[nearest].r_m, r_m, 1e-12);
  return temperatures_K[nearest] - 273.15;
}

/// The rings' steady field is logarithmic or parabolic in r: a closed form at every radius.
TEST(ShaftInSleeve, steady_temperatures_are_the_closed_form) {
  Spindle spindle = shaft_in_sleeve();
  spindle.mesh.element_size_m = 0.002;
  const FeModel model(spindle, build_section(spindle));
  const rom::BoundaryValues values = nominal_values(model.affine());
  const Eigen::VectorXd steady_K = solve_steady(model.affine(), values);
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 0, 0.0), 59.2340023, 1e-4);
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 0, 0.02), 57.1506690, 1e-4);
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 1, 0.02), 55.1506690, 1e-4);
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 1, 0.04), 52.0, 1e-4);
}

TEST(ShaftInSleeve, heat_in_is_heat_out) {
  const Spindle spindle = shaft_in_sleeve();
  const FeModel model(spindle, build_section(spindle));
  const rom::BoundaryValues values = nominal_values(model.affine());
  const HeatBalance balance = heat_balance(model.affine(), values, solve_steady(model.affine(), values));
  const double exact_W = 1e6 * std::numbers::pi * 0.02 * 0.02 * 0.03;
  EXPECT_NEAR(balance.heat_in_W, exact_W, 1e-12 * exact_W);
  EXPECT_NEAR(balance.heat_out_W, balance.heat_in_W, 1e-9 * balance.heat_in_W);
}

TEST(TwoRings, steady_temperatures_are_the_closed_form) {
  Spindle spindle = concentric_rings({0.020, 0.035, 0.060}, 2000.0, 100.0, 293.15);
  spindle.materials = {steel("k 50", 50.0), steel("k 15", 15.0)};
  spindle.mesh.element_size_m = 0.0015;
  HeatSource bore;
  bore.name = "bore";
  bore.heat_W = 1e4 * 2.0 * std::numbers::pi * 0.020 * 0.03;
  HeatShare share;
  share.on_face = Box{0.020, 0.020, 0.0, 0.03};
  bore.shares = {share};
  spindle.heats = {bore};
  const FeModel model(spindle, build_section(spindle));
  const Eigen::VectorXd steady_K = solve_steady(model.affine(), nominal_values(model.affine()));
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 0, 0.020), 65.615555, 1e-4);
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 0, 0.035), 63.377092, 1e-4);
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 1, 0.035), 60.519949, 1e-4);
  EXPECT_NEAR(at_radius_degC(model.affine(), steady_K, 1, 0.060), 53.333333, 1e-4);
}

/// Error at 300 s against steps 16 times shorter, for three step lengths. The runs start from a field that has run for
/// 20 s, so that no jump falls into them and all steps are of one length.
TEST(ShaftInSleeve, transient_converges_at_order_two) {
  Spindle spindle = shaft_in_sleeve();
  spindle.mesh.element_size_m = 0.005;
  const FeModel model(spindle, build_section(spindle));
  const rom::BoundaryValues values = nominal_values(model.affine());
  FeStepper start(model.affine());
  start.set_uniform_temperature(300.15);
  start.advance(20.0, 0.25, values);

  const auto at_300_s = [&](double step_s) {
    FeStepper stepper(model.affine());
    stepper.set_temperatures(start.temperatures_K());
    stepper.advance(280.0, step_s, values);
    return stepper.temperatures_K();
  };
  const Eigen::VectorXd reference_K = at_300_s(0.3125);
  std::vector<double> errors_K;
  for (const double step_s : {20.0, 10.0, 5.0}) {
    errors_K.push_back((at_300_s(step_s) - reference_K).lpNorm<Eigen::Infinity>());
  }
  for (std::size_t i = 0; i + 1 < errors_K.size(); ++i) {
    const double order = std::log2(errors_K[i] / errors_K[i + 1]);
    EXPECT_NEAR(order, 2.0, 0.15) << "errors " << errors_K[i] << " K, " << errors_K[i + 1] << " K";
  }
}

/// Energy theorem of a held input: C T grows by heat in minus heat out, integrated; at the end it is the steady state.
TEST(ShaftInSleeve, transient_ends_in_the_steady_state) {
  Spindle spindle = shaft_in_sleeve();
  const FeModel model(spindle, build_section(spindle));
  const rom::BoundaryValues values = nominal_values(model.affine());
  FeStepper stepper(model.affine());
  stepper.set_uniform_temperature(300.15);
  stepper.advance(40000.0, 200.0, values);
  EXPECT_LT((stepper.temperatures_K() - solve_steady(model.affine(), values)).lpNorm<Eigen::Infinity>(), 1e-6);
}

}  // namespace
}  // namespace spindle_twin::fem_offline
