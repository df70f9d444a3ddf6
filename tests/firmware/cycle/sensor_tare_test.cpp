#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "firmware/keep/checkpoint.hpp"
#include "tests/firmware/support/watched.hpp"

/// Offsets of the sensors that the machine takes of itself at rest.
namespace spindle_twin::firmware {
namespace cycle_sensor_tare_test {

TEST(SensorTare, it_is_offered_at_rest_and_takes_the_offsets_away_without_a_step) {
  const rom::Network network = tests::small_network();
  const CyclePlan plan = at_rest(untared());
  Watched run(network, plan, 0.0);
  run.offset_K = {0.15, -0.2, 0.05};
  run.until(800);
  EXPECT_EQ(run.last.quality & bits(Quality::sensor_tare_offered), 0);
  run.until(1000);
  EXPECT_NE(run.last.quality & bits(Quality::sensor_tare_offered), 0);
  EXPECT_EQ(run.last.state, State::running) << "an offer is no trouble";
  const double before_m = run.last.deformation_raw_m[0];
  run.command.sensor_order = SensorOrder::tare;
  run.command.sensor_orders = 1;
  run.until(1002);
  EXPECT_EQ(run.last.sensor_tare_count, 1);
  EXPECT_NEAR(run.last.deformation_raw_m[0], before_m, 2e-7);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(run.last.sensor_tare_K[k], run.offset_K[k], 0.02);
    EXPECT_NEAR(run.last.measured_K[k], start_K, 0.15);
  }
  run.until(1100);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(run.last.sensor_update[k].offset, 0.0, 0.03);
    EXPECT_LT(run.last.sensor_update[k].offset_deviation, 0.03);
    EXPECT_EQ(run.last.sensor_health[k].state, SensorState::good) << "its readings have moved, but by our own hand";
  }

  Remembered remembered;
  run.cycle.remember(remembered);
  const Checkpoint kept = decode_checkpoint(encode_checkpoint({std::string(64, '0'), 0.0, remembered}), "x");
  EXPECT_EQ(kept.remembered.sensor_tare.count, 1U);
  Watched resumed(network, plan, 0.0);
  resumed.offset_K = run.offset_K;
  ASSERT_EQ(resumed.cycle.resume(kept.remembered, 10.0), Resumed::temperatures_and_estimator);
  resumed.until(30);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(resumed.last.sensor_tare_K[k], run.last.sensor_tare_K[k]);
  EXPECT_EQ(resumed.last.sensors_failed, 0);
  remembered.sensor_tare.offset_K[0] = not_a_value;
  Watched untared(network, plan, 0.0);
  ASSERT_NE(untared.cycle.resume(remembered, 10.0), Resumed::nothing);
  untared.until(30);
  EXPECT_EQ(untared.last.sensor_tare_K[0], 0.0);
  EXPECT_TRUE(std::isfinite(untared.last.measured_K[0]));

  run.command.sensor_order = SensorOrder::clear_tare;
  run.command.sensor_orders = 2;
  run.until(1102);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(run.last.sensor_tare_K[k], 0.0);
  run.until(1130);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_GT(run.last.sensor_update[k].offset_deviation, 0.005) << "no tare, no certainty";
  }
}

TEST(SensorTare, an_order_to_tare_counts_for_the_readings_of_its_own_cycle) {
  const rom::Network network = tests::small_network();
  const CyclePlan plan = at_rest(untared());
  Watched run(network, plan, 0.0);
  run.offset_K = {0.15, -0.2, 0.05};
  run.noise_K = 0.0;
  run.until(1003);
  for (const SensorOrder order : {SensorOrder::tare, SensorOrder::clear_tare}) {
    run.give(order, 1);
    EXPECT_EQ(run.last.sensor_tare_count, run.command.sensor_orders);
    const std::uint32_t updates = run.last.updates;
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(run.last.measured_K[k], run.last.raw_K[k] - run.last.sensor_tare_K[k]);
    }
    while (run.last.updates == updates) run.until(run.n + 1);
    // Nothing has moved, so that one reading with the other tare would be all that the update sees.
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(run.last.sensor_update[k].observation, run.last.measured_K[k], 1e-9);
      EXPECT_NEAR(run.last.sensor_update[k].innovation, 0.0, 1e-3);
    }
  }
}

TEST(SensorTare, one_larger_than_any_jump_fails_no_sensor) {
  const rom::Network network = tests::small_network();
  const CyclePlan plan = at_rest(untared());
  Watched run(network, plan, 0.0);
  run.offset_K = {0.6, -0.05, 0.0};
  run.until(1000);
  for (const SensorOrder order : {SensorOrder::tare, SensorOrder::clear_tare}) {
    run.give(order, 20);
    EXPECT_EQ(run.last.sensor_tare_count, run.command.sensor_orders);
    EXPECT_EQ(std::abs(run.last.sensor_tare_K[0]) > plan.health->jump_K, order == SensorOrder::tare);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(run.last.sensor_health[k].state, SensorState::good) << k;
      EXPECT_EQ(run.last.sensor_health[k].spikes, 0) << k;
      EXPECT_EQ(run.last.sensor_quality[k], SensorQuality::good) << k;
    }
    EXPECT_FALSE(run.last.model_in_doubt);
  }
}

