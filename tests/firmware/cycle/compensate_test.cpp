#include "firmware/cycle/compensate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace spindle_twin::firmware {
namespace cycle_compensate_test {

constexpr double um = 1e-6;

Snapshot live(double nose_um) {
  Snapshot snapshot;
  snapshot.deformations = 2;
  snapshot.state = State::running;
  snapshot.correction_enabled = true;
  snapshot.nose_m = nose_um * um;
  snapshot.deformation_m = {nose_um * um, 0.0};
  snapshot.deformation_deviation_m[0] = 3.0 * um;
  return snapshot;
}

Snapshot lost(double nose_um) {
  Snapshot snapshot = live(nose_um);
  snapshot.state = State::fault;
  return snapshot;
}

CompensationPlan plan() {
  CompensationPlan plan;
  plan.slew_m_per_s = 0.5 * um;
  plan.limit_m = 40.0 * um;
  plan.warning_m = 30.0 * um;
  plan.hold_s = 100.0;
  plan.decay_s = 1000.0;
  return plan;
}

/// Steps of 1 s with all of six sensors; the largest step that the value made on the way.
double run(Compensation& compensation, Snapshot& snapshot, int steps, std::size_t good = 6) {
  double largest_m = 0.0;
  for (int n = 0; n < steps; ++n) {
    const double before_m = std::isnan(snapshot.compensation.value_m) ? 0.0 : snapshot.compensation.value_m;
    compensation.step(good, 6, 1.0, snapshot);
    largest_m = std::max(largest_m, std::abs(snapshot.compensation.value_m - before_m));
  }
  return largest_m;
}

TEST(Compensation, follows_the_nose_at_the_slew_limit_and_its_deviation_counts_the_way_left) {
  Compensation compensation(plan());
  Snapshot snapshot = live(10.0);
  EXPECT_NEAR(run(compensation, snapshot, 8), 0.5 * um, 1e-15);
  EXPECT_NEAR(snapshot.compensation.value_m, 4.0 * um, 1e-12);
  EXPECT_NEAR(snapshot.compensation.deviation_m, std::hypot(3.0, 6.0) * um, 1e-12);
  EXPECT_NE(snapshot.compensation.bits & bits(CompensationBit::moving), 0);
  run(compensation, snapshot, 40);
  EXPECT_NEAR(snapshot.compensation.value_m, 10.0 * um, 1e-15);
  EXPECT_NEAR(snapshot.compensation.deviation_m, 3.0 * um, 1e-15);
  EXPECT_EQ(snapshot.compensation.bits, bits(CompensationBit::enabled));
  EXPECT_EQ(snapshot.compensation.rung, Rung::estimator);
}

TEST(Compensation, the_ladder_goes_down_and_up_without_a_step) {
  Compensation compensation(plan());
  Snapshot snapshot = live(10.0);
  run(compensation, snapshot, 60);
  double largest_m = run(compensation, snapshot, 5, 4);
  EXPECT_EQ(snapshot.compensation.rung, Rung::fewer_sensors);
  Snapshot open = live(25.0);
  open.compensation = snapshot.compensation;
  open.correction_enabled = false;
  largest_m = std::max(largest_m, run(compensation, open, 60));
  EXPECT_EQ(open.compensation.rung, Rung::open_loop);
  EXPECT_NEAR(open.compensation.value_m, 25.0 * um, 1e-15);
  open.signals_held = 1;  // the speed: nothing is left to predict from
  largest_m = std::max(largest_m, run(compensation, open, 50));
  EXPECT_EQ(open.compensation.rung, Rung::hold);
  EXPECT_NEAR(open.compensation.value_m, 25.0 * um, 1e-15);
  EXPECT_EQ(open.compensation.age_s, 50.0);
  EXPECT_TRUE(std::isnan(open.compensation.deviation_m));
  largest_m = std::max(largest_m, run(compensation, open, 1050));
  EXPECT_EQ(open.compensation.rung, Rung::decay);
  EXPECT_NEAR(open.compensation.value_m, 25.0 * um * std::exp(-1.0), 1e-9 * um);
  Snapshot again = live(10.0);
  again.compensation = open.compensation;
  largest_m = std::max(largest_m, run(compensation, again, 60));
  EXPECT_EQ(again.compensation.rung, Rung::estimator);
  EXPECT_NEAR(again.compensation.value_m, 10.0 * um, 1e-15);
  EXPECT_LE(largest_m, 0.5 * um * (1.0 + 1e-9));
}

TEST(Compensation, of_a_pause_only_what_passes_while_the_prediction_is_lost_makes_it_older) {
  for (const bool lost_before : {false, true}) {
    Compensation compensation(plan());
    Snapshot snapshot = live(10.0);
    run(compensation, snapshot, 60);
    Snapshot gone = lost(10.0);
    gone.compensation = snapshot.compensation;
    if (lost_before) run(compensation, gone, 10);
    compensation.pass(500.0);
    run(compensation, gone, 1);
    EXPECT_EQ(gone.compensation.rung, lost_before ? Rung::decay : Rung::hold);
    EXPECT_EQ(gone.compensation.age_s, lost_before ? 511.0 : 1.0);
  }
}

TEST(Compensation, held_for_ever_where_the_plan_says_so) {
  CompensationPlan holds = plan();
  holds.on_loss = OnLoss::hold;
  Compensation compensation(holds);
  Snapshot snapshot = live(10.0);
  run(compensation, snapshot, 60);
  Snapshot gone = lost(-300.0);  // what a dead prediction says does not matter
  gone.compensation = snapshot.compensation;
  run(compensation, gone, 100000);
  EXPECT_EQ(gone.compensation.rung, Rung::hold);
  EXPECT_NEAR(gone.compensation.value_m, 10.0 * um, 1e-15);
}

TEST(Compensation, goes_on_after_a_restart_from_where_the_nose_is) {
  for (const SwitchOrder order : {SwitchOrder::as_configured, SwitchOrder::off}) {
    Compensation compensation(plan());
    compensation.order(order);
    Snapshot snapshot = live(20.0);
    compensation.begin_at(snapshot);
    run(compensation, snapshot, 1);
    EXPECT_NEAR(snapshot.compensation.value_m, order == SwitchOrder::off ? 0.0 : 20.0 * um, 1e-15);
  }
}

TEST(Compensation, lost_right_after_a_restart_it_holds_what_it_began_with) {
  Compensation compensation(plan());
  compensation.begin_at(live(20.0));
  Snapshot gone = lost(-300.0);
  run(compensation, gone, 10);
  EXPECT_EQ(gone.compensation.rung, Rung::hold);
  EXPECT_NEAR(gone.compensation.value_m, 20.0 * um, 1e-15);
  EXPECT_EQ(gone.compensation.age_s, 10.0);
}

TEST(Compensation, is_zero_before_the_first_prediction) {
  Compensation compensation(plan());
  Snapshot snapshot = lost(10.0);
  snapshot.state = State::starting;
  run(compensation, snapshot, 10);
  EXPECT_EQ(snapshot.compensation.rung, Rung::none);
  EXPECT_EQ(snapshot.compensation.value_m, 0.0);
  EXPECT_EQ(snapshot.compensation.age_s, 0.0);
}

TEST(Compensation, switching_off_and_on_is_no_step) {
  Compensation compensation(plan());
  Snapshot snapshot = live(10.0);
  run(compensation, snapshot, 60);
  compensation.order(SwitchOrder::off);
  double largest_m = run(compensation, snapshot, 60);
  EXPECT_EQ(snapshot.compensation.value_m, 0.0);
  EXPECT_EQ(snapshot.compensation.bits & bits(CompensationBit::enabled), 0);
  EXPECT_TRUE(std::isnan(snapshot.compensation.deviation_m));
  compensation.order(SwitchOrder::on);
  largest_m = std::max(largest_m, run(compensation, snapshot, 60));
  EXPECT_NEAR(snapshot.compensation.value_m, 10.0 * um, 1e-15);
  EXPECT_LE(largest_m, 0.5 * um * (1.0 + 1e-9));
}

TEST(Compensation, warns_and_stays_within_its_limit) {
  CompensationPlan counter = plan();
  counter.sign = -1.0;
  Compensation compensation(counter);
  Snapshot snapshot = live(35.0);
  run(compensation, snapshot, 200);
  EXPECT_NEAR(snapshot.compensation.value_m, -35.0 * um, 1e-15);
  EXPECT_EQ(snapshot.compensation.bits, bits(CompensationBit::enabled) | bits(CompensationBit::warning));
  snapshot.nose_m = 70.0 * um;
  run(compensation, snapshot, 200);
  EXPECT_NEAR(snapshot.compensation.value_m, -40.0 * um, 1e-15);
  EXPECT_NE(snapshot.compensation.bits & bits(CompensationBit::limited), 0);
}

TEST(Compensation, changes_by_whole_steps_where_the_control_wants_them) {
  CompensationPlan stepped = plan();
  stepped.step_m = 2.0 * um;
  Compensation compensation(stepped);
  Snapshot snapshot = live(7.0);
  for (int n = 0; n < 60; ++n) {
    run(compensation, snapshot, 1);
    const double steps = snapshot.compensation.value_m / (2.0 * um);
    ASSERT_NEAR(steps, std::round(steps), 1e-9);
    ASSERT_LE(std::abs(snapshot.compensation.value_m - std::min(7.0, 0.5 * (n + 1)) * um), 2.0 * um);
  }
  EXPECT_NEAR(snapshot.compensation.deviation_m, std::hypot(3.0, snapshot.compensation.value_m / um - 7.0) * um, 1e-12);
}

TEST(Compensation, begins_with_a_whole_step_too_and_moves_on_from_there) {
  CompensationPlan stepped = plan();
  stepped.step_m = 2.0 * um;
  Compensation compensation(stepped);
  Snapshot snapshot = live(7.3);
  compensation.begin_at(snapshot);
  compensation.step(3, 3, 0.0, snapshot);
  EXPECT_NEAR(snapshot.compensation.value_m, 8.0 * um, 1e-15);
  snapshot.nose_m = 9.0 * um;
  run(compensation, snapshot, 60);
  EXPECT_NEAR(snapshot.compensation.value_m, 8.0 * um, 1e-15) << "less than a step away";
}

TEST(Compensation, begins_with_the_nearest_whole_step_also_where_that_is_the_first) {
  for (const double side : {1.0, -1.0}) {
    CompensationPlan stepped = plan();
    stepped.step_m = 2.0 * um;
    Compensation compensation(stepped);
    Snapshot snapshot = live(side * 1.3);
    compensation.begin_at(snapshot);
    compensation.step(3, 3, 0.0, snapshot);
    EXPECT_NEAR(snapshot.compensation.value_m, side * 2.0 * um, 1e-15);
  }
}

TEST(Compensation, the_slope_is_that_between_nose_and_the_other_output) {
  CompensationPlan along = plan();
  along.other = 1;
  along.distance_m = -0.25;
  along.reference_m = 0.1;
  along.sign = -1.0;
  Compensation compensation(along);
  Snapshot snapshot = live(10.0);
  run(compensation, snapshot, 60);
  EXPECT_NEAR(snapshot.compensation.slope, -1.0 * (0.0 - 10.0 * um) / -0.25, 1e-15);
  EXPECT_EQ(snapshot.compensation.reference_m, 0.1);
}

TEST(Compensation, holds_for_as_long_as_is_planned_and_decays_from_the_held_value_on_without_a_step) {
  for (const OnLoss on_loss : {OnLoss::decay, OnLoss::hold}) {
    CompensationPlan loses = plan();
    loses.on_loss = on_loss;
    Compensation compensation(loses);
    Snapshot snapshot = live(10.0);
    run(compensation, snapshot, 60);
    Snapshot gone = lost(10.0);
    gone.compensation = snapshot.compensation;
    EXPECT_EQ(run(compensation, gone, 100), 0.0);
    EXPECT_EQ(gone.compensation.rung, Rung::hold);
    run(compensation, gone, 1);
    EXPECT_EQ(gone.compensation.rung, on_loss == OnLoss::decay ? Rung::decay : Rung::hold) << "after the 100 s";
    EXPECT_NEAR(gone.compensation.value_m, 10.0 * um * (on_loss == OnLoss::decay ? std::exp(-1e-3) : 1.0), 1e-15);
  }
}

TEST(Compensation, a_loss_of_less_than_a_second_grows_older_by_a_pause_as_well) {
  Compensation compensation(plan());
  Snapshot snapshot = live(10.0);
  run(compensation, snapshot, 60);
  Snapshot gone = lost(10.0);
  compensation.step(6, 6, 0.25, gone);
  compensation.pass(500.0);
  compensation.step(6, 6, 0.25, gone);
  EXPECT_EQ(gone.compensation.age_s, 500.5);
  EXPECT_EQ(gone.compensation.rung, Rung::decay);
}

TEST(Compensation, at_the_warning_and_at_the_limit_it_is_neither_warned_of_nor_limited) {
  CompensationPlan exact = plan();
  exact.warning_m = 30.0;
  exact.limit_m = 40.0;
  exact.slew_m_per_s = 1000.0;
  Compensation compensation(exact);
  constexpr int warned = bits(CompensationBit::warning), limited = bits(CompensationBit::limited);
  for (const auto& [nose_m, told] : {std::pair{30.0, 0}, {30.5, warned}, {40.0, warned}, {40.5, warned | limited}}) {
    for (const double side : {1.0, -1.0}) {
      Snapshot snapshot = live(0.0);
      snapshot.nose_m = side * nose_m;
      compensation.step(6, 6, 1.0, snapshot);
      EXPECT_EQ(snapshot.compensation.bits & (warned | limited), told) << side * nose_m;
      EXPECT_EQ(snapshot.compensation.value_m, side * std::min(nose_m, 40.0));
    }
  }
  Snapshot gone = lost(0.0);
  for (const double passed_s : {1099.0, 1.0}) compensation.step(6, 6, passed_s, gone);
  EXPECT_EQ(gone.compensation.bits & (warned | limited), 0) << "what is left of 40.5 after the decay";
  EXPECT_NEAR(gone.compensation.value_m, -40.5 * std::exp(-1.0), 1e-12);
}

TEST(Compensation, a_value_that_has_moved_by_a_whole_step_is_told) {
  CompensationPlan stepped;
  stepped.step_m = 0.25;
  stepped.slew_m_per_s = 0.125;
  Compensation compensation(stepped);
  Snapshot snapshot = live(0.0);
  snapshot.nose_m = 0.625;
  for (const double told_m : {0.0, 0.25, 0.25, 0.5, 0.5, 0.5}) {
    compensation.step(6, 6, 1.0, snapshot);
    EXPECT_EQ(snapshot.compensation.value_m, told_m);
  }
  EXPECT_EQ(snapshot.compensation.bits & bits(CompensationBit::moving), 0) << "it is where it is wanted";
  EXPECT_EQ(snapshot.compensation.deviation_m, std::hypot(3.0 * um, 0.125));
}

TEST(Compensation, moves_by_slew_times_time) {
  CompensationPlan slow;
  slow.slew_m_per_s = 0.25;
  Compensation compensation(slow);
  Snapshot snapshot = live(0.0);
  snapshot.nose_m = 100.0;
  compensation.step(6, 6, 4.0, snapshot);
  EXPECT_EQ(snapshot.compensation.value_m, 1.0);
  EXPECT_EQ(snapshot.compensation.bits, bits(CompensationBit::enabled) | bits(CompensationBit::moving));
  compensation.step(6, 6, 0.5, snapshot);
  EXPECT_EQ(snapshot.compensation.value_m, 1.125);
}

TEST(Compensation, the_open_loop_needs_speed_and_load_and_no_other_signal) {
  for (std::size_t signal = 0; signal < 4; ++signal) {
    Compensation compensation(plan());
    Snapshot snapshot = live(10.0);
    snapshot.correction_enabled = false;
    run(compensation, snapshot, 30);
    snapshot.signals_held = static_cast<std::uint16_t>(1U << signal);
    run(compensation, snapshot, 1);
    const bool drives =
        signal == static_cast<std::size_t>(Signal::speed) || signal == static_cast<std::size_t>(Signal::load);
    EXPECT_EQ(snapshot.compensation.rung, drives ? Rung::hold : Rung::open_loop) << signal;
    snapshot.correction_enabled = true;
    run(compensation, snapshot, 1, 0);
    EXPECT_EQ(snapshot.compensation.rung, drives ? Rung::hold : Rung::open_loop) << "no sensor corrects";
    run(compensation, snapshot, 1, 1);
    EXPECT_EQ(snapshot.compensation.rung, Rung::fewer_sensors) << "one is enough";
    snapshot.state = State::degraded;
    run(compensation, snapshot, 1);
    EXPECT_EQ(snapshot.compensation.rung, Rung::estimator) << "degraded is no loss";
  }
}

TEST(Compensation, without_an_output_to_compare_or_while_off_there_is_no_slope_and_without_a_nose_nothing) {
  CompensationPlan along = plan();
  along.other = 1;
  along.distance_m = 0.25;
  for (const bool is_there : {true, false}) {
    for (const SwitchOrder order : {SwitchOrder::on, SwitchOrder::off}) {
      Compensation compensation(along);
      compensation.order(order);
      Snapshot snapshot = live(10.0);
      snapshot.deformations = is_there ? 2 : 1;
      snapshot.deformation_m = {10.0 * um, 30.0 * um};
      run(compensation, snapshot, 3);
      const bool has_slope = is_there && order == SwitchOrder::on;
      EXPECT_NEAR(snapshot.compensation.slope, has_slope ? 80.0 * um : 0.0, 1e-15);
      EXPECT_EQ(snapshot.compensation.reference_m, 0.0);
    }
  }
  Compensation compensation(plan());
  Snapshot bare = live(10.0);
  bare.deformations = 0;
  bare.compensation.rung = Rung::hold;
  compensation.step(6, 6, 1.0, bare);
  EXPECT_TRUE(std::isnan(bare.compensation.value_m));
  EXPECT_EQ(bare.compensation.rung, CompensationState{}.rung);
}

}  // namespace cycle_compensate_test
}  // namespace spindle_twin::firmware
