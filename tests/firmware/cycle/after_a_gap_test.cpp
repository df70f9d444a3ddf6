#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/firmware/support/machine.hpp"

/// The daemon stood still (SIGSTOP, a debugger, a host that gave its processors away): no cycle ran for many periods.
namespace spindle_twin::firmware {
namespace cycle_after_a_gap_test {

/// A twin at a machine that is as its network says, one cycle a second.
struct Pair {
  explicit Pair(const rom::Network& network, const CyclePlan& plan = estimated())
      : cycle(network, plan, runtime), machine(network, 1.0) {}

  void step(int missed = 0) {
    if (missed > 0) machine.advance(missed);
    n += missed;
    last = cycle.step(machine.frame(at_s(n)), {}, at_s(n), missed);
    machine.advance(1.0);
    ++n;
  }
  void until(int seconds) {
    while (n < seconds) step();
  }

  Cycle cycle;
  Machine machine;
  Snapshot last;
  int n = 0;
};

TEST(AfterAGap, nothing_published_moves_further_than_in_any_other_cycle) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.slew_m_per_s = 1e-9;
  plan.compensation.slew_m_per_s = 2e-9;
  Pair run(network, plan);
  run.until(300);
  ASSERT_NE(run.last.quality & bits(Quality::slewing), 0);
  for (const int missed : {1, 30, 600}) {
    const Snapshot before = run.last;
    run.step(missed);
    EXPECT_NE(run.last.quality & bits(Quality::overrun), 0);
    EXPECT_LE(std::abs(run.last.nose_m - before.nose_m), 1e-9 * (1.0 + 1e-9)) << missed;
    const double way_m = std::abs(run.last.compensation.value_m - before.compensation.value_m);
    EXPECT_LE(way_m, 2e-9 * (1.0 + 1e-9)) << missed;
    EXPECT_NEAR(run.last.model_time_s, before.model_time_s + missed + 1.0, 1e-9);
  }
}

TEST(AfterAGap, readings_are_compared_with_the_model_of_now) {
  const rom::Network network = tests::small_network();
  for (const int missed : {9, 29, 119}) {
    Pair run(network);
    Pair uninterrupted(network);
    run.until(100);
    const Snapshot before = run.last;
    run.step(missed);
    uninterrupted.until(run.n);
    EXPECT_GT(run.last.measured_K[0], before.measured_K[0] + 0.1) << "it warmed meanwhile";
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LT(std::abs(run.last.sensor_update[k].innovation), 0.05) << k << " after " << missed;
      EXPECT_EQ(run.last.sensor_quality[k], SensorQuality::good);
      EXPECT_NEAR(run.last.predicted_K[k], uninterrupted.last.predicted_K[k], 0.02) << k << " after " << missed;
    }
    EXPECT_NEAR(run.last.deformation_raw_m[0], uninterrupted.last.deformation_raw_m[0], 1e-7) << missed;
    EXPECT_EQ(run.last.state, State::running);
  }
}

TEST(AfterAGap, sensors_keep_their_health_and_with_the_published_law_as_well) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.health = correction::HealthLimits{};
  for (const CyclePlan& each : {plan, corrected()}) {
    Pair run(network, each);
    run.until(400);
    for (const int missed : {1, 2, 30, 30, 600, 3}) {
      run.step(missed);
      for (int n = 0; n < 60; ++n) {
        run.step();
        EXPECT_EQ(run.last.sensors_failed, 0) << missed;
        EXPECT_EQ(run.last.sensor_quality[0], SensorQuality::good) << missed;
      }
    }
    EXPECT_EQ(run.last.state, State::running);
  }
}

TEST(AfterAGap, a_stop_of_a_day_is_gone_through) {
  const rom::Network network = tests::small_network();
  Pair run(network);
  run.until(60);
  run.step(86400);
  run.until(run.n + 30);
  EXPECT_EQ(run.last.state, State::running);
  EXPECT_EQ(run.last.overruns, 86400U);
  EXPECT_NEAR(run.last.predicted_K[0], run.machine.model.outputs.key_points_K[0], 0.05);
}

}  // namespace cycle_after_a_gap_test
}  // namespace spindle_twin::firmware