/// Off, the model runs by itself: a tare changes what is shown of the readings, and the estimator once it corrects.
TEST(SensorTare, taken_while_the_law_stands_by_counts_from_its_first_update_on) {
  const rom::Network network = tests::small_network();
  const CyclePlan plan = at_rest(untared());
  Watched tared(network, plan, 0.0), other(network, plan, 0.0);
  for (Watched* run : {&tared, &other}) {
    run->offset_K = {0.15, -0.2, 0.05};
    run->command.correction = SwitchOrder::off;
    run->until(1000);
  }
  ASSERT_NE(tared.last.quality & bits(Quality::sensor_tare_offered), 0);
  tared.give(SensorOrder::tare, 60);
  other.until(1060);
  EXPECT_EQ(tared.last.sensor_tare_count, 1);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(tared.last.predicted_K[k], other.last.predicted_K[k]) << "it moves no prediction";
    EXPECT_NEAR(tared.last.sensor_tare_K[k], tared.offset_K[k], 0.02);
    EXPECT_NEAR(tared.last.measured_K[k], other.last.measured_K[k] - tared.last.sensor_tare_K[k], 1e-9);
  }
  for (Watched* run : {&tared, &other}) {
    run->command.correction = SwitchOrder::on;
    run->until(1090);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(tared.last.sensor_update[k].offset, 0.0, 0.03);
    EXPECT_LT(tared.last.sensor_update[k].offset_deviation, 0.03);
    EXPECT_GT(other.last.sensor_update[k].offset_deviation, 0.05) << "without one it is open";
  }
  EXPECT_LT(tared.last.deformation_deviation_m[0], other.last.deformation_deviation_m[0]);
  EXPECT_NEAR(tared.last.deformation_raw_m[0], 0.0, 2.0 * tared.last.deformation_deviation_m[0]);
}

/// The estimator has not taken it in yet when it begins to stand by.
TEST(SensorTare, taken_in_the_cycle_that_switches_off_is_not_lost) {
  const rom::Network network = tests::small_network();
  Watched run(network, at_rest(untared()), 0.0);
  run.offset_K = {0.15, -0.2, 0.05};
  run.until(1000);
  run.command.correction = SwitchOrder::off;
  run.give(SensorOrder::tare, 60);
  EXPECT_EQ(run.last.sensor_tare_count, 1);
  run.command.correction = SwitchOrder::on;
  run.until(1090);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(run.last.sensor_update[k].offset, 0.0, 0.03);
    EXPECT_LT(run.last.sensor_update[k].offset_deviation, 0.03);
  }
}

TEST(SensorTare, the_published_law_reads_less_by_it_also_when_it_stood_by) {
  const rom::Network network = tests::small_network();
  Watched run(network, at_rest(corrected()), 0.0);
  run.offset_K = {0.15, -0.2, 0.05};
  run.command.correction = SwitchOrder::off;
  run.until(1000);
  run.give(SensorOrder::tare, 10);
  EXPECT_EQ(run.last.sensor_tare_count, 1);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(run.last.sensor_tare_K[k], run.offset_K[k], 0.02);
  run.command.correction = SwitchOrder::on;
  run.until(1200);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(run.last.measured_K[k], start_K, 0.15);
  for (std::size_t i = 0; i < network.boundaries.sources.size(); ++i) EXPECT_EQ(run.last.heat_factor[i], 1.0);
}

/// Orders of a run before, told to a cycle that has resumed: what they say of the tare beside the checkpoint's.
TEST(SensorTare, of_standing_orders_the_estimator_is_told_where_they_say_another) {
  const rom::Network network = tests::small_network();
  const CyclePlan plan = at_rest(untared());
  Watched before(network, plan, 0.0);
  before.offset_K = {0.15, -0.2, 0.05};
  before.until(1000);
  before.give(SensorOrder::tare, 60);
  Remembered remembered;
  before.cycle.remember(remembered);
  const StandingOrders kept = before.cycle.standing_orders();
  const auto offset_after = [&](const StandingOrders* orders) {
    Watched run(network, plan, 0.0);
    run.offset_K = before.offset_K;
    EXPECT_EQ(run.cycle.resume(remembered, 10.0), Resumed::temperatures_and_estimator);
    if (orders != nullptr) run.cycle.stand_by_orders(*orders);
    run.until(1);
    return run.last.sensor_update[0];
  };
  const auto as_kept = offset_after(nullptr);
  EXPECT_EQ(offset_after(&kept).offset, as_kept.offset) << "the same tare is none";
  StandingOrders moved = kept;
  moved.sensor_tare_K[0] += 0.1;
  EXPECT_LT(offset_after(&moved).offset, as_kept.offset - 0.05);
  StandingOrders surer = kept;
  surer.sensor_tare_deviation_K[0] = 1e-4;
  EXPECT_NE(offset_after(&surer).offset_deviation, as_kept.offset_deviation);
}

}  // namespace cycle_sensor_tare_test
}  // namespace spindle_twin::firmware
