#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "firmware/keep/checkpoint.hpp"
#include "tests/firmware/support/watched.hpp"

namespace spindle_twin::firmware {
namespace cycle_resumed_health_test {

CyclePlan watched() {
  CyclePlan plan = estimated();
  plan.health = correction::HealthLimits{};
  return plan;
}

/// Of a run, by way of the file.
Remembered remembered_of(const Watched& run) {
  Checkpoint checkpoint;
  run.cycle.remember(checkpoint.remembered);
  return decode_checkpoint(encode_checkpoint(checkpoint), "x").remembered;
}

TEST(ResumedHealth, a_sensor_that_failed_has_failed_after_a_restart_as_well_and_comes_back_by_its_probation) {
  const rom::Network network = tests::small_network();
  Watched before(network, watched(), 0.8);
  before.tamper = [](int n, DeviceFrame& frame) {
    if (n > 600) frame.sensors[1].value = 1123.15;  // a broken wire
  };
  before.until(660);
  ASSERT_EQ(before.last.sensor_health[1].state, SensorState::failed);

  Watched after(network, watched(), 0.8);
  ASSERT_NE(after.cycle.resume(remembered_of(before), 10.0), Resumed::nothing);
  after.machine.model.stepper->set_temperatures(before.machine.model.stepper->temperatures_K());
  predict(network, after.machine.model);
  after.until(1);
  EXPECT_EQ(after.last.sensor_health[1].state, SensorState::failed) << "from the first cycle on";
  EXPECT_EQ(after.last.sensor_health[1].fault, SensorFault::open);
  EXPECT_EQ(after.last.sensor_quality[1], SensorQuality::withheld);
  EXPECT_EQ(after.last.sensor_quality[0], SensorQuality::good);
  EXPECT_EQ(after.last.state, State::degraded);
  after.until(1200);
  EXPECT_EQ(after.last.sensor_health[1].state, SensorState::good) << "it was mended meanwhile";
  EXPECT_EQ(after.last.state, State::running);
}

TEST(ResumedHealth, what_waits_for_an_acknowledgement_waits_for_it_after_a_restart_as_well) {
  const rom::Network network = tests::small_network();
  Watched before(network, watched(), 0.8);
  before.until(60);
  Remembered remembered = remembered_of(before);
  ASSERT_EQ(remembered.sensor_health.size(), 12U);
  remembered.sensor_health[0] = bits(SensorFault::drift);
  remembered.sensor_health[1] = remembered.sensor_health[3] = 1.0;
  Watched after(network, watched(), 0.8);
  ASSERT_NE(after.cycle.resume(remembered, 0.0), Resumed::nothing);
  after.machine.model.stepper->set_temperatures(before.machine.model.stepper->temperatures_K());
  predict(network, after.machine.model);
  after.until(1200);
  EXPECT_EQ(after.last.sensor_health[0].state, SensorState::failed);
  EXPECT_EQ(after.last.sensor_health[0].fault, SensorFault::drift);
  after.give(SensorOrder::acknowledge, 1200);
  EXPECT_EQ(after.last.sensor_health[0].state, SensorState::good);
}

/// The machine stands still while the daemon is off; somebody exchanges two plugs meanwhile, or does not.
struct OffAndOn {
  OffAndOn(double heat, int off_s, bool exchanged) : before(network, watched(), heat), after(network, watched(), heat) {
    before.until(3600);
    before.machine.operating.speed_rpm = before.machine.operating.load = 0.0;
    before.machine.advance(off_s);
    after.machine.model.stepper->set_temperatures(before.machine.model.stepper->temperatures_K());
    predict(network, after.machine.model);
    if (!exchanged) return;
    after.tamper = [](int, DeviceFrame& frame) { std::swap(frame.sensors[0].value, frame.sensors[2].value); };
  }
  rom::Network network = tests::small_network();
  Watched before, after;
};

double nose_error_m(const Watched& run) {
  return run.last.deformation_raw_m[0] - run.machine.model.outputs.deformations_m[0];
}

TEST(ResumedHealth, two_that_are_exchanged_while_the_daemon_is_off_are_found_with_their_first_reading) {
  for (const double heat : {1.0, 1.4}) {
    OffAndOn run(heat, 300, true);
    ASSERT_NE(run.after.cycle.resume(remembered_of(run.before), 300.0), Resumed::nothing);
    run.after.until(1);
    EXPECT_EQ(run.after.last.sensors_failed, 2) << heat;
    EXPECT_EQ(run.after.last.sensor_health[0].fault, SensorFault::swapped) << heat;
    EXPECT_EQ(run.after.last.sensor_health[0].partner, 2);
    while (run.after.n < 1800) {
      run.after.until(run.after.n + 10);
      EXPECT_LT(std::abs(nose_error_m(run.after)), 2.0 * run.after.last.deformation_deviation_m[0]) << heat;
      EXPECT_TRUE((run.after.last.sensor_update[0].flags & bits(Update::by_partner)) != 0) << run.after.n;
    }
  }
}

TEST(ResumedHealth, without_their_courses_or_with_those_of_half_an_hour_ago_no_first_reading_shows_an_exchange) {
  for (const bool kept : {false, true}) {
    OffAndOn run(1.4, 300, true);
    Remembered remembered = remembered_of(run.before);
    ASSERT_EQ(remembered.sensor_course.size(), 6U);
    EXPECT_LT(remembered.sensor_course[1], 2.0) << "it has just been used";
    EXPECT_LT(std::abs(remembered.sensor_course[0]), 0.1) << "and was on the model";
    if (!kept) remembered.sensor_course.clear();
    ASSERT_NE(run.after.cycle.resume(remembered, kept ? 1801.0 : 300.0), Resumed::nothing);
    run.after.until(3);
    EXPECT_EQ(run.after.last.sensors_failed, 0) << kept;
  }
}

TEST(ResumedHealth, a_course_that_no_daemon_has_written_is_not_taken) {
  for (const double used_before_s : {-1.0, -1e6, not_a_value}) {
    OffAndOn run(1.4, 300, true);
    Remembered remembered = remembered_of(run.before);
    remembered.sensor_course[1] = used_before_s;
    ASSERT_NE(run.after.cycle.resume(remembered, 300.0), Resumed::nothing);
    run.after.until(3);
    EXPECT_EQ(run.after.last.sensors_failed, 0) << used_before_s;
  }
}

TEST(ResumedHealth, how_long_a_sensor_was_away_before_the_restart_counts_too) {
  const rom::Network network = tests::small_network();
  Watched before(network, watched(), 1.0);
  before.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 600) frame.sensors[1].time_ns = at_s(599);
  };
  before.until(1000);
  const Remembered remembered = remembered_of(before);
  EXPECT_NEAR(remembered.sensor_course[3], 400.0, 10.0);
  EXPECT_LT(remembered.sensor_course[5], 2.0);
}

