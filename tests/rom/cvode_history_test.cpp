#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

/// When CVODE drops its history, and when Newton's matrix is made anew: at jumps of its inputs, beyond the shares that
/// CvodeSettings says, and at nothing else.
namespace spindle_twin::rom::tests {
namespace cvode_history_test {

/// A circuit, and capacities on the diagonal alone, so that they may have factors.
Network network_of_all_inputs() {
  Network network = make_network_with_circuit({2, 2, 2, true}, 3);
  network.capacity_J_per_K = Eigen::VectorXd(network.capacity_J_per_K.rowwise().sum()).asDiagonal();
  return network;
}

using Change = std::function<void(BoundaryValues&)>;

struct Counted {
  CvodeCounts before, after;
  long restarts() const { return after.restarts - before.restarts; }
  long decompositions() const { return after.decompositions - before.decompositions; }
};

/// Some cycles of `first`, then one that is changed.
Counted at_change(const Network& network, const Change& first, const Change& change, const CvodeSettings& settings) {
  CvodeStepper stepper(share(network), settings);
  BoundaryValues values = operating_values(network);
  first(values);
  for (int cycle = 0; cycle < 3; ++cycle) EXPECT_EQ(stepper.advance(1.0, values), StepStatus::ok);
  Counted counted{stepper.counts(), {}};
  change(values);
  EXPECT_EQ(stepper.advance(1.0, values), StepStatus::ok);
  counted.after = stepper.counts();
  return counted;
}

void nothing(BoundaryValues&) {}

CvodeSettings half_is_a_jump() {
  CvodeSettings settings;
  settings.jump_share = 0.5;
  return settings;
}

/// An input that differs by the share `s` of the larger of its two values.
struct Input {
  const char* what;
  std::function<void(BoundaryValues&, double)> times;
};

const std::vector<Input> inputs = {
    {"the first heat", [](BoundaryValues& v, double factor) { v.heat_W[0] *= factor; }},
    {"the last heat", [](BoundaryValues& v, double factor) { v.heat_W.tail(1)[0] *= factor; }},
    {"the first conductance", [](BoundaryValues& v, double factor) { v.conductance_W_per_m2K[0] *= factor; }},
    {"the flow", [](BoundaryValues& v, double factor) { v.coolant_W_per_K[0] *= factor; }},
    {"a capacity",
     [](BoundaryValues& v, double factor) {
       v.capacity_factor = Eigen::VectorXd::Ones(9);
       v.capacity_factor[0] = factor;
     }},
};

TEST(CvodeHistory, is_dropped_where_an_input_moves_by_more_than_the_share_of_its_larger_value) {
  const Network network = network_of_all_inputs();
  for (const Input& input : inputs) {
    for (const CvodeSettings& settings : {half_is_a_jump(), CvodeSettings{}}) {
      for (const double part : {0.98, 1.02}) {
        const double share_of_larger = part * settings.jump_share;
        for (const double factor : {1.0 - share_of_larger, 1.0 / (1.0 - share_of_larger)}) {
          const Counted counted = at_change(
              network, nothing, [&](BoundaryValues& values) { input.times(values, factor); }, settings);
          EXPECT_EQ(counted.restarts(), part > 1.0 ? 1 : 0) << input.what << " times " << factor;
        }
      }
    }
  }
}

TEST(CvodeHistory, is_dropped_where_surroundings_move_by_more_than_a_twentieth_of_a_kelvin) {
  const Network network = network_of_all_inputs();
  for (const Eigen::Index environment : {0, 1}) {
    for (const double step_K : {0.049, -0.049, 0.051, -0.051}) {
      const Counted counted =
          at_change(network, nothing, [&](BoundaryValues& values) { values.environment_K[environment] += step_K; }, {});
      EXPECT_EQ(counted.restarts(), std::abs(step_K) > 0.05 ? 1 : 0) << step_K;
    }
  }
}

TEST(CvodeHistory, goes_on_where_an_input_moves_by_exactly_what_is_allowed) {
  const Network network = network_of_all_inputs();
  for (const Input& input : inputs) {
    for (const double factor : {0.5, 2.0}) {
      const Counted counted = at_change(
          network, nothing, [&](BoundaryValues& values) { input.times(values, factor); }, half_is_a_jump());
      EXPECT_EQ(counted.restarts(), 0) << input.what << " times " << factor;
    }
  }
  CvodeSettings half_a_kelvin;
  half_a_kelvin.jump_K = 0.5;
  const auto to = [](double kelvin) -> Change {
    return [=](BoundaryValues& values) { values.environment_K.setConstant(kelvin); };
  };
  EXPECT_EQ(at_change(network, to(300.0), to(300.5), half_a_kelvin).restarts(), 0);
  EXPECT_EQ(at_change(network, to(300.0), to(300.75), half_a_kelvin).restarts(), 1);
}

TEST(CvodeHistory, a_single_nodes_inputs_jump_as_those_of_many) {
  const Network network = make_single_node();
  const auto node_heat = [](double heat_W) -> Change {
    return [=](BoundaryValues& values) { values.node_heat_W = Eigen::VectorXd::Constant(1, heat_W); };
  };
  EXPECT_EQ(at_change(network, node_heat(10.0), node_heat(59.0), half_is_a_jump()).restarts(), 0) << "of 100 W";
  EXPECT_EQ(at_change(network, node_heat(10.0), node_heat(61.0), half_is_a_jump()).restarts(), 1);
  EXPECT_EQ(at_change(network, nothing, [](BoundaryValues& v) { v.environment_K[0] += 0.06; }, {}).restarts(), 1);
  EXPECT_EQ(at_change(network, nothing, [](BoundaryValues& v) { v.environment_K[0] += 0.04; }, {}).restarts(), 0);
}

TEST(CvodeHistory, is_dropped_after_a_period_that_failed_and_not_by_one_that_is_none) {
  const Network network = network_of_all_inputs();
  CvodeSettings starved;
  starved.max_internal_steps = 1;  // the first cycle needs more
  CvodeStepper stepper(share(network), starved);
  const BoundaryValues values = operating_values(network);
  const Eigen::VectorXd start_K = stepper.temperatures_K();
  for (int attempt = 1; attempt <= 3; ++attempt) {
    EXPECT_EQ(stepper.advance(1.0, values), StepStatus::integrator_failed);
    EXPECT_EQ(stepper.temperatures_K(), start_K);
    EXPECT_EQ(stepper.counts().restarts, attempt) << "each from the state that was good";
    EXPECT_LT(stepper.counts().last_flag, 0);
  }
  CvodeStepper healthy(share(network));
  EXPECT_EQ(healthy.advance(1.0, values), StepStatus::ok);
  EXPECT_EQ(healthy.advance(0.0, values), StepStatus::integrator_failed);
  EXPECT_EQ(healthy.advance(1.0, values), StepStatus::ok);
  EXPECT_EQ(healthy.counts().restarts, 1);
}

TEST(CvodeHistory, goes_on_while_nothing_moves_also_of_what_is_zero) {
  const Network network = network_of_all_inputs();
  const std::vector<Change> held = {nothing,
                                    [](BoundaryValues& values) {
                                      values.heat_W.setZero();
                                      values.conductance_W_per_m2K[1] = 0.0;
                                    },
                                    [](BoundaryValues& values) { values.coolant_W_per_K.setZero(); },
                                    [](BoundaryValues& values) {
                                      values.heat_W.setZero();
                                      values.node_heat_W = Eigen::VectorXd::Zero(9);
                                      values.capacity_factor = Eigen::VectorXd::Constant(9, 1.3);
                                    }};
  for (std::size_t i = 0; i < held.size(); ++i) {
    CvodeStepper stepper(share(network));
    BoundaryValues values = operating_values(network);
    held[i](values);
    for (int cycle = 0; cycle < 5; ++cycle) ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
    EXPECT_EQ(stepper.counts().restarts, 1) << "inputs " << i;
    EXPECT_EQ(stepper.counts().decompositions, 1) << "inputs " << i;
  }
}

TEST(CvodeHistory, goes_on_with_the_factors_of_a_single_node) {
  const Network network = make_single_node();
  BoundaryValues values = operating_values(network);
  values.heat_W.setZero();
  values.node_heat_W = Eigen::VectorXd::Constant(1, 40.0);
  values.capacity_factor = Eigen::VectorXd::Constant(1, 1.7);
  CvodeStepper stepper(share(network));
  for (int cycle = 0; cycle < 5; ++cycle) ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
  EXPECT_EQ(stepper.counts().restarts, 1);
  EXPECT_EQ(stepper.counts().decompositions, 1);
}

TEST(CvodeHistory, knows_no_node_heats_from_none_and_capacities_as_written_from_none) {
  const Network network = network_of_all_inputs();
  const auto explicit_ones = [](BoundaryValues& values) {
    values.heat_W.setZero();
    values.node_heat_W = Eigen::VectorXd::Zero(9);
    values.capacity_factor = Eigen::VectorXd::Ones(9);
  };
  const auto implied_ones = [](BoundaryValues& values) {
    values.heat_W.setZero();
    values.node_heat_W.resize(0);
    values.capacity_factor.resize(0);
  };
  for (const auto& [from, to] : {std::pair<Change, Change>{explicit_ones, implied_ones},
                                 std::pair<Change, Change>{implied_ones, explicit_ones}}) {
    const Counted counted = at_change(network, from, to, {});
    EXPECT_EQ(counted.restarts(), 0);
    EXPECT_EQ(counted.decompositions(), 0);
  }
}

TEST(CvodeHistory, a_node_heat_jumps_by_its_share_of_the_largest_heat_of_any_source_or_node) {
  const Network network = network_of_all_inputs();
  const auto node_heat = [](double source_W, Eigen::Index node, double heat_W) -> Change {
    return [=](BoundaryValues& values) {
      values.heat_W.setZero();
      values.heat_W[1] = source_W;
      values.node_heat_W = Eigen::VectorXd::Zero(9);
      values.node_heat_W[node] = heat_W;
    };
  };
  const auto none = [](BoundaryValues& values) { values.node_heat_W.resize(0); };
  struct Case {
    Change from, to;
    bool jump;
  };
  const std::vector<Case> cases = {
      {node_heat(250.0, 0, 0.0), node_heat(250.0, 0, 124.0), false},
      {node_heat(250.0, 0, 0.0), node_heat(250.0, 0, 126.0), true},
      {node_heat(250.0, 8, 60.0), node_heat(250.0, 8, -66.0), true},
      {node_heat(250.0, 8, 60.0), node_heat(250.0, 8, -64.0), false},
      {node_heat(0.0, 3, 100.0), node_heat(0.0, 3, 51.0), false},
      {node_heat(0.0, 3, 100.0), node_heat(0.0, 3, 49.0), true},
      {node_heat(0.0, 3, 100.0), node_heat(0.0, 3, 50.0), false},
      {node_heat(0.0, 3, 0.0), node_heat(0.0, 3, 1.0), true},
      {node_heat(0.0, 3, 51.0), node_heat(0.0, 3, 100.0), false},
      {node_heat(0.0, 3, 49.0), node_heat(0.0, 3, 100.0), true},
      {node_heat(0.0, 3, 1e-3), none, true},
      {node_heat(0.0, 3, 0.0), none, false},
      {node_heat(250.0, 0, 126.0), none, true},
      {node_heat(250.0, 0, 124.0), none, false},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const Counted counted = at_change(network, cases[i].from, cases[i].to, half_is_a_jump());
    EXPECT_EQ(counted.restarts(), cases[i].jump ? 1 : 0) << "case " << i;
  }
}

TEST(CvodeHistory, what_was_counted_before_a_new_start_stays_counted) {
  const Counted counted =
      at_change(network_of_all_inputs(), nothing, [](BoundaryValues& values) { values.heat_W *= 3.0; }, {});
  ASSERT_EQ(counted.restarts(), 1);
  EXPECT_GE(counted.before.internal_steps, 3);
  EXPECT_GE(counted.before.right_hand_sides, counted.before.internal_steps);
  EXPECT_GT(counted.after.internal_steps, counted.before.internal_steps);
  EXPECT_GE(counted.after.right_hand_sides - counted.before.right_hand_sides,
            counted.after.internal_steps - counted.before.internal_steps);
  EXPECT_GE(counted.after.last_flag, 0);
}

TEST(NewtonsMatrix, outlives_a_new_start_as_long_as_conductances_and_capacities_are_within_a_tenth) {
  const Network network = network_of_all_inputs();
  const auto decompositions = [&](const Change& change, const CvodeSettings& settings) {
    const Counted counted = at_change(network, nothing, change, settings);
    EXPECT_EQ(counted.restarts(), 1);
    return counted.decompositions();
  };
  const auto conductance = [](double factor) {
    return [=](BoundaryValues& values) { values.conductance_W_per_m2K[0] *= factor; };
  };
  const auto capacity = [](double factor) {
    return [=](BoundaryValues& values) {
      values.capacity_factor = Eigen::VectorXd::Ones(9);
      values.capacity_factor[0] = factor;
    };
  };
  const auto heat = [](BoundaryValues& values) { values.heat_W *= 2.0; };
  EXPECT_EQ(decompositions(heat, {}), 0) << "heats are not in it";
  EXPECT_EQ(decompositions(conductance(1.0 / 0.92), {}), 0);
  EXPECT_EQ(decompositions(conductance(1.0 / 0.88), {}), 1);
  EXPECT_EQ(decompositions(conductance(0.92), {}), 0);
  EXPECT_EQ(decompositions(conductance(0.88), {}), 1);
  EXPECT_EQ(decompositions(capacity(0.92), {}), 0);
  EXPECT_EQ(decompositions(capacity(0.88), {}), 1);
  CvodeSettings exact;
  exact.tolerated_share = 0.0;
  EXPECT_EQ(decompositions(heat, exact), 0);
  EXPECT_EQ(decompositions(conductance(1.01), exact), 1) << "0: the matrix is of the present ones";
  EXPECT_EQ(decompositions(capacity(1.01), exact), 1);
}

TEST(CvodeStepper, starts_at_the_reference_temperature_and_asks_for_a_period_that_is_one) {
  const Network network = network_of_all_inputs();
  CvodeStepper stepper(share(network));
  const Eigen::VectorXd start_K = stepper.temperatures_K();
  EXPECT_LT((start_K.array() - network.boundaries.reference_temperature_K).abs().maxCoeff(), 1e-9);
  const BoundaryValues values = operating_values(network);
  for (const double period_s : {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_EQ(stepper.advance(period_s, values), StepStatus::integrator_failed) << period_s;
    EXPECT_EQ(stepper.temperatures_K(), start_K);
  }
}

TEST(CvodeStepper, a_network_that_nothing_cools_warms_by_heat_times_time_over_capacity) {
  const Network network = make_single_node();
  BoundaryValues values = operating_values(network);
  values.conductance_W_per_m2K[0] = 0.0;
  CvodeStepper stepper(share(network));
  for (int second = 0; second < 7; ++second) ASSERT_EQ(stepper.advance(1.0, values), StepStatus::ok);
  EXPECT_NEAR(stepper.temperatures_K()[0], 300.0 + 100.0 * 7.0 / 1000.0, 1e-5);
  EXPECT_EQ(stepper.counts().decompositions, 1) << "also of a matrix that is zero";
}

/// The tolerance is in kelvin: a spindle that is a thousand times heavier, cooled and heated takes the same steps.
TEST(CvodeStepper, takes_the_same_steps_however_large_the_spindle_is) {
  constexpr double times = 1000.0;
  const Network small = make_single_node();
  Network large = small;
  large.capacity_J_per_K *= times;
  BoundaryValues small_values = operating_values(small), large_values = small_values;
  large_values.conductance_W_per_m2K *= times;
  large_values.heat_W *= times;
  CvodeStepper of_small(share(small)), of_large(share(large));
  for (int second = 0; second < 60; ++second) {
    ASSERT_EQ(of_small.advance(1.0, small_values), StepStatus::ok);
    ASSERT_EQ(of_large.advance(1.0, large_values), StepStatus::ok);
  }
  EXPECT_NEAR(of_small.temperatures_K()[0], of_large.temperatures_K()[0], 1e-9);
  EXPECT_EQ(of_small.counts().internal_steps, of_large.counts().internal_steps);
}

TEST(CvodeStepper, a_state_that_is_not_finite_is_not_carried_on) {
  const Network network = network_of_all_inputs();
  CvodeStepper stepper(share(network));
  Eigen::VectorXd spoilt_K = Eigen::VectorXd::Constant(9, 300.0);
  spoilt_K[4] = std::numeric_limits<double>::quiet_NaN();
  stepper.set_temperatures(spoilt_K);
  EXPECT_EQ(stepper.advance(1.0, operating_values(network)), StepStatus::not_finite);
  stepper.set_temperatures(Eigen::VectorXd::Constant(9, 300.0));
  EXPECT_EQ(stepper.advance(1.0, operating_values(network)), StepStatus::ok);
}

}  // namespace cvode_history_test
}  // namespace spindle_twin::rom::tests
