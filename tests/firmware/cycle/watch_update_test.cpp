#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/firmware/support/watched.hpp"

/// What the estimate goes over to when sensors fail by what the others say, whichever they are.
namespace spindle_twin::firmware {
namespace cycle_watch_update_test {

double nose_error_m(const Watched& run) {
  return run.last.deformation_raw_m[0] - run.machine.model.outputs.deformations_m[0];
}

/// Second by second until a sensor is out. Gives the second, `most` where none is.
int until_one_fails(Watched& run, int most) {
  while (run.n < most && run.last.sensors_failed == 0) run.until(run.n + 1);
  return run.n;
}

/// How sure the first heat is, beside its prior.
double heat_deviation(const Watched& run) {
  Remembered now;
  run.cycle.remember(now);
  return now.parameters[0].deviation / now.parameters[0].prior_deviation;
}

TEST(WatchUpdate, two_that_are_swapped_fail_as_each_others_partners_and_the_third_goes_on) {
  const rom::Network network = tests::small_network();
  for (const int at : {600, 2700}) {
    Watched run(network, estimated(), 0.5);
    run.tamper = [&](int n, DeviceFrame& frame) {
      if (n >= at) std::swap(frame.sensors[0].value, frame.sensors[2].value);
    };
    run.until(at);
    ASSERT_EQ(run.last.sensors_failed, 0);
    EXPECT_LT(until_one_fails(run, at + 60), at + 60);
    EXPECT_EQ(run.last.sensors_failed, 2);
    for (const std::size_t k : {0U, 2U}) {
      EXPECT_EQ(run.last.sensor_health[k].fault, SensorFault::swapped);
      EXPECT_EQ(run.last.sensor_health[k].partner, static_cast<int>(2 - k));
    }
    EXPECT_EQ(run.last.sensor_health[1].state, SensorState::good);
    run.until(at + 600);
    EXPECT_EQ(run.last.sensor_quality[1], SensorQuality::good);
    EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]) << at;
  }
}

/// Whether each of the two reads the other's place, as it is published.
bool read_crossed(const Watched& run) {
  const auto by_partner = [&](std::size_t k) {
    return (run.last.sensor_update[k].flags & bits(Update::by_partner)) != 0;
  };
  return by_partner(0) && by_partner(2) && !by_partner(1);
}

TEST(WatchUpdate, two_that_are_swapped_are_read_for_each_others_places_until_somebody_acknowledges) {
  const rom::Network network = tests::small_network();
  std::array<double, 2> deviation_m{};
  for (const bool read : {false, true}) {
    CyclePlan plan = estimated();
    plan.health->read_swapped = read;
    Watched run(network, plan, 0.8);
    bool mended = false;
    run.tamper = [&](int n, DeviceFrame& frame) {
      if (n >= 600 && !mended) std::swap(frame.sensors[0].value, frame.sensors[2].value);
    };
    run.until(10);
    run.heap_calls = 0;  // of the first cycles
    until_one_fails(run, 1200);
    ASSERT_EQ(run.last.sensors_failed, 2);
    run.until(7200);
    EXPECT_EQ(run.last.sensors_failed, 2) << "they stay failed";
    EXPECT_EQ(run.last.state, State::degraded);
    EXPECT_EQ(read_crossed(run), read);
    EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]);
    deviation_m[read ? 1 : 0] = run.last.deformation_deviation_m[0];
    EXPECT_EQ(run.heap_calls, 0);
    mended = true;
    run.give(SensorOrder::acknowledge, 900);
    EXPECT_EQ(run.last.sensors_failed, 0);
    EXPECT_FALSE(read_crossed(run));
    EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]);
  }
  EXPECT_LT(deviation_m[1], 0.8 * deviation_m[0]) << "of three sensors more is known than of one";
}

TEST(WatchUpdate, two_that_somebody_swaps_back_without_a_word_are_not_read_for_each_other_any_more) {
  const rom::Network network = tests::small_network();
  Watched run(network, estimated(), 0.8);
  run.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 600 && n < 5400) std::swap(frame.sensors[0].value, frame.sensors[2].value);
  };
  run.until(5400);
  ASSERT_TRUE(read_crossed(run));
  while (run.n < 7200 && read_crossed(run)) run.until(run.n + 1);
  EXPECT_LT(run.n, 5400 + 300);
  EXPECT_EQ(run.last.sensors_failed, 2);
  run.until(9000);
  EXPECT_FALSE(read_crossed(run));
  EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]);
}

TEST(WatchUpdate, two_that_are_read_for_each_other_are_so_after_a_restart_as_well) {
  const rom::Network network = tests::small_network();
  Watched before(network, estimated(), 0.8);
  before.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 600) std::swap(frame.sensors[0].value, frame.sensors[2].value);
  };
  before.until(2400);
  ASSERT_TRUE(read_crossed(before));
  Remembered remembered;
  before.cycle.remember(remembered);
  Watched after(network, estimated(), 0.8);
  after.tamper = [](int, DeviceFrame& frame) { std::swap(frame.sensors[0].value, frame.sensors[2].value); };
  ASSERT_NE(after.cycle.resume(remembered, 0.0), Resumed::nothing);
  after.machine.model.stepper->set_temperatures(before.machine.model.stepper->temperatures_K());
  predict(network, after.machine.model);
  after.until(30);
  EXPECT_EQ(after.last.sensors_failed, 2);
  EXPECT_TRUE(read_crossed(after));
  EXPECT_TRUE((after.last.sensor_update[0].flags & bits(Update::fused)) != 0);
}