TEST(ResumedHealth, sensors_in_their_places_are_not_exchanged_whatever_the_daemon_has_missed) {
  for (const double heat : {0.7, 1.4}) {
    for (const int off_s : {0, 300, 1500, 20000}) {
      for (const bool went_on : {false, true}) {
        OffAndOn run(heat, off_s, false);
        const Remembered remembered = remembered_of(run.before);
        // The spindle turned meanwhile, which the daemon does not know.
        if (went_on) run.after.machine.advance(off_s);
        ASSERT_NE(run.after.cycle.resume(remembered, off_s), Resumed::nothing);
        run.after.until(600);
        EXPECT_EQ(run.after.last.sensors_failed, 0) << heat << ", " << off_s << ", " << went_on;
      }
    }
  }
}

TEST(ResumedHealth, what_no_health_has_written_changes_nothing) {
  const rom::Network network = tests::small_network();
  Watched before(network, watched(), 0.8);
  before.until(60);
  const Remembered good = remembered_of(before);
  for (const auto& [at, number] : {std::pair<std::size_t, double>{0, 10.0}, {0, -1.0}, {2, 3.0}, {3, not_a_value}}) {
    Remembered wrong = good;
    wrong.sensor_health[0] = bits(SensorFault::jump);
    wrong.sensor_health[4 + at] = number;
    Watched after(network, watched(), 0.8);
    ASSERT_NE(after.cycle.resume(wrong, 0.0), Resumed::nothing);
    after.machine.model.stepper->set_temperatures(before.machine.model.stepper->temperatures_K());
    predict(network, after.machine.model);
    after.until(5);
    EXPECT_EQ(after.last.sensors_failed, 0) << at << ": " << number;
  }
}

}  // namespace cycle_resumed_health_test
}  // namespace spindle_twin::firmware
