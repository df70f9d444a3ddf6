#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/firmware/support/machine.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::firmware {
namespace cycle_estimator_cycle_test {

/// A twin that follows a machine, one cycle a second.
struct Pair {
  Pair(const rom::Network& network, const CyclePlan& plan, double heat)
      : cycle(network, plan, runtime), machine(network, heat) {}

  const Snapshot& step() {
    last = cycle.step(machine.frame(at_s(n)), command, at_s(n), 0);
    machine.advance(1.0);
    ++n;
    return last;
  }
  void until(int seconds) {
    while (n < seconds) step();
  }
  double nose_error_m() const { return last.deformation_raw_m[0] - machine.model.outputs.deformations_m[0]; }

  Cycle cycle;
  Machine machine;
  PlcCommand command;
  Snapshot last;
  int n = 0;
};

TEST(EstimatorCycle, finds_the_heat_and_its_deviations_hold_the_truth) {
  const rom::Network network = tests::small_network();
  Pair run(network, estimated(), 0.5);
  run.until(3600);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto point = static_cast<std::size_t>(k);
    const double error_K = run.last.predicted_K[point] - run.machine.model.outputs.key_points_K[k];
    EXPECT_NEAR(error_K, 0.0, 0.02);
    EXPECT_LT(std::abs(error_K), 2.0 * run.last.predicted_deviation_K[point]);
    EXPECT_NE(run.last.sensor_update[point].flags & bits(Update::fused), 0);
    EXPECT_LT(run.last.sensor_update[point].test_ratio, 1.0);
  }
  const double uncorrected_m = run.last.nose_uncorrected_m - run.machine.model.outputs.deformations_m[0];
  EXPECT_LT(std::abs(run.nose_error_m()), 0.2 * std::abs(uncorrected_m));
  EXPECT_LT(std::abs(run.nose_error_m()), 2.0 * run.last.deformation_deviation_m[0]);
  EXPECT_GT(run.last.deformation_deviation_m[0], run.last.nose_network_deviation_m);
  EXPECT_NEAR(static_cast<double>(run.last.updates), 360.0, 1.0);
  EXPECT_GT(run.last.parameters_determined, 0);
  EXPECT_LT(run.last.parameters_determined, run.last.parameters);
  EXPECT_EQ(run.last.correction_freeze, bits(CorrectionFreeze::none));
  EXPECT_EQ(run.last.state, State::running);
}

TEST(EstimatorCycle, from_the_first_cycle_on_sigma_is_what_the_priors_make_of_the_time_since_the_start) {
  rom::Network network = tests::small_network();
  network.certificate = {};
  CyclePlan plan = estimated();
  plan.estimator->curvature = 0.0;
  correction::EstimatorPriors& priors = plan.estimator->priors;
  priors = {.heat = 0.5, .contact = 0.0, .film = 0.0, .environment_K = 0.0, .bearing_mean_per_K = 0.0};
  priors.bearing_per_K = priors.speed_exponent = priors.heat_walk_per_root_min = priors.contact_walk_per_root_min =
      priors.film_walk_per_root_min = 0.0;
  priors.start_K = 0.01;
  priors.start_shape_K = priors.disturbance = priors.disturbance_by_hand = 0.0;
  priors.centred = false;
  constexpr double nudge = 1e-3;
  struct Nudged {
    Machine above, below;
  };
  std::vector<Nudged> sources;
  for (Eigen::Index i = 0; i < 2; ++i) {
    sources.push_back({Machine(network, 1.0), Machine(network, 1.0)});
    sources.back().above.factors.heat[i] = std::exp(nudge);
    sources.back().below.factors.heat[i] = std::exp(-nudge);
  }
  for (const bool corrects : {true, false}) {
    plan.estimator_corrects = corrects;
    Cycle cycle(network, plan, runtime);
    for (Nudged& source : sources) {
      for (Machine* machine : {&source.above, &source.below}) {
        machine->model.stepper->set_temperatures(Eigen::VectorXd::Constant(5, start_K));
        predict(network, machine->model);
      }
    }
    const double uniform_m = 0.01 * network.deformations[0].row_m_per_K.sum();
    for (int n = 0; n < 30; ++n) {
      double variance_m2 = uniform_m * uniform_m;
      for (Nudged& source : sources) {
        const double slope_m =
            (source.above.model.outputs.deformations_m[0] - source.below.model.outputs.deformations_m[0]) /
            (2.0 * nudge);
        variance_m2 += 0.25 * slope_m * slope_m;
        source.above.advance(1.0);
        source.below.advance(1.0);
      }
      const Snapshot snapshot = cycle.step({}, {}, at_s(n), 0);
      EXPECT_NEAR(snapshot.deformation_deviation_m[0], std::sqrt(variance_m2), 0.02 * std::sqrt(variance_m2)) << n;
    }
  }
}

