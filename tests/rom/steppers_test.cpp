#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <random>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace steppers_test {

BoundaryValues values_at_speed(const Network& network, double speed_rpm, double load) {
  BoundaryValues values = rom::make_boundary_values(network.boundaries);
  OperatingState state = network.boundaries.operating;
  state.speed_rpm = speed_rpm;
  state.load = load;
  rom::evaluate_boundaries(network.boundaries, state, rom::no_correction(network.boundaries), values);
  return values;
}

/// Speed and load jump at random, coolant steps, ambient drifts, contacts jump now and then, and everything that
/// depends on speed trembles by `tremble` from second to second.
class DriveCycle {
 public:
  DriveCycle(const Network& network, std::uint64_t seed, double tremble)
      : network_(network),
        random_(seed),
        tremble_(tremble),
        state_(network.boundaries.operating),
        factors_(rom::no_correction(network.boundaries)),
        values_(rom::make_boundary_values(network.boundaries)) {}

  const BoundaryValues& next_second() {
    if (seconds_-- == 0) {
      seconds_ = std::uniform_int_distribution<int>(20, 300)(random_);
      speed_rpm_ = std::uniform_real_distribution<double>(-6000.0, 24000.0)(random_);
      state_.load = std::uniform_real_distribution<double>(0.0, 1.5)(random_);
      if (speed_rpm_ < 0.0) speed_rpm_ = 0.0;
      if (state_.environment_K.size() > 0) {
        state_.environment_K[0] = std::uniform_real_distribution<double>(290.0, 305.0)(random_);
      }
      for (double& factor : factors_.conductance) {
        factor = std::exp(std::uniform_real_distribution<double>(-2.3, 2.3)(random_));
      }
    }
    state_.speed_rpm = speed_rpm_ * (1.0 + std::uniform_real_distribution<double>(-tremble_, tremble_)(random_));
    if (state_.environment_K.size() > 1) state_.environment_K[1] += 2e-3;
    rom::evaluate_boundaries(network_.boundaries, state_, factors_, values_);
    return values_;
  }

 private:
  const Network& network_;
  std::mt19937_64 random_;
  double tremble_;
  int seconds_ = 0;
  double speed_rpm_ = 0.0;
  OperatingState state_;
  CorrectionFactors factors_;
  BoundaryValues values_;
};

struct Difference {
  double largest_K = 0.0;
  double largest_rise_K = 0.0;
  CvodeCounts counts;
};

Difference compare_over(int seconds, const Network& network, std::uint64_t seed, double tremble,
                        const CvodeSettings& settings) {
  const auto shared = share(network);
  CvodeStepper cvode(shared, settings);
  ExactStepper exact(shared);
  DriveCycle cycle(network, seed, tremble);
  Difference difference;
  for (int second = 0; second < seconds; ++second) {
    const BoundaryValues& values = cycle.next_second();
    EXPECT_EQ(cvode.advance(1.0, values), StepStatus::ok);
    EXPECT_EQ(exact.advance(1.0, values), StepStatus::ok);
    difference.largest_K =
        std::max(difference.largest_K, (cvode.temperatures_K() - exact.temperatures_K()).lpNorm<Eigen::Infinity>());
    difference.largest_rise_K = std::max(difference.largest_rise_K, exact.temperatures_K().maxCoeff() - 300.15);
  }
  difference.counts = cvode.counts();
  return difference;
}

void print(const char* what, std::uint64_t seed, const Difference& d) {
  std::cout << what << ": seed " << seed << ", largest difference " << d.largest_K << " K at rises up to "
            << d.largest_rise_K << " K; " << d.counts.internal_steps << " steps, " << d.counts.right_hand_sides
            << " right-hand sides, " << d.counts.decompositions << " decompositions, " << d.counts.restarts
            << " restarts\n";
}

constexpr double period_s = 1.0;

TEST(Steppers, single_node_follows_its_exponential) {
  const Network network = make_single_node();
  const BoundaryValues values = values_at_speed(network, 0.0, 1.0);
  CvodeStepper cvode(share(network));
  ExactStepper exact(share(network));
  for (int second = 1; second <= 200; ++second) {
    ASSERT_EQ(cvode.advance(period_s, values), StepStatus::ok);
    ASSERT_EQ(exact.advance(period_s, values), StepStatus::ok);
    const double expected_K = 300.0 + 100.0 / 25.0 * (1.0 - std::exp(-second * 25.0 / 1000.0));
    ASSERT_NEAR(exact.temperatures_K()[0], expected_K, 1e-10);
    ASSERT_NEAR(cvode.temperatures_K()[0], expected_K, 2e-4);
  }
}

