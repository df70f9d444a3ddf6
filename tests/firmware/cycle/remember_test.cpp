#include "firmware/cycle/remember.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "tests/firmware/support/machine.hpp"
#include "tests/firmware/support/recorded_steps.hpp"

namespace spindle_twin::firmware {
namespace cycle_remember_test {

constexpr double inf = std::numeric_limits<double>::infinity();

Remembered remembered_of(const rom::Network& network, const CyclePlan& plan, int cycles) {
  Cycle cycle(network, plan, runtime);
  for (int n = 0; n < cycles; ++n) cycle.step({}, {}, at_s(n), 0);
  Remembered remembered;
  cycle.remember(remembered);
  return remembered;
}

/// What becomes of what is remembered, changed like this.
Resumed resumed_with(const std::function<void(Remembered&)>& change) {
  const rom::Network network = tests::small_network();
  Remembered remembered = remembered_of(network, open_loop(), 1);
  change(remembered);
  Cycle cycle(network, open_loop(), runtime);
  return cycle.resume(remembered, 0.0);
}

TEST(Remember, at_the_ends_of_what_a_spindle_can_have_it_is_gone_on_from_and_beyond_it_is_not) {
  const auto expect = [](Resumed wanted, const std::function<void(Remembered&)>& change) {
    EXPECT_EQ(resumed_with(change), wanted);
  };
  for (std::vector<double> Remembered::*field : {&Remembered::nodes_K, &Remembered::uncorrected_K}) {
    for (const double good_K : {173.15, 673.15}) {
      expect(Resumed::temperatures, [&](Remembered& of) { (of.*field)[4] = good_K; });
    }
    for (const double wrong_K : {173.14, 673.16, -300.0}) {
      expect(Resumed::implausible, [&](Remembered& of) { (of.*field)[0] = wrong_K; });
    }
    expect(Resumed::nothing, [&](Remembered& of) { (of.*field)[2] = not_a_value; });
    expect(Resumed::nothing, [&](Remembered& of) { (of.*field)[2] = inf; });
    expect(Resumed::nothing, [&](Remembered& of) { (of.*field).push_back(300.0); });
  }
  for (const double sign : {1.0, -1.0}) {
    expect(Resumed::temperatures, [&](Remembered& of) { of.tare_m = sign * most_tare_m; });
    expect(Resumed::implausible, [&](Remembered& of) { of.tare_m = sign * 1.001 * most_tare_m; });
    expect(Resumed::temperatures, [&](Remembered& of) { of.sensor_tare.offset_K[1] = sign * most_sensor_tare_K; });
    expect(Resumed::implausible, [&](Remembered& of) { of.sensor_tare.offset_K[1] = sign * 50.001; });
  }
  expect(Resumed::nothing, [](Remembered& of) { of.tare_m = not_a_value; });
  expect(Resumed::temperatures, [](Remembered& of) { of.model_time_s = 0.0; });
  expect(Resumed::implausible, [](Remembered& of) { of.model_time_s = -1.0; });
  expect(Resumed::implausible, [](Remembered& of) { of.model_time_s = inf; });
  expect(Resumed::implausible, [](Remembered& of) { of.model_time_s = not_a_value; });
  expect(Resumed::nothing, [](Remembered& of) { of.started = false; });
}

TEST(Remember, a_pause_is_of_no_time_at_least) {
  const rom::Network network = tests::small_network();
  const Remembered remembered = remembered_of(network, open_loop(), 1);
  for (const auto& [gap_s, wanted] :
       {std::pair{0.0, Resumed::temperatures}, {-0.001, Resumed::nothing}, {not_a_value, Resumed::nothing}}) {
    Cycle cycle(network, open_loop(), runtime);
    EXPECT_EQ(cycle.resume(remembered, gap_s), wanted) << gap_s;
  }
}

TEST(Remember, a_pause_is_gone_through_in_equal_steps_of_a_minute_at_most_and_in_500_at_most) {
  const rom::Network network = tests::small_network();
  const Remembered remembered = remembered_of(network, open_loop(), 1);
  struct Case {
    double gap_s;
    std::size_t steps;
  };
  for (const Case& of :
       {Case{0.0, 0}, {1.0, 1}, {60.0, 1}, {61.0, 2}, {120.5, 3}, {30000.0, 500}, {30001.0, 500}, {64000.0, 500}}) {
    RecordedSteps steps;
    Cycle cycle(network, open_loop(), steps.maker());
    ASSERT_EQ(cycle.resume(remembered, of.gap_s), Resumed::temperatures);
    for (const std::size_t model : {0U, 1U}) {
      const std::vector<double> taken = steps.take(model);
      ASSERT_EQ(taken.size(), of.steps) << of.gap_s;
      for (const double step_s : taken) EXPECT_DOUBLE_EQ(step_s, of.gap_s / static_cast<double>(of.steps));
    }
  }
}

/// Stands still, so that only films give heat away, to what surrounded it when it was remembered.
TEST(Remember, a_long_pause_ends_at_the_surroundings_of_before_whatever_they_are_now) {
  const rom::Network network = tests::small_network();
  CyclePlan before = open_loop();
  before.signals[2].value = before.signals[3].value = 310.15;
  const Remembered remembered = remembered_of(network, before, 600);
  ASSERT_GT(remembered.nodes_K[0], 301.0);
  CyclePlan now = open_loop();
  now.signals[0].value = now.signals[1].value = 0.0;
  Cycle cycle(network, now, runtime);
  ASSERT_EQ(cycle.resume(remembered, 90000.0), Resumed::temperatures);
  Remembered after;
  cycle.remember(after);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(after.nodes_K[i], 310.15, 1e-3) << i;
    EXPECT_NEAR(after.uncorrected_K[i], 310.15, 1e-3) << i;
  }
}

TEST(Remember, without_a_pause_everything_that_was_remembered_is_remembered_again) {
  const rom::Network network = tests::small_network();
  Remembered before = remembered_of(network, open_loop(), 300);
  before.tare_m = 3e-6;
  before.trial_away_m = -2e-6;
  before.sensor_tare.count = 2;
  before.sensor_tare.offset_K = {0.1, -0.2, 0.3};
  before.sensor_tare.deviation_K = {0.01, 0.02, 0.03};
  Cycle cycle(network, open_loop(), runtime);
  ASSERT_EQ(cycle.resume(before, 0.0), Resumed::temperatures);
  StandingOrders stands = cycle.standing_orders();
  EXPECT_EQ(stands.tare_m, 3e-6);
  cycle.stand_by_orders(stands);
  Remembered after;
  cycle.remember(after);
  EXPECT_TRUE(after.started);
  EXPECT_EQ(after.nodes_K, before.nodes_K);
  EXPECT_EQ(after.uncorrected_K, before.uncorrected_K);
  EXPECT_EQ(after.tare_m, before.tare_m);
  EXPECT_NEAR(after.trial_away_m, before.trial_away_m, 1e-18);
  EXPECT_EQ(after.sensor_tare.count, before.sensor_tare.count);
  EXPECT_EQ(after.sensor_tare.offset_K, before.sensor_tare.offset_K);
  EXPECT_EQ(after.sensor_tare.deviation_K, before.sensor_tare.deviation_K);
}

TEST(Remember, a_trial_that_is_no_number_leaves_the_compensation_where_it_is_wanted) {
  const rom::Network network = tests::small_network();
  Remembered before = remembered_of(network, open_loop(), 300);
  for (const double away_m : {not_a_value, inf}) {
    before.trial_away_m = away_m;
    Cycle cycle(network, open_loop(), runtime);
    ASSERT_EQ(cycle.resume(before, 0.0), Resumed::temperatures);
    cycle.stand_by_orders(cycle.standing_orders());
    const Snapshot& first = cycle.step({}, {}, at_s(0), 0);
    EXPECT_NEAR(first.compensation.value_m, first.nose_m, 1e-7);
    EXPECT_EQ(first.compensation.bits & bits(CompensationBit::trial), 0);
  }
}

TEST(Remember, a_tare_of_other_sensors_is_none) {
  const rom::Network network = tests::small_network();
  for (const bool of_offsets : {true, false}) {
    Remembered before = remembered_of(network, open_loop(), 1);
    before.sensor_tare = {1, {0.1, 0.1, 0.1}, {0.01, 0.01, 0.01}};
    (of_offsets ? before.sensor_tare.offset_K : before.sensor_tare.deviation_K).pop_back();
    Cycle cycle(network, open_loop(), runtime);
    ASSERT_EQ(cycle.resume(before, 0.0), Resumed::temperatures);
    EXPECT_EQ(cycle.standing_orders().sensor_tare_K[0], 0.0);
    EXPECT_EQ(cycle.standing_orders().sensor_tares, 0U);
  }
}

}  // namespace cycle_remember_test
}  // namespace spindle_twin::firmware
