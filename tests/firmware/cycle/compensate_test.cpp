#include "firmware/cycle/compensate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

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

}  // namespace cycle_compensate_test
}  // namespace spindle_twin::firmware
