#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "firmware/cycle/compensate.hpp"
#include "firmware/keep/checkpoint.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/rom/heap_calls.hpp"

/// A known value in the compensation's place, to try the control's input with.
namespace spindle_twin::firmware {
namespace cycle_compensation_trial_test {

constexpr double um = 1e-6;
constexpr double slew_m = 0.5 * um;

CompensationPlan plan() {
  CompensationPlan plan;
  plan.slew_m_per_s = slew_m;
  plan.limit_m = 20.0 * um;
  return plan;
}

/// A compensation of a nose at 4 um, stepped each second of clock and model.
struct Tried {
  explicit Tried(const CompensationPlan& plan, double nose_um = 4.0) : compensation(plan) {
    snapshot.deformations = 1;
    snapshot.state = State::running;
    snapshot.correction_enabled = true;
    snapshot.nose_m = nose_um * um;
    snapshot.deformation_deviation_m[0] = um;
  }
  OrderResult order(double value_um) {
    trial.value_m = value_um * um;
    ++trial.orders;
    return compensation.try_value(trial, now_s());
  }
  void end() { order(not_a_value); }
  void run(int seconds, bool renewed = true) {
    for (int n = 0; n < seconds; ++n) {
      if (renewed) ++trial.renewals;
      compensation.try_value(trial, now_s());
      const double before_m = value_m();
      compensation.step(6, 6, 1.0, snapshot);
      snapshot.clock_ns += 1'000'000'000;
      largest_m = std::max(largest_m, std::abs(value_m() - before_m));
    }
  }
  double now_s() const { return 1e-9 * static_cast<double>(snapshot.clock_ns); }
  double value_m() const { return std::isnan(told().value_m) ? 0.0 : told().value_m; }
  const CompensationState& told() const { return snapshot.compensation; }
  bool has(CompensationBit bit) const { return (told().bits & bits(bit)) != 0; }

