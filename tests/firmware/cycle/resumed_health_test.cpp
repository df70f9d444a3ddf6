#include <gtest/gtest.h>

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
