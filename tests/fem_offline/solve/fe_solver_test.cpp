#include "fem_offline/solve/fe_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace spindle_twin::fem_offline {
namespace solve_fe_solver_test {

SparseMatrix sparse(const Eigen::MatrixXd& dense) { return dense.sparseView(); }

/// Two lumps of 100 and 50 J/K joined by 1 m2 of contact; the second has 2 m2 of film to the room.
AffineModel two_lumps() {
  AffineModel model;
  model.capacity_J_per_K = sparse(Eigen::Vector2d(100.0, 50.0).asDiagonal());
  model.conduction_W_per_K.resize(2, 2);
  model.conductance_terms_m2 = {sparse((Eigen::Matrix2d() << 1.0, -1.0, -1.0, 1.0).finished()),
                                sparse((Eigen::Matrix2d() << 0.0, 0.0, 0.0, 2.0).finished())};
  model.source_distribution = Eigen::Vector2d(1.0, 0.0);
  model.places.resize(2);
  rom::Conductance contact, film;
  film.environment = 0;
  model.boundaries.conductances = {contact, film};
  model.boundaries.environments = {{"room", rom::EnvironmentKind::ambient}};
  model.boundaries.sources = {{"heat", 30.0, {}}};
  model.boundaries.reference_temperature_K = 300.0;
  return model;
}

rom::BoundaryValues values_of(double contact_W_per_m2K, double film_W_per_m2K, double heat_W, double room_K) {
  rom::BoundaryValues values;
  values.conductance_W_per_m2K = Eigen::Vector2d(contact_W_per_m2K, film_W_per_m2K);
  values.heat_W = Eigen::VectorXd::Constant(1, heat_W);
  values.environment_K = Eigen::VectorXd::Constant(1, room_K);
  return values;
}

/// exp(−C⁻¹K t) about the steady state, by the eigenvectors of the symmetric C^-½ K C^-½.
Eigen::Vector2d exact_K(const rom::BoundaryValues& values, const Eigen::Vector2d& start_K, double time_s) {
  const double g = values.conductance_W_per_m2K[0], h = 2.0 * values.conductance_W_per_m2K[1];
  const double room_K = values.environment_K[0], heat_W = values.heat_W[0];
  const Eigen::Vector2d steady_K(room_K + heat_W / h + heat_W / g, room_K + heat_W / h);
  const Eigen::Matrix2d conduction = (Eigen::Matrix2d() << g, -g, -g, g + h).finished();
  const Eigen::Vector2d root(10.0, std::sqrt(50.0));
  const Eigen::Matrix2d scaled = root.cwiseInverse().asDiagonal() * conduction * root.cwiseInverse().asDiagonal();
  // Closed form for 2 x 2: exp(−A t) = e^{−m t} (cosh(s t) I − sinh(s t)/s (A − m I)).
  const double m = 0.5 * scaled.trace();
  const double s = std::sqrt(m * m - scaled.determinant());
  const Eigen::Matrix2d propagator =
      std::exp(-m * time_s) * (std::cosh(s * time_s) * Eigen::Matrix2d::Identity() -
                               std::sinh(s * time_s) / s * (scaled - m * Eigen::Matrix2d::Identity()));
  const Eigen::Vector2d away = root.asDiagonal() * (start_K - steady_K);
  return steady_K + Eigen::Vector2d(root.cwiseInverse().asDiagonal() * (propagator * away));
}

TEST(Steady, two_lumps_in_a_row) {
  const AffineModel model = two_lumps();
  const rom::BoundaryValues values = values_of(5.0, 3.0, 30.0, 290.0);
  const Eigen::VectorXd temperatures_K = solve_steady(model, values);
  EXPECT_NEAR(temperatures_K[1], 290.0 + 30.0 / 6.0, 1e-12 * 300.0);
  EXPECT_NEAR(temperatures_K[0], 290.0 + 30.0 / 6.0 + 30.0 / 5.0, 1e-12 * 300.0);
  const HeatBalance balance = heat_balance(model, values, temperatures_K);
  EXPECT_NEAR(balance.heat_out_W, balance.heat_in_W, 1e-11);
}

TEST(Steady, without_a_way_out_is_an_error) {
  EXPECT_THROW(solve_steady(two_lumps(), values_of(5.0, 0.0, 30.0, 290.0)), std::runtime_error);
}

TEST(FeStepper, converges_to_the_exact_solution_at_order_two) {
  const AffineModel model = two_lumps();
  const rom::BoundaryValues values = values_of(5.0, 3.0, 30.0, 290.0);
  // On the slow eigenvector's side after 60 s; the steps after set_temperatures are graded, so the order is asymptotic.
  const Eigen::Vector2d start_K(310.0, 295.0);
  std::vector<double> errors_K;
  for (const double step_s : {0.7, 0.35, 0.175}) {
    FeStepper stepper(model);
    stepper.set_temperatures(start_K);
    stepper.advance(14.0, step_s, values);
    errors_K.push_back((stepper.temperatures_K() - exact_K(values, start_K, 14.0)).norm());
  }
  EXPECT_NEAR(std::log2(errors_K[0] / errors_K[1]), 2.0, 0.1) << errors_K[0] << " " << errors_K[1];
  EXPECT_NEAR(std::log2(errors_K[1] / errors_K[2]), 2.0, 0.1) << errors_K[1] << " " << errors_K[2];
}

TEST(FeStepper, its_rule_for_comparisons_converges_at_order_four) {
  const AffineModel model = two_lumps();
  const rom::BoundaryValues values = values_of(50.0, 3.0, 30.0, 290.0);
  const Eigen::Vector2d start_K(310.0, 295.0);
  std::vector<double> errors_K;
  for (const double step_s : {0.7, 0.35, 0.175}) {
    FeStepper stepper(model, FeScheme::order_4);
    stepper.set_temperatures(start_K);
    stepper.advance(2.8, step_s, values);
    errors_K.push_back((stepper.temperatures_K() - exact_K(values, start_K, 2.8)).norm());
  }
  EXPECT_NEAR(std::log2(errors_K[0] / errors_K[1]), 4.0, 0.3) << errors_K[0] << " " << errors_K[1];
  EXPECT_NEAR(std::log2(errors_K[1] / errors_K[2]), 4.0, 0.3) << errors_K[1] << " " << errors_K[2];
}

TEST(FeStepper, insulated_body_gains_exactly_the_heat) {
  const AffineModel model = two_lumps();
  FeStepper stepper(model);
  stepper.set_uniform_temperature(300.0);
  stepper.advance(100.0, 7.0, values_of(5.0, 0.0, 30.0, 290.0));
  const double gained_J = (model.capacity_J_per_K * (stepper.temperatures_K().array() - 300.0).matrix()).sum();
  EXPECT_NEAR(gained_J, 3000.0, 1e-8);
}

TEST(FeStepper, how_many_factors_it_keeps_changes_no_bit) {
  const AffineModel model = two_lumps();
  std::vector<Eigen::VectorXd> after_K;
  for (const std::size_t kept : {16U, 2U, 1U, 0U}) {
    FeStepper stepper(model, FeScheme::order_4);
    stepper.keep_factors(kept);
    stepper.set_uniform_temperature(290.0);
    for (int round = 0; round < 3; ++round) {
      stepper.advance(40.0, 10.0, values_of(5.0, 3.0, 30.0, 290.0));
      stepper.advance(25.0, 10.0, values_of(50.0, 3.0, 0.0, 290.0));
    }
    after_K.push_back(stepper.temperatures_K());
  }
  for (const Eigen::VectorXd& temperatures_K : after_K) EXPECT_EQ(temperatures_K, after_K.front());
}

TEST(FeStepper, uniform_field_without_heat_stays) {
  const AffineModel model = two_lumps();
  FeStepper stepper(model);
  stepper.set_uniform_temperature(290.0);
  stepper.advance(1000.0, 10.0, values_of(5.0, 3.0, 0.0, 290.0));
  EXPECT_LT((stepper.temperatures_K().array() - 290.0).abs().maxCoeff(), 1e-10);
}

/// The fast mode of stiff contact must not ring (L-stability), however long the step.
TEST(FeStepper, stiff_contact_does_not_ring) {
  const AffineModel model = two_lumps();
  for (const FeScheme scheme : {FeScheme::order_2, FeScheme::order_4}) {
    FeStepper stepper(model, scheme);
    stepper.set_temperatures(Eigen::Vector2d(310.0, 290.0));
    stepper.advance(10.0, 10.0, values_of(1e7, 3.0, 0.0, 290.0));
    EXPECT_LT(std::abs(stepper.temperatures_K()[0] - stepper.temperatures_K()[1]), 1e-4);
  }
}

/// Factors are kept for several operating states: switching back and forth must use the right one.
TEST(FeStepper, changing_conductances_follows_the_exact_solution) {
  const AffineModel model = two_lumps();
  FeStepper stepper(model);
  Eigen::Vector2d expected_K(300.0, 300.0);
  stepper.set_temperatures(expected_K);
  for (int k = 0; k < 12; ++k) {
    const rom::BoundaryValues values = values_of(k % 2 ? 0.5 : 5.0, 1.0 + k % 3, k % 2 ? 30.0 : 10.0, 290.0);
    stepper.advance(20.0, 0.5, values);
    expected_K = exact_K(values, expected_K, 20.0);
    EXPECT_LT((stepper.temperatures_K() - expected_K).lpNorm<Eigen::Infinity>(), 2e-3) << "interval " << k;
  }
}

/// A jump of heat inside a run of long steps is followed by short ones, so the first seconds are right too.
TEST(FeStepper, steps_after_a_jump_are_shorter) {
  const AffineModel model = two_lumps();
  const rom::BoundaryValues before = values_of(5.0, 3.0, 0.0, 290.0), after = values_of(5.0, 3.0, 300.0, 290.0);
  FeStepper stepper(model);
  stepper.set_uniform_temperature(290.0);
  stepper.advance(400.0, 40.0, before);
  stepper.advance(40.0, 40.0, after);
  const Eigen::Vector2d expected_K = exact_K(after, Eigen::Vector2d(290.0, 290.0), 40.0);
  const double rise_K = expected_K[0] - 290.0;
  EXPECT_LT((stepper.temperatures_K() - expected_K).lpNorm<Eigen::Infinity>(), 1e-3 * rise_K);
}

TEST(FeStepper, steps_within_a_tolerance_err_by_about_that_and_are_many_only_where_much_happens) {
  const AffineModel model = two_lumps();
  const rom::BoundaryValues values = values_of(5.0, 3.0, 30.0, 290.0);
  const Eigen::Vector2d start_K(310.0, 295.0);
  double looser_K = 1.0;
  for (const double tolerance_K : {1e-2, 1e-4, 1e-6}) {
    FeStepper stepper(model, FeScheme::order_4);
    stepper.set_temperatures(start_K);
    double worst_K = 0.0;
    for (const double until_s : {1.0, 10.0, 60.0, 200.0}) {
      const double from_s = until_s == 1.0 ? 0.0 : until_s == 10.0 ? 1.0 : until_s == 60.0 ? 10.0 : 60.0;
      stepper.advance_within(until_s - from_s, tolerance_K, values);
      worst_K = std::max(worst_K, (stepper.temperatures_K() - exact_K(values, start_K, until_s)).cwiseAbs().maxCoeff());
    }
    EXPECT_LT(worst_K, 5.0 * tolerance_K);
    EXPECT_LT(worst_K, looser_K);
    looser_K = worst_K;
  }
}

TEST(FeStepper, only_the_rule_of_order_four_follows_a_tolerance) {
  FeStepper stepper(two_lumps());
  EXPECT_THROW(stepper.advance_within(1.0, 1e-4, values_of(5.0, 3.0, 30.0, 290.0)), std::logic_error);
}

}  // namespace solve_fe_solver_test
}  // namespace spindle_twin::fem_offline
