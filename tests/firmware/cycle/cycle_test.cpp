#include "firmware/cycle/cycle.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "rom/integrate/exact_stepper.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::firmware {
namespace cycle_cycle_test {

TEST(Cycle, open_loop_reaches_the_steady_state_of_the_network) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  for (int n = 0; n < 20000; ++n) cycle.step({}, {}, at_s(n), 0);
  const Snapshot& last = cycle.step({}, {}, at_s(20000), 0);

  Eigen::MatrixXd conductance = network.conduction_W_per_K;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    conductance +=
        network.boundaries.conductances[j].nominal_W_per_m2K * network.factors_m[j] * network.factors_m[j].transpose();
  }
  const Eigen::VectorXd rise_K = conductance.llt().solve(network.source_distribution * Eigen::Vector2d(60.0, 40.0));
  for (Eigen::Index k = 0; k < 3; ++k) {
    EXPECT_NEAR(last.predicted_K[static_cast<std::size_t>(k)], start_K + rise_K[2 + k], 1e-4);
    EXPECT_NEAR(last.uncorrected_K[static_cast<std::size_t>(k)], start_K + rise_K[2 + k], 1e-4);
  }
  EXPECT_NEAR(last.nose_m, network.deformations[0].row_m_per_K.dot(rise_K), 1e-10);
  EXPECT_EQ(last.state, State::running);
  EXPECT_DOUBLE_EQ(last.model_time_s, 20001.0);
}

TEST(Cycle, the_certificate_enters_the_published_deviation_and_its_absence_is_seen) {
  rom::Network network = tests::small_network();
  Cycle certified(network, open_loop(), runtime);
  EXPECT_DOUBLE_EQ(certified.step({}, {}, at_s(0), 0).nose_network_deviation_m, std::hypot(1.5e-8, 1e-8));
  EXPECT_EQ(certified.step({}, {}, at_s(1), 0).quality & bits(Quality::uncertified), 0);
  network.certificate = {};
  network.hand_written = true;
  Cycle uncertified(network, open_loop(), runtime);
  const Snapshot& last = uncertified.step({}, {}, at_s(0), 0);
  EXPECT_TRUE(std::isnan(last.nose_network_deviation_m));
  EXPECT_NE(last.quality & bits(Quality::uncertified), 0);
  EXPECT_EQ(last.state, State::running) << "the configuration allowed it";
}

TEST(Cycle, a_plc_that_ordered_nothing_has_ordered_nothing) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  for (int n = 0; n < 3; ++n) {
    const Snapshot& last = cycle.step({}, {}, at_s(n), 0);
    EXPECT_EQ(last.displacement_orders + last.sensor_orders, 0u) << n;
    for (const OrderKind kind : {OrderKind::tare, OrderKind::length, OrderKind::sensors, OrderKind::acknowledge}) {
      EXPECT_EQ(cycle.order_results()[static_cast<std::size_t>(kind)], OrderResult::none) << n;
    }
  }
}

TEST(Cycle, missed_periods_are_integrated_and_counted) {
  const rom::Network network = tests::small_network();
  Cycle steady(network, open_loop(), runtime);
  Cycle late(network, open_loop(), runtime);
  for (int n = 0; n < 9; ++n) steady.step({}, {}, at_s(n), 0);
  const Snapshot& a = steady.step({}, {}, at_s(9), 0);
  late.step({}, {}, at_s(0), 0);
  const Snapshot& b = late.step({}, {}, at_s(9), 8);
  EXPECT_DOUBLE_EQ(a.model_time_s, b.model_time_s);
  EXPECT_EQ(b.overruns, 8U);
  EXPECT_NE(b.quality & bits(Quality::overrun), 0);
  EXPECT_NEAR(a.predicted_K[0], b.predicted_K[0], 1e-3);
}