/// No filter has done without both: what is left of the first minutes is what was known before them.
TEST(WatchUpdate, two_that_were_swapped_from_the_start_on_take_the_estimate_back_to_its_priors) {
  const rom::Network network = tests::small_network();
  Watched run(network, estimated(), 0.8);
  run.tamper = [](int, DeviceFrame& frame) { std::swap(frame.sensors[0].value, frame.sensors[2].value); };
  double before = 1.0;
  while (run.n < 1200 && run.last.sensors_failed == 0) {
    before = run.n > 1 ? heat_deviation(run) : before;
    run.until(run.n + 1);
  }
  EXPECT_EQ(run.last.sensors_failed, 2);
  EXPECT_EQ(run.last.sensor_health[0].partner, 2);
  EXPECT_LT(before, 0.9) << "it had learnt something";
  EXPECT_NEAR(heat_deviation(run), 1.0, 0.02);
}

/// The swap is made while both are unplugged and the spindle stands: no sample shows it, and what they moved like
/// before says nothing any more. What was learnt of the machine hours ago was not learnt from the swap.
TEST(WatchUpdate, two_that_are_swapped_while_unplugged_are_found_and_what_was_learnt_before_is_kept) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.signals[0].source = plan.signals[1].source = SignalSource::device;
  constexpr int out = 5400, back = 9000;
  for (const double heat : {0.8, 1.3}) {
    Watched run(network, plan, heat);
    run.tamper = [&](int n, DeviceFrame& frame) {
      const bool runs = n < out || n >= back;
      run.machine.operating.speed_rpm = runs ? plan.signals[0].value : 0.0;
      run.machine.operating.load = runs ? 1.0 : 0.0;
      frame.signals[0] = {run.machine.operating.speed_rpm, at_s(n)};
      frame.signals[1] = {run.machine.operating.load, at_s(n)};
      if (n >= out) std::swap(frame.sensors[0], frame.sensors[2]);
      for (const std::size_t k : {0U, 2U}) {
        if (n >= out && n < back) frame.sensors[k].time_ns = at_s(out - 1);
      }
    };
    run.until(out);
    const double before = heat_deviation(run);
    EXPECT_LT(before, 0.6) << "it had learnt something";
    run.heap_calls = 0;
    run.until(back);
    ASSERT_EQ(run.last.sensors_failed, 0);
    EXPECT_LT(until_one_fails(run, back + 450), back + 450) << heat;
    EXPECT_EQ(run.last.sensors_failed, 2) << heat;
    EXPECT_EQ(run.last.sensor_health[0].partner, 2) << heat;
    EXPECT_LT(heat_deviation(run), 0.5 * (before + 1.0)) << heat;
    for (const int more : {600, 1800}) {
      run.until(run.n + more);
      EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]) << heat << ", " << more;
    }
    EXPECT_EQ(run.heap_calls, 0);
  }
}

/// A minute one after the other: what the first taught meanwhile is forgotten, and not what was known before the gap.
TEST(WatchUpdate, two_that_come_back_swapped_one_after_the_other_leave_what_was_learnt_before) {
  const rom::Network network = tests::small_network();
  constexpr int out = 1800, back = 2100, both = 2160;
  Watched run(network, estimated(), 1.4);
  run.tamper = [](int n, DeviceFrame& frame) {
    if (n >= out) std::swap(frame.sensors[0], frame.sensors[2]);
    if (n >= out && n < back) frame.sensors[0].time_ns = at_s(out - 1);
    if (n >= out && n < both) frame.sensors[2].time_ns = at_s(out - 1);
  };
  run.until(out);
  const double before = heat_deviation(run);
  EXPECT_LT(before, 0.7) << "it had learnt something";
  run.until(both + 1);
  EXPECT_EQ(run.last.sensors_failed, 2);
  run.until(both + 30);
  EXPECT_LT(heat_deviation(run), 0.5 * (before + 1.0));
  while (run.n < both + 1800) {
    run.until(run.n + 10);
    EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]) << run.n;
    EXPECT_TRUE(read_crossed(run)) << run.n;
  }
}