  Compensation compensation;
  Snapshot snapshot;
  TrialOrder trial;
  double largest_m = 0.0;
};

TEST(CompensationTrial, goes_there_and_back_at_the_slew_limit_and_says_so_until_it_is_back) {
  Tried tried(plan());
  tried.run(20);
  EXPECT_FALSE(tried.has(CompensationBit::trial));
  EXPECT_TRUE(std::isnan(tried.told().trial_left_s));
  for (const double um_wanted : {10.0, -10.0, 0.0}) {
    EXPECT_EQ(tried.order(um_wanted), OrderResult::done);
    tried.run(1);
    EXPECT_TRUE(tried.has(CompensationBit::trial) && tried.has(CompensationBit::moving));
    tried.run(45);
    EXPECT_NEAR(tried.value_m(), um_wanted * um, 1e-15);
    EXPECT_FALSE(tried.has(CompensationBit::moving));
    EXPECT_TRUE(std::isnan(tried.told().deviation_m)) << "it is no prediction";
  }
  tried.end();
  tried.run(1);
  EXPECT_TRUE(tried.has(CompensationBit::trial)) << "on the way back";
  EXPECT_EQ(tried.told().trial_left_s, 0.0);
  tried.run(10);
  EXPECT_NEAR(tried.value_m(), 4.0 * um, 1e-15);
  EXPECT_FALSE(tried.has(CompensationBit::trial));
  EXPECT_NEAR(tried.told().deviation_m, um, 1e-15);
  EXPECT_LE(tried.largest_m, slew_m * (1.0 + 1e-9));
}

TEST(CompensationTrial, ends_by_itself_a_minute_after_the_last_word_and_ten_minutes_after_the_value_in_any_case) {
  Tried silent(plan());
  silent.order(10.0);
  silent.run(59, false);
  EXPECT_NEAR(silent.value_m(), 10.0 * um, 1e-15);
  EXPECT_NEAR(silent.told().trial_left_s, 2.0, 1e-6);
  silent.run(20, false);
  EXPECT_NEAR(silent.value_m(), 4.0 * um, 1e-15);
  EXPECT_FALSE(silent.has(CompensationBit::trial));
  silent.run(20, true);
  EXPECT_NEAR(silent.value_m(), 4.0 * um, 1e-15) << "a late word begins none";

  Tried renewed(plan());
  renewed.order(10.0);
  renewed.run(599);
  EXPECT_NEAR(renewed.value_m(), 10.0 * um, 1e-15);
  renewed.run(20);
  EXPECT_NEAR(renewed.value_m(), 4.0 * um, 1e-15);
  EXPECT_LE(std::max(renewed.largest_m, silent.largest_m), slew_m * (1.0 + 1e-9));
}

TEST(CompensationTrial, is_refused_beyond_the_limit_and_what_was_there_goes_on) {
  Tried tried(plan());
  tried.run(20);
  for (const double um_wanted : {20.1, -50.0}) EXPECT_EQ(tried.order(um_wanted), OrderResult::refused);
  tried.run(5);
  EXPECT_NEAR(tried.value_m(), 4.0 * um, 1e-15);
  EXPECT_FALSE(tried.has(CompensationBit::trial));
  EXPECT_EQ(tried.order(20.0), OrderResult::done);
}

TEST(CompensationTrial, runs_in_any_state_and_while_switched_off_and_leaves_the_switch_alone) {
  Tried tried(plan());
  tried.compensation.order(SwitchOrder::off);
  tried.snapshot.state = State::starting;
  tried.order(-10.0);
  tried.run(30);
  EXPECT_NEAR(tried.value_m(), -10.0 * um, 1e-15);
  EXPECT_FALSE(tried.has(CompensationBit::enabled));
  EXPECT_EQ(tried.compensation.ordered(), SwitchOrder::off);
  tried.compensation.order(SwitchOrder::off);
  tried.run(5);
  EXPECT_NEAR(tried.value_m(), -10.0 * um, 1e-15) << "the same order again is none";
  tried.end();
  tried.run(30);
  EXPECT_EQ(tried.value_m(), 0.0);
}

TEST(CompensationTrial, switching_the_compensation_off_ends_it) {
  Tried tried(plan());
  tried.order(10.0);
  tried.run(30);
  tried.compensation.order(SwitchOrder::off);
  tried.run(30);
  EXPECT_EQ(tried.value_m(), 0.0);
  EXPECT_FALSE(tried.has(CompensationBit::trial));
  EXPECT_LE(tried.largest_m, slew_m * (1.0 + 1e-9));
}

TEST(CompensationTrial, a_restart_in_the_middle_goes_back_from_where_the_value_was) {
  Tried before(plan());
  before.order(-10.0);
  before.run(40);
  Remembered remembered;
  remembered.trial_away_m = before.compensation.away_m();
  const Checkpoint kept = decode_checkpoint(encode_checkpoint({std::string(64, '0'), 0.0, remembered}), "x");
  Tried after(plan());
  after.compensation.resume_away(kept.remembered.trial_away_m);
  after.compensation.begin_at(after.snapshot);
  after.snapshot.compensation.value_m = before.value_m();
  after.run(1);
  EXPECT_TRUE(after.has(CompensationBit::trial));
  after.run(40);
  EXPECT_NEAR(after.value_m(), 4.0 * um, 1e-15);
  EXPECT_FALSE(after.has(CompensationBit::trial));
  EXPECT_LE(after.largest_m, slew_m * (1.0 + 1e-9));
  EXPECT_EQ(after.compensation.away_m(), 0.0);
}

TEST(CompensationTrial, in_a_cycle_it_makes_no_heap_call_and_no_step_and_another_order_goes_on) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = open_loop();
  plan.compensation = cycle_compensation_trial_test::plan();
  Cycle cycle(network, plan, runtime);
  PlcCommand command;
  double before_m = 0.0, largest_m = 0.0, most_m = 0.0;
  OrderResult result = OrderResult::none;
  int tares = 0;
  long calls_before = 0;
  for (int n = 0; n < 600; ++n) {
    if (n == 100) calls_before = rom::tests::heap_calls();
    if (n == 120 || n == 200 || n == 300) {
      command.trial.value_m = n == 120 ? 10.0 * um : n == 200 ? -10.0 * um : not_a_value;
      ++command.trial.orders;
    }
    if (n == 250) ++command.tare_orders;
    ++command.trial.renewals;
    const Snapshot& snapshot = cycle.step({}, command, at_s(n), n % 97 == 96 ? 2 : 0);
    if (n == 120) result = cycle.order_results()[bits(OrderKind::trial)];
    if (n == 250) tares = snapshot.tare_count;
    if (n > 0) largest_m = std::max(largest_m, std::abs(snapshot.compensation.value_m - before_m));
    before_m = snapshot.compensation.value_m;
    most_m = std::max(most_m, before_m);
  }
  EXPECT_EQ(rom::tests::heap_calls() - calls_before, 0);
  EXPECT_EQ(result, OrderResult::done);
  EXPECT_EQ(tares, 1);
  EXPECT_LE(largest_m, slew_m * (1.0 + 1e-9));
  EXPECT_NEAR(most_m, 10.0 * um, 1e-12);
  EXPECT_EQ(cycle.standing_orders().compensation, SwitchOrder::as_configured);
}

TEST(CompensationTrial, a_network_without_deformations_refuses_it) {
  rom::Network network = tests::small_network();
  network.deformations.clear();
  network.certificate.deformations_m.clear();
  Cycle cycle(network, open_loop(), runtime);
  PlcCommand command;
  command.trial = {5.0 * um, 1, 0};
  cycle.step({}, command, at_s(0), 0);
  EXPECT_EQ(cycle.order_results()[bits(OrderKind::trial)], OrderResult::refused);
}

}  // namespace cycle_compensation_trial_test
}  // namespace spindle_twin::firmware