TEST(Cycle, correction_finds_the_heat_of_the_machine_and_the_comparison_stays_open_loop) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = corrected();
  plan.paper->joint_law = false;
  plan.paper->guards.reading_uncertainty_K = 0.001;
  plan.paper->guards.minimum_rise_K = 0.05;
  Cycle cycle(network, plan, runtime);
  Cycle open(network, open_loop(), runtime);
  Machine machine(network, 0.5);
  Snapshot last;
  Snapshot uncorrected;
  for (int n = 0; n < 3600; ++n) {
    last = cycle.step(machine.frame(at_s(n)), {}, at_s(n), 0);
    uncorrected = open.step({}, {}, at_s(n), 0);
    machine.advance(1.0);
  }
  EXPECT_NEAR(last.heat_factor[0], 0.5, 0.01);
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto point = static_cast<std::size_t>(k);
    EXPECT_NEAR(last.predicted_K[point], machine.model.outputs.key_points_K[k], 0.02);
    EXPECT_DOUBLE_EQ(last.uncorrected_K[point], uncorrected.predicted_K[point]);
  }
  EXPECT_GT(last.correction_count, 0);
  EXPECT_EQ(last.nose_uncorrected_m, uncorrected.nose_m);
}

TEST(Cycle, correction_off_runs_open_loop) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, corrected(), runtime);
  Machine machine(network, 0.5);
  PlcCommand off;
  off.correction = SwitchOrder::off;
  Snapshot last;
  for (int n = 0; n < 500; ++n) {
    last = cycle.step(machine.frame(at_s(n)), off, at_s(n), 0);
    machine.advance(1.0);
  }
  EXPECT_DOUBLE_EQ(last.predicted_K[0], last.uncorrected_K[0]);
  EXPECT_EQ(last.heat_factor[0], 1.0);
  EXPECT_FALSE(last.correction_enabled);
  EXPECT_NE(last.quality & bits(Quality::correction_off), 0);
  EXPECT_EQ(last.state, State::running);
}

/// With a joint law, so that conductances differ from the described ones too when the correction goes off.
TEST(Cycle, switching_the_correction_off_and_on_moves_no_temperature_and_corrects_no_error_twice) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = corrected();
  plan.paper->guards.reading_uncertainty_K = 0.001;
  plan.paper->guards.minimum_rise_K = 0.05;
  Cycle cycle(network, plan, runtime);
  Machine machine(network, 0.5);
  PlcCommand command;
  int n = 0;
  Snapshot last;
  double largest_step_K = 0.0;
  const auto step = [&] {
    const Snapshot before = last;
    last = cycle.step(machine.frame(at_s(n)), command, at_s(n), 0);
    machine.advance(1.0);
    if (n++ > 0) largest_step_K = std::max(largest_step_K, std::abs(last.predicted_K[0] - before.predicted_K[0]));
  };
  while (n < 1800) step();
  ASSERT_NEAR(last.heat_factor[0], 0.5, 0.02);
  ASSERT_GT(std::abs(last.conductance_factor[1] - 1.0), 0.01);

  largest_step_K = 0.0;
  command.correction = SwitchOrder::off;
  while (n < 2400) step();
  EXPECT_EQ(last.heat_factor[0], 1.0);
  EXPECT_EQ(last.conductance_factor[1], 1.0);
  command.correction = SwitchOrder::on;
  const std::uint16_t corrections = last.correction_count;
  for (int period = 0; period < 79; ++period) step();
  EXPECT_EQ(last.heat_factor[0], 1.0);
  EXPECT_EQ(last.correction_count, corrections);
  // 100 W on the network's 3300 J/K would move all of it by 0.03 K in a cycle, and the bearing's neighbour by no more.
  EXPECT_LT(largest_step_K, 0.03);

  double smallest = 1.0;
  while (n < 4800) {
    step();
    smallest = std::min(smallest, last.heat_factor[0]);
  }
  EXPECT_GT(last.correction_count, corrections);
  EXPECT_GT(smallest, 0.47);
  EXPECT_NEAR(last.heat_factor[0], 0.5, 0.02);
  EXPECT_NEAR(last.predicted_K[0], machine.model.outputs.key_points_K[0], 0.03);
}