TEST(EstimatorCycle, what_the_coolant_reads_wrong_is_added_to_the_model_but_not_to_the_comparison) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.estimator->priors = {};
  plan.estimator->priors.heat = plan.estimator->priors.contact = plan.estimator->priors.film = 0.01;
  plan.estimator->priors.environment_K = 1.0;
  plan.estimator->priors.bearing_mean_per_K = plan.estimator->priors.bearing_per_K = 0.0;
  Pair run(network, plan, 1.0);
  run.machine.operating.environment_K[0] += 1.0;
  Pair open(network, open_loop(), 1.0);
  run.until(3600);
  open.until(3600);
  const double truth_K = run.machine.model.outputs.key_points_K[2];
  EXPECT_NEAR(run.last.predicted_K[2], truth_K, 0.05);
  EXPECT_LT(run.last.uncorrected_K[2], truth_K - 0.5);
  EXPECT_EQ(run.last.uncorrected_K[2], open.last.predicted_K[2]);
}

TEST(EstimatorCycle, the_same_inputs_give_the_same_bits) {
  const rom::Network network = tests::small_network();
  Pair a(network, estimated(), 0.5);
  Pair b(network, estimated(), 0.5);
  a.command.displacement = b.command.displacement = {0, 2e-6, 1e-6};
  for (int second = 0; second < 600; ++second) {
    if (second == 300) a.command.displacements = b.command.displacements = 1;
    a.step();
    b.step();
    ASSERT_EQ(std::memcmp(a.last.predicted_K.data(), b.last.predicted_K.data(), sizeof a.last.predicted_K), 0);
    ASSERT_EQ(std::memcmp(&a.last.deformation_deviation_m, &b.last.deformation_deviation_m,
                          sizeof a.last.deformation_deviation_m),
              0);
  }
}

TEST(EstimatorCycle, off_it_runs_open_loop_with_the_deviations_of_that_and_switching_moves_no_temperature) {
  const rom::Network network = tests::small_network();
  Pair run(network, estimated(), 0.5);
  double largest_step_K = 0.0;
  const auto step = [&](int until) {
    while (run.n < until) {
      const double before_K = run.last.predicted_K[0];
      run.step();
      largest_step_K = std::max(largest_step_K, std::abs(run.last.predicted_K[0] - before_K));
    }
  };
  run.until(1799);
  const double sd_on_K = run.last.predicted_deviation_K[0];
  run.command.correction = SwitchOrder::off;
  step(3000);
  EXPECT_EQ(run.last.heat_factor[0], 1.0);
  EXPECT_EQ(run.last.conductance_factor[1], 1.0);
  EXPECT_NE(run.last.quality & bits(Quality::correction_off), 0);
  EXPECT_FALSE(run.last.correction_enabled);
  EXPECT_GT(run.last.predicted_deviation_K[0], 5.0 * sd_on_K);
  EXPECT_LT(std::abs(run.nose_error_m()), 2.0 * run.last.deformation_deviation_m[0]);
  run.command.correction = SwitchOrder::on;
  step(3009);
  EXPECT_LT(largest_step_K, 0.03);
  run.until(3600);
  EXPECT_NEAR(run.last.predicted_K[0], run.machine.model.outputs.key_points_K[0],
              2.0 * run.last.predicted_deviation_K[0]);
}

TEST(EstimatorCycle, after_it_was_switched_on_with_a_large_error_it_does_not_ring) {
  const rom::Network network = tests::small_network();
  Pair run(network, estimated(), 0.46);
  run.command.correction = SwitchOrder::off;
  run.until(1800);
  run.command.correction = SwitchOrder::on;
  const auto error_K = [&] { return run.last.predicted_K[0] - run.machine.model.outputs.key_points_K[0]; };
  const double initial_K = error_K();
  ASSERT_GT(initial_K, 1.0);
  bool crossed = false;
  double after_K = 0.0;
  while (run.n < 5400) {
    run.step();
    crossed = crossed || error_K() < 0.0;
    if (crossed) after_K = std::max(after_K, std::abs(error_K()));
    if (run.n == 2100) {
      EXPECT_LT(std::abs(error_K()), 0.06 * initial_K);
    }
    if (run.n == 2400) {
      EXPECT_LT(std::abs(error_K()), 0.04 * initial_K);
    }
  }
  EXPECT_LT(after_K, 0.1 * initial_K);
}