/// Five minutes without readings while the spindle runs: their first reading shows it, and is not used.
TEST(WatchUpdate, two_that_come_back_on_each_others_course_are_found_with_their_first_reading) {
  const rom::Network network = tests::small_network();
  constexpr int out = 1800, back = 2100;
  for (const double heat : {0.7, 1.4}) {
    Watched run(network, estimated(), heat);
    run.tamper = [](int n, DeviceFrame& frame) {
      if (n >= out) std::swap(frame.sensors[0], frame.sensors[2]);
      for (const std::size_t k : {0U, 2U}) {
        if (n >= out && n < back) frame.sensors[k].time_ns = at_s(out - 1);
      }
    };
    run.until(back);
    ASSERT_EQ(run.last.sensors_failed, 0);
    run.until(back + 1);
    EXPECT_EQ(run.last.sensors_failed, 2) << heat;
    EXPECT_EQ(run.last.sensor_health[0].partner, 2) << heat;
    while (run.n < back + 1800) {
      run.until(run.n + 10);
      EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]) << heat << ", " << run.n;
      EXPECT_TRUE(read_crossed(run)) << heat << ", " << run.n;
    }
  }
}

TEST(WatchUpdate, one_that_drifts_fails_alone_whichever_it_is_and_the_truth_stays_inside_behind_it) {
  const rom::Network network = tests::small_network();
  for (const std::size_t drifting : {0U, 2U}) {
    Watched run(network, estimated(), 0.5);
    run.tamper = [&](int n, DeviceFrame& frame) {
      frame.sensors[drifting].value -= std::max(0, n - 1200) * 10.0 / 3600.0;
    };
    EXPECT_LT(until_one_fails(run, 2400), 2400);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(run.last.sensor_health[k].fault, k == drifting ? SensorFault::drift : SensorFault::none) << k;
    }
    run.until(run.n + 600);
    EXPECT_EQ(run.last.sensors_failed, 1);
    EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]) << drifting;
  }
}

/// Fast enough that the estimate is loosened first and then follows the sensor.
TEST(WatchUpdate, one_that_a_loosened_estimate_follows_is_left_out_whichever_it_is) {
  const rom::Network network = tests::small_network();
  for (const std::size_t drifting : {0U, 2U}) {
    Watched run(network, estimated(), 0.5);
    run.tamper = [&](int n, DeviceFrame& frame) {
      frame.sensors[drifting].value -= std::max(0, n - 1200) * 20.0 / 3600.0;
    };
    EXPECT_LT(until_one_fails(run, 3600), 3600);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(run.last.sensor_health[k].state, k == drifting ? SensorState::failed : SensorState::good) << k;
    }
    run.until(run.n + 60);
    EXPECT_LT(std::abs(nose_error_m(run)), 2.0 * run.last.deformation_deviation_m[0]) << drifting;
  }
}

TEST(WatchUpdate, an_offset_that_was_wrong_all_the_time_is_opened_also_of_the_first_sensor) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.estimator->offset_deviation_K = 0.02;
  for (SensorPlan& sensor : plan.sensors) sensor.offset_deviation_K = 0.02;
  Watched run(network, plan, 0.5);
  run.tamper = [&](int n, DeviceFrame& frame) {
    frame.sensors[0].value += std::clamp((n - 600) * 0.5 / 3600.0, 0.0, 0.5);
  };
  run.until(100);
  double offset_K = 0.0, most_learnt_K = 0.0;
  while (run.n < 5400 && most_learnt_K < 0.02) {
    run.until(run.n + 10);
    most_learnt_K = std::max(most_learnt_K, run.last.sensor_update[0].offset - offset_K);
    offset_K = run.last.sensor_update[0].offset;
  }
  EXPECT_GE(most_learnt_K, 0.02);
  EXPECT_EQ(run.last.sensors_failed, 0);
}

/// Where nobody looks for a heat that no source explains, sensors are judged all the same.
TEST(WatchUpdate, without_unexplained_heats_a_drift_is_found_too) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.estimator->priors.disturbance = 0.0;
  Watched run(network, plan, 0.5);
  run.tamper = [](int n, DeviceFrame& frame) { frame.sensors[0].value -= std::max(0, n - 1200) * 10.0 / 3600.0; };
  EXPECT_LT(until_one_fails(run, 3000), 3000);
  EXPECT_EQ(run.last.sensor_health[0].fault, SensorFault::drift);
}

TEST(WatchUpdate, from_the_first_update_on_each_sensor_is_judged_by_the_others) {
  const rom::Network network = tests::small_network();
  Watched run(network, estimated(), 0.5);
  while (run.last.updates == 0 && run.n < 100) run.until(run.n + 1);
  ASSERT_EQ(run.last.updates, 1U);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(std::isfinite(run.last.sensor_health[k].misfit_ratio)) << k;
}

/// Off, the estimator stands by with what it knew; on again, nothing of before is held against a sensor.
TEST(WatchUpdate, switched_off_and_on_no_sensor_fails_for_what_it_read_meanwhile) {
  const rom::Network network = tests::small_network();
  Watched run(network, estimated(), 0.5);
  run.until(1200);
  run.command.correction = SwitchOrder::off;
  run.until(2400);
  EXPECT_EQ(run.last.sensors_failed, 0);
  run.command.correction = SwitchOrder::on;
  run.until(3600);
  EXPECT_EQ(run.last.sensors_failed, 0);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(run.last.sensor_quality[k], SensorQuality::good);
}

}  // namespace cycle_watch_update_test
}  // namespace spindle_twin::firmware