TEST(Steppers, exact_stepper_is_independent_of_the_period) {
  const Network network = make_synthetic_network({}, 3);
  const BoundaryValues values = values_at_speed(network, 9000.0, 1.0);
  ExactStepper once(share(network)), often(share(network));
  ASSERT_EQ(once.advance(600.0, values), StepStatus::ok);
  for (int i = 0; i < 600; ++i) ASSERT_EQ(often.advance(1.0, values), StepStatus::ok);
  EXPECT_LT((once.temperatures_K() - often.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-9);
}

TEST(Steppers, cvode_and_exact_agree_over_an_hour_of_a_drive_cycle) {
  for (const std::uint64_t seed : {11u, 12u, 13u}) {
    const Network network = make_synthetic_network({5, 5, 5, true}, seed);
    const Difference difference = compare_over(3600, network, seed, 0.0, {});
    print("126 nodes, held between jumps", seed, difference);
    EXPECT_LT(difference.largest_K, 1e-3);
    EXPECT_GT(difference.largest_rise_K, 5.0);
    EXPECT_LT(difference.counts.restarts, 400);
  }
}

TEST(Steppers, they_agree_when_every_input_trembles_every_second) {
  const std::uint64_t seed = 21;
  const Network network = make_synthetic_network({4, 4, 4, true}, seed);
  for (const double tremble : {2e-4, 5e-3}) {  // below and above what counts as a jump
    const Difference difference = compare_over(1200, network, seed, tremble, {});
    print("65 nodes, trembling speed", seed, difference);
    EXPECT_LT(difference.largest_K, 1e-3) << "tremble " << tremble;
    if (tremble < 1e-3) {
      EXPECT_LT(difference.counts.restarts, 400);
    }
  }
}

TEST(Steppers, held_inputs_settle_at_one_step_per_cycle_and_keep_their_factor) {
  struct Case {
    SyntheticShape shape;
    std::uint64_t seed;
    double period_s;
  };
  // With BDF up to order 5 each of these stays at two steps and two factors per cycle.
  for (const Case& held : {Case{{3, 3, 3, true}, 28, 1.0}, Case{{8, 5, 5, true}, 26, 2.0}}) {
    const Network network = make_synthetic_network(held.shape, held.seed);
    const BoundaryValues values = values_at_speed(network, 9000.0, 1.0);
    CvodeStepper cvode(share(network));
    for (int cycle = 0; cycle < 600; ++cycle) ASSERT_EQ(cvode.advance(held.period_s, values), StepStatus::ok);
    const CvodeCounts before = cvode.counts();
    for (int cycle = 0; cycle < 600; ++cycle) ASSERT_EQ(cvode.advance(held.period_s, values), StepStatus::ok);
    const CvodeCounts after = cvode.counts();
    EXPECT_EQ(after.internal_steps - before.internal_steps, 600) << "seed " << held.seed;
    EXPECT_LE(after.decompositions - before.decompositions, 0) << "seed " << held.seed;
  }
}

TEST(Steppers, cvode_converges_to_exact_with_its_tolerance) {
  const std::uint64_t seed = 31;
  const Network network = make_synthetic_network({}, seed);
  double coarser = std::numeric_limits<double>::infinity();
  for (const double tolerance_K : {1e-4, 1e-6, 1e-8}) {
    CvodeSettings settings;
    settings.tolerance_K = tolerance_K;
    settings.jump_share = 1e-12;
    settings.jump_K = 1e-12;
    settings.max_internal_steps = 100000;
    const Difference difference = compare_over(600, network, seed, 0.0, settings);
    print("tolerance", seed, difference);
    EXPECT_LT(difference.largest_K, 0.1 * coarser) << "tolerance " << tolerance_K;
    coarser = difference.largest_K;
  }
}

TEST(Steppers, heat_balance_closes_in_an_insulated_network) {
  const std::uint64_t seed = 41;
  const Network network = make_synthetic_network({4, 4, 4, false}, seed);
  const Eigen::VectorXd capacity_J_per_K = network.capacity_J_per_K.rowwise().sum();
  for (const bool use_cvode : {true, false}) {
    std::unique_ptr<Stepper> stepper;
    if (use_cvode) {
      stepper = std::make_unique<CvodeStepper>(share(network));
    } else {
      stepper = std::make_unique<ExactStepper>(share(network));
    }
    const double start_J = capacity_J_per_K.dot(stepper->temperatures_K());
    DriveCycle cycle(network, seed, 0.0);
    double heat_J = 0.0;
    for (int second = 0; second < 1800; ++second) {
      const BoundaryValues& values = cycle.next_second();
      ASSERT_EQ(stepper->advance(period_s, values), StepStatus::ok);
      heat_J += period_s * values.heat_W.sum();
    }
    ASSERT_GT(heat_J, 1e4);
    const double stored_J = capacity_J_per_K.dot(stepper->temperatures_K()) - start_J;
    EXPECT_NEAR(stored_J / heat_J, 1.0, use_cvode ? 1e-5 : 1e-9);
  }
}

TEST(Steppers, steady_heat_out_equals_heat_in) {
  const Network network = make_synthetic_network({}, 51);
  const BoundaryValues values = values_at_speed(network, 6000.0, 1.0);
  ExactStepper exact(share(network));
  ASSERT_EQ(exact.advance(1e7, values), StepStatus::ok);
  double out_W = 0.0;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const int environment = network.boundaries.conductances[j].environment;
    if (environment < 0) continue;
    const Eigen::MatrixXd& factor = network.factors_m[j];
    const Eigen::VectorXd rise_K = exact.temperatures_K().array() - values.environment_K[environment];
    out_W += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] *
             factor.colwise().sum().dot(factor.transpose() * rise_K);
  }
  EXPECT_NEAR(out_W / values.heat_W.sum(), 1.0, 1e-9);
  CvodeStepper cvode(share(network));
  ASSERT_EQ(cvode.advance(1e6, values), StepStatus::ok);
  EXPECT_LT((cvode.temperatures_K() - exact.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-3);
}