TEST(EstimatorCycle, without_a_law_it_still_says_how_sure_the_open_loop_is) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.estimator_corrects = false;
  Pair run(network, plan, 0.6);
  run.command.correction = SwitchOrder::on;  // there is nothing to switch on
  run.until(1800);
  EXPECT_EQ(run.last.predicted_K[0], run.last.uncorrected_K[0]);
  EXPECT_FALSE(run.last.correction_configured);
  EXPECT_EQ(run.last.parameters, 0);
  EXPECT_GT(run.last.deformation_deviation_m[0], run.last.nose_network_deviation_m);
  EXPECT_LT(std::abs(run.nose_error_m()), 2.0 * run.last.deformation_deviation_m[0]);
}

TEST(EstimatorCycle, a_correction_is_no_step_for_the_machine) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.slew_m_per_s = 2e-7;
  Pair run(network, plan, 0.3);
  run.command.correction = SwitchOrder::off;
  run.until(1800);
  run.command.correction = SwitchOrder::on;
  double largest_published_m = 0.0;
  double largest_raw_m = 0.0;
  bool slewing = false;
  while (run.n < 1900) {
    const Snapshot before = run.last;
    run.step();
    largest_published_m = std::max(largest_published_m, std::abs(run.last.nose_m - before.nose_m));
    largest_raw_m = std::max(largest_raw_m, std::abs(run.last.deformation_raw_m[0] - before.deformation_raw_m[0]));
    if (run.last.deformation_m[0] == run.last.deformation_raw_m[0]) continue;
    slewing = true;
    EXPECT_NE(run.last.quality & bits(Quality::slewing), 0);
    EXPECT_GE(run.last.deformation_deviation_m[0], std::abs(run.last.deformation_m[0] - run.last.deformation_raw_m[0]));
  }
  EXPECT_TRUE(slewing);
  EXPECT_LE(largest_published_m, 2e-7 * (1.0 + 1e-9));
  EXPECT_GT(largest_raw_m, 1e-6);
  EXPECT_EQ(run.last.deformation_m[0], run.last.deformation_raw_m[0]) << "it arrived";
  EXPECT_EQ(run.last.state, State::running);
}

TEST(EstimatorCycle, a_tare_is_zero_at_once_even_on_the_way) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.slew_m_per_s = 1e-9;
  Pair run(network, plan, 0.5);
  run.until(600);
  ASSERT_NE(run.last.deformation_m[0], run.last.deformation_raw_m[0]);
  ++run.command.tare_orders;
  run.step();
  EXPECT_NEAR(run.last.nose_m, 0.0, 1.01e-9);
}

TEST(EstimatorCycle, repeats_of_a_reading_count_once) {
  const rom::Network network = tests::small_network();
  Pair each(network, estimated(), 0.5);
  each.until(60);
  Pair held(network, estimated(), 0.5);
  DeviceFrame frame;
  for (int n = 0; n < 60; ++n) {
    if (n % 20 == 0) frame = held.machine.frame(at_s(n));
    held.last = held.cycle.step(frame, {}, at_s(n), 0);
    held.machine.advance(1.0);
  }
  EXPECT_TRUE(std::isnan(held.last.sensor_update[0].observation)) << "nothing new since the last update";
  EXPECT_FALSE(std::isnan(each.last.sensor_update[0].observation));

  CyclePlan plan = estimated();
  plan.sensors[0].interval_s = 30.0;
  Pair slow(network, plan, 0.5);
  int taken = 0;
  while (slow.n < 600) {
    const std::uint32_t before = slow.last.updates;
    slow.step();
    if (slow.last.updates != before && !std::isnan(slow.last.sensor_update[0].observation)) ++taken;
  }
  EXPECT_NEAR(taken, 20, 1);
}

TEST(EstimatorCycle, without_a_good_reading_it_says_so_and_grows_unsure) {
  const rom::Network network = tests::small_network();
  Pair run(network, estimated(), 0.5);
  run.until(1800);
  const double sd_K = run.last.predicted_deviation_K[0];
  while (run.n < 5400) {
    run.last = run.cycle.step({}, {}, at_s(run.n++), 0);
  }
  EXPECT_EQ(run.last.correction_freeze, bits(CorrectionFreeze::too_few_sensors));
  EXPECT_NE(run.last.quality & bits(Quality::correction_frozen), 0);
  EXPECT_EQ(run.last.state, State::degraded);
  EXPECT_GT(run.last.predicted_deviation_K[0], sd_K);
}