TEST(Cycle, no_heap_call_after_warm_up_with_corrections_and_orders) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, corrected(), runtime);
  Machine machine(network, 0.5);
  PlcCommand command;
  Latest<Snapshot> published;
  SnapshotRing ring;
  constexpr int cycles = 1000;
  constexpr int warm_up = 100;
  std::vector<DeviceFrame> frames;
  for (int n = 0; n < cycles; ++n) {
    frames.push_back(machine.frame(at_s(n)));
    machine.advance(1.0);
  }
  std::uint16_t corrections_before = 0;
  std::uint16_t corrections_after = 0;
  long calls_before = 0;
  for (int n = 0; n < cycles; ++n) {
    if (n == warm_up) calls_before = rom::tests::heap_calls();
    if (n == 300) ++command.tare_orders;
    if (n == 500) command.correction = SwitchOrder::off;
    if (n == 600) command.correction = SwitchOrder::on;
    const Snapshot& snapshot = cycle.step(frames[static_cast<std::size_t>(n)], command, at_s(n), n % 97 == 0 ? 1 : 0);
    if (n == warm_up) corrections_before = snapshot.correction_count;
    corrections_after = snapshot.correction_count;
    published.write(snapshot);
    ring.push(snapshot);
  }
  const long calls = rom::tests::heap_calls() - calls_before;
  EXPECT_GT(calls_before, 0) << "the counter does not count";
  EXPECT_EQ(calls, 0);
  EXPECT_GT(corrections_after, corrections_before);
}

TEST(Cycle, tare_makes_the_nose_zero_and_clearing_brings_it_back) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  PlcCommand command;
  int n = 0;
  for (; n < 600; ++n) cycle.step({}, command, at_s(n), 0);
  const double before_m = cycle.step({}, command, at_s(n++), 0).nose_m;
  ASSERT_GT(before_m, 1e-7);
  ++command.tare_orders;
  const Snapshot tared = cycle.step({}, command, at_s(n++), 0);
  EXPECT_NEAR(tared.nose_m, 0.0, 1e-7);
  EXPECT_DOUBLE_EQ(tared.tare_m, before_m);
  EXPECT_DOUBLE_EQ(tared.nose_m, tared.deformation_m[0] - before_m);
  EXPECT_NE(tared.quality & bits(Quality::tared), 0);
  EXPECT_EQ(tared.tare_count, 1);
  ++command.tare_orders;
  command.tare_order = TareOrder::clear;
  const Snapshot cleared = cycle.step({}, command, at_s(n++), 0);
  EXPECT_DOUBLE_EQ(cleared.nose_m, cleared.deformation_m[0]);
  EXPECT_EQ(cleared.tare_count, 2);
}

TEST(Cycle, starts_from_the_mean_of_the_sensors_and_waits_for_all) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = corrected();
  plan.start_temperature_K.reset();
  Cycle cycle(network, plan, runtime);
  DeviceFrame frame;
  frame.connected = true;
  frame.sensors[0] = {301.0, at_s(0)};
  Snapshot snapshot = cycle.step(frame, {}, at_s(0), 0);
  EXPECT_EQ(snapshot.state, State::starting);
  EXPECT_TRUE(std::isnan(snapshot.nose_m));
  frame.sensors[0] = {301.0, at_s(1)};
  frame.sensors[1] = {302.0, at_s(1)};
  frame.sensors[2] = {303.0, at_s(1)};
  snapshot = cycle.step(frame, {}, at_s(1), 0);
  EXPECT_EQ(snapshot.state, State::running);
  EXPECT_NEAR(snapshot.predicted_K[0], 302.0, 0.1);
}

TEST(Cycle, no_reading_to_start_from_is_a_fault_after_the_wait) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = corrected();
  plan.start_temperature_K.reset();
  plan.start_wait_s = 10.0;
  Cycle cycle(network, plan, runtime);
  for (int n = 0; n < 9; ++n) EXPECT_EQ(cycle.step({}, {}, at_s(n), 0).state, State::starting);
  const Snapshot late = cycle.step({}, {}, at_s(9), 0);
  EXPECT_EQ(late.state, State::fault);
  EXPECT_EQ(late.fault, bits(Fault::start_timed_out));
  DeviceFrame one;
  one.connected = true;
  one.sensors[2] = {305.0, at_s(10)};
  const Snapshot started = cycle.step(one, {}, at_s(10), 0);
  EXPECT_EQ(started.state, State::degraded);
  EXPECT_NEAR(started.predicted_K[2], 305.0, 0.25);  // less what the coolant took in one period
}