TEST(Steppers, equilibrium_stays_at_rest) {
  const Network network = make_synthetic_network({}, 61);
  BoundaryValues values = values_at_speed(network, 12000.0, 1.0);
  values.heat_W.setZero();
  values.environment_K.setConstant(310.0);
  const Eigen::VectorXd uniform_K = Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), 310.0);
  CvodeStepper cvode(share(network));
  ExactStepper exact(share(network));
  cvode.set_temperatures(uniform_K);
  exact.set_temperatures(uniform_K);
  for (int second = 0; second < 600; ++second) {
    ASSERT_EQ(cvode.advance(period_s, values), StepStatus::ok);
    ASSERT_EQ(exact.advance(period_s, values), StepStatus::ok);
  }
  EXPECT_LT((cvode.temperatures_K() - uniform_K).lpNorm<Eigen::Infinity>(), 1e-9);
  EXPECT_LT((exact.temperatures_K() - uniform_K).lpNorm<Eigen::Infinity>(), 1e-9);
}

TEST(Steppers, rises_of_two_heats_add) {
  const Network network = make_synthetic_network({}, 71);
  const BoundaryValues both = values_at_speed(network, 9000.0, 1.0);
  Eigen::VectorXd sum_K = Eigen::VectorXd::Zero(network.capacity_J_per_K.rows());
  CvodeStepper together(share(network));
  for (int second = 0; second < 900; ++second) ASSERT_EQ(together.advance(period_s, both), StepStatus::ok);
  for (Eigen::Index source = 0; source < both.heat_W.size(); ++source) {
    BoundaryValues alone = both;
    alone.heat_W.setZero();
    alone.heat_W[source] = both.heat_W[source];
    CvodeStepper stepper(share(network));
    for (int second = 0; second < 900; ++second) ASSERT_EQ(stepper.advance(period_s, alone), StepStatus::ok);
    sum_K += (stepper.temperatures_K().array() - 300.15).matrix();
  }
  EXPECT_LT(((together.temperatures_K() - sum_K).array() - 300.15).abs().maxCoeff(), 5e-4);
}