/// A length of 4 % more than the twin believes teaches the expansion, which a restart must not forget for a cycle.
TEST(EstimatorCycle, a_restart_does_not_move_a_nose_whose_expansion_was_measured) {
  const rom::Network network = tests::small_network();
  Pair run(network, estimated(), 0.5);
  run.until(2700);
  run.command.displacement = {0, 1.04 * run.machine.model.outputs.deformations_m[0] - run.last.tare_m, 1e-8};
  ++run.command.displacements;
  run.until(2760);
  Remembered remembered;
  run.cycle.remember(remembered);
  CyclePlan slow = estimated();
  slow.slew_m_per_s = 1e-9;  // what the restart itself publishes stays
  Cycle again(network, slow, runtime);
  ASSERT_EQ(again.resume(remembered, 0.0), Resumed::temperatures_and_estimator);
  const Snapshot& first = again.step({}, {}, at_s(0), 0);
  EXPECT_NEAR(first.deformation_m[0], run.last.deformation_m[0], 2e-8);
  EXPECT_GT(std::abs(run.last.deformation_raw_m[0] - run.machine.model.outputs.deformations_m[0]), 1e-7);
}

TEST(EstimatorCycle, a_measured_length_is_taken_in_and_counts_from_the_tare) {
  const rom::Network network = tests::small_network();
  Pair run(network, estimated(), 0.5);
  run.until(900);
  ++run.command.tare_orders;
  run.until(2700);
  const double before_m = run.last.deformation_deviation_m[0];
  run.command.displacement = {0, run.machine.model.outputs.deformations_m[0] - run.last.tare_m, 1e-8};
  ++run.command.displacements;
  run.until(2711);
  EXPECT_EQ(run.last.displacement_count, 1);
  EXPECT_NE(run.last.displacement_update.flags & bits(Update::fused), 0);
  EXPECT_LT(run.last.deformation_deviation_m[0], before_m);
  EXPECT_NEAR(run.nose_error_m(), 0.0, 5e-8);
  run.command.displacement = {7, 1e-6, 1e-8};  // the network has two
  ++run.command.displacements;
  run.until(2730);
  run.command.displacement = {0, 1e-6, 0.0};
  ++run.command.displacements;
  run.until(2750);
  EXPECT_EQ(run.last.displacement_count, 1);
}

TEST(EstimatorCycle, a_probe_is_taken_in_each_interval_and_not_when_it_reads_nonsense) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.probes[0] = {true, 1e-8, -1e-4, 1e-4, 60.0, 3.0};
  plan.probes[1] = plan.probes[0];
  Pair run(network, plan, 0.5);
  Pair without(network, estimated(), 0.5);
  while (run.n < 600) {
    DeviceFrame frame = run.machine.frame(at_s(run.n));
    for (std::size_t d = 0; d < 2; ++d) {
      frame.displacements[d] = {run.machine.model.outputs.deformations_m[static_cast<Eigen::Index>(d)], at_s(run.n)};
    }
    if (run.n >= 300) frame.displacements[0].value = not_a_value;
    if (run.n >= 300) frame.displacements[1].value = 2e-4;
    run.last = run.cycle.step(frame, {}, at_s(run.n++), 0);
    run.machine.advance(1.0);
    without.step();
    if (run.n == 295) {
      EXPECT_EQ(run.last.displacement_count, 10) << "5 minutes of two probes, the second an update behind the first";
      EXPECT_NEAR(run.nose_error_m(), 0.0, 5e-8);
      EXPECT_LT(run.last.deformation_deviation_m[0], without.last.deformation_deviation_m[0]);
    }
  }
  EXPECT_EQ(run.last.displacement_count, 10);
}

TEST(EstimatorCycle, no_heap_call_after_warm_up) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.forecast.ahead_s = 900.0;
  Cycle cycle(network, plan, runtime);
  Machine machine(network, 0.5);
  PlcCommand command;
  std::vector<DeviceFrame> frames;
  constexpr int cycles = 1000;
  for (int n = 0; n < cycles; ++n) {
    frames.push_back(machine.frame(at_s(n)));
    machine.advance(1.0);
  }
  long calls_before = 0;
  std::uint32_t updates = 0;
  for (int n = 0; n < cycles; ++n) {
    if (n == 100) calls_before = rom::tests::heap_calls();
    if (n == 300) ++command.tare_orders;
    if (n == 350) {
      command.displacement = {0, 1e-6, 1e-6};
      ++command.displacements;
    }
    if (n == 500) command.correction = SwitchOrder::off;
    if (n == 600) command.correction = SwitchOrder::on;
    updates = cycle.step(frames[static_cast<std::size_t>(n)], command, at_s(n), n % 97 == 0 ? 1 : 0).updates;
  }
  EXPECT_GT(calls_before, 0) << "the counter does not count";
  EXPECT_EQ(rom::tests::heap_calls() - calls_before, 0);
  EXPECT_GT(updates, 50U);
}

}  // namespace cycle_estimator_cycle_test
}  // namespace spindle_twin::firmware