/// Fails from the given call on.
class FailingStepper final : public rom::Stepper {
 public:
  FailingStepper(std::unique_ptr<rom::Stepper> inner, int good_calls) : inner_(std::move(inner)), left_(good_calls) {}
  void set_temperatures(const Eigen::VectorXd& temperatures_K) override { inner_->set_temperatures(temperatures_K); }
  rom::StepStatus advance(double period_s, const rom::BoundaryValues& values) override {
    return left_-- > 0 ? inner_->advance(period_s, values) : rom::StepStatus::not_finite;
  }
  const Eigen::VectorXd& temperatures_K() const override { return inner_->temperatures_K(); }

 private:
  std::unique_ptr<rom::Stepper> inner_;
  int left_;
};

std::unique_ptr<rom::FallbackStepper> failing(const rom::Network& network, int first_good, int second_good) {
  const auto shared = std::make_shared<const rom::NetworkOperator>(network);
  const auto part = [&](int good) {
    return std::make_unique<FailingStepper>(std::make_unique<rom::ExactStepper>(shared), good);
  };
  return std::make_unique<rom::FallbackStepper>(part(first_good), part(second_good));
}

TEST(Cycle, a_failed_step_is_made_by_the_exact_stepper_and_reported) {
  const rom::Network network = tests::small_network();
  Cycle good(network, open_loop(), [](const rom::Network& of) { return failing(of, 1000, 1000); });
  Cycle bad(network, open_loop(), [](const rom::Network& of) { return failing(of, 5, 1000); });
  Snapshot a;
  Snapshot b;
  for (int n = 0; n < 20; ++n) {
    a = good.step({}, {}, at_s(n), 0);
    b = bad.step({}, {}, at_s(n), 0);
  }
  EXPECT_DOUBLE_EQ(a.predicted_K[0], b.predicted_K[0]);
  EXPECT_EQ(a.fault, 0);
  EXPECT_EQ(b.fault, bits(Fault::integrator_failed));
  EXPECT_NE(b.quality & bits(Quality::integrator_fallback), 0);
  EXPECT_EQ(b.state, State::degraded);
}

TEST(Cycle, when_both_steppers_fail_the_last_good_state_stays_and_a_fault_says_so) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), [](const rom::Network& of) { return failing(of, 5, 0); });
  Snapshot before;
  for (int n = 0; n < 5; ++n) before = cycle.step({}, {}, at_s(n), 0);
  const Snapshot after = cycle.step({}, {}, at_s(5), 0);
  EXPECT_EQ(after.predicted_K[0], before.predicted_K[0]);
  EXPECT_EQ(after.state, State::fault);
  EXPECT_NE(after.fault & bits(Fault::prediction_lost), 0);
}

/// Time moves only by sleeping; each cycle costs `work_ns`.
class SteppedClock final : public Clock {
 public:
  SteppedClock(std::atomic<bool>& stop, std::int64_t end_ns) : stop_(stop), end_ns_(end_ns) {}
  std::int64_t now_ns() const override { return now_ns_; }
  void sleep_until_ns(std::int64_t time_ns) override {
    now_ns_ = std::max(now_ns_, time_ns);
    if (now_ns_ >= end_ns_) stop_.store(true);
  }

 private:
  std::atomic<bool>& stop_;
  std::int64_t end_ns_;
  std::int64_t now_ns_ = 1;
};

TEST(RunCycle, model_time_runs_clock_rate_times_as_fast) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = open_loop();
  plan.clock_rate = 60.0;
  Cycle cycle(network, plan, runtime);
  std::atomic<bool> stop{false};
  SteppedClock clock(stop, 10'000'000'000);
  DeviceInbox frames;
  Latest<PlcSignals> signals;
  Latest<Snapshot> snapshots;
  run_cycle(cycle, plan, clock, {frames, signals, snapshots}, stop);
  Snapshot last;
  ASSERT_TRUE(snapshots.read(last));
  EXPECT_NEAR(last.model_time_s, 600.0, 2.5);  // a cycle at both ends
  EXPECT_EQ(last.overruns, 0U);
}

}  // namespace cycle_cycle_test
}  // namespace spindle_twin::firmware