TEST(Steppers, bad_inputs_leave_the_temperatures_and_it_goes_on) {
  const Network network = make_synthetic_network({}, 81);
  const BoundaryValues good = values_at_speed(network, 9000.0, 1.0);
  CvodeStepper cvode(share(network));
  ExactStepper exact(share(network)), reference(share(network));
  for (Stepper* stepper : {static_cast<Stepper*>(&cvode), static_cast<Stepper*>(&exact)}) {
    ASSERT_EQ(stepper->advance(10.0, good), StepStatus::ok);
    const Eigen::VectorXd before_K = stepper->temperatures_K();
    BoundaryValues bad = good;
    bad.heat_W[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(stepper->advance(1.0, bad), StepStatus::not_finite);
    bad = good;
    bad.environment_K[0] = std::numeric_limits<double>::infinity();
    EXPECT_EQ(stepper->advance(1.0, bad), StepStatus::not_finite);
    bad = good;
    bad.heat_W[0] = 1e308;
    EXPECT_NE(stepper->advance(1e6, bad), StepStatus::ok);
    EXPECT_EQ(stepper->advance(0.0, good), StepStatus::integrator_failed);
    EXPECT_EQ(stepper->advance(-1.0, good), StepStatus::integrator_failed);
    EXPECT_EQ(stepper->temperatures_K(), before_K);
    EXPECT_EQ(stepper->advance(10.0, good), StepStatus::ok);
  }
  ASSERT_EQ(reference.advance(20.0, good), StepStatus::ok);
  EXPECT_LT((exact.temperatures_K() - reference.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-9);
  EXPECT_LT((cvode.temperatures_K() - reference.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-3);
}

TEST(Steppers, fallback_carries_a_failing_integrator) {
  const Network network = make_synthetic_network({}, 91);
  const BoundaryValues values = values_at_speed(network, 9000.0, 1.0);
  CvodeSettings starved;
  starved.max_internal_steps = 1;  // the first cycle after a jump needs more: CVODE gives up there
  const auto stepper = make_runtime_stepper(network, starved);
  ExactStepper exact(share(network));
  for (int second = 0; second < 60; ++second) {
    ASSERT_EQ(stepper->advance(period_s, values), StepStatus::ok);
    ASSERT_EQ(exact.advance(period_s, values), StepStatus::ok);
  }
  EXPECT_GT(stepper->fallbacks(), 0);
  EXPECT_LT((stepper->temperatures_K() - exact.temperatures_K()).lpNorm<Eigen::Infinity>(), 1e-3);

  const auto healthy = make_runtime_stepper(network);
  for (int second = 0; second < 60; ++second) ASSERT_EQ(healthy->advance(period_s, values), StepStatus::ok);
  EXPECT_EQ(healthy->fallbacks(), 0);
  BoundaryValues bad = values;
  bad.heat_W[0] = std::numeric_limits<double>::quiet_NaN();
  const Eigen::VectorXd before_K = healthy->temperatures_K();
  EXPECT_EQ(healthy->advance(period_s, bad), StepStatus::not_finite);
  EXPECT_EQ(healthy->first_status(), StepStatus::not_finite);
  EXPECT_EQ(healthy->temperatures_K(), before_K);
}

TEST(Steppers, no_heap_call_in_the_cycle_after_warm_up) {
  const long before_control = heap_calls();
  Eigen::VectorXd control = Eigen::VectorXd::Zero(100);
  ASSERT_GT(heap_calls(), before_control) << "the counter does not count";
  ASSERT_EQ(control.size(), 100);

  const std::uint64_t seed = 101;
  const Network network = make_synthetic_network({8, 5, 5, true}, seed);
  ASSERT_EQ(network.capacity_J_per_K.rows(), 201);
  const auto stepper = make_runtime_stepper(network);
  DriveCycle cycle(network, seed, 0.05);  // beyond the jump threshold: restarts and new matrices all the time
  stepper->advance(period_s, cycle.next_second());
  StepStatus status = StepStatus::ok;
  const long before = heap_calls();
  for (int second = 0; second < 600 && status == StepStatus::ok; ++second) {
    status = stepper->advance(period_s, cycle.next_second());
  }
  EXPECT_EQ(heap_calls() - before, 0);
  EXPECT_EQ(status, StepStatus::ok);
  EXPECT_EQ(stepper->fallbacks(), 0);
}

}  // namespace steppers_test
}  // namespace spindle_twin::rom::tests
