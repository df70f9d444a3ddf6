#include "firmware/cycle/watch_sensors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/config/config.hpp"
#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "tests/firmware/support/watched.hpp"

namespace spindle_twin::firmware {
namespace cycle_watch_sensors_test {

TEST(WatchSensors, a_broken_wire_is_withheld_at_once_and_shown_and_the_others_go_on) {
  const rom::Network network = tests::small_network();
  Watched run(network, estimated(), 0.5);
  run.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 600) frame.sensors[1].value = 1123.15;
  };
  run.until(600);
  EXPECT_EQ(run.last.sensors_failed, 0);
  EXPECT_EQ(run.last.state, State::running);
  run.until(602);
  EXPECT_EQ(run.last.sensor_health[1].state, SensorState::failed);
  EXPECT_EQ(run.last.sensor_health[1].fault, SensorFault::open);
  EXPECT_EQ(run.last.sensors_failed, 1);
  EXPECT_NE(run.last.quality & bits(Quality::sensor_failed), 0);
  EXPECT_EQ(run.last.state, State::degraded);
  run.until(1800);
  EXPECT_EQ(run.last.sensor_quality[0], SensorQuality::good);
  EXPECT_LT(std::abs(run.last.deformation_raw_m[0] - run.machine.model.outputs.deformations_m[0]),
            2.0 * run.last.deformation_deviation_m[0]);
  EXPECT_NEAR(run.last.predicted_K[0], run.machine.model.outputs.key_points_K[0], 0.05);
}

TEST(WatchSensors, the_published_law_too_is_fed_from_healthy_sensors_only) {
  const rom::Network network = tests::small_network();
  Watched jumps(network, corrected(), 0.6);
  Watched lacks(network, corrected(), 0.6);
  jumps.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 900) frame.sensors[0].value += 4.0;
  };
  lacks.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 900) frame.sensors[0] = {not_a_value, at_s(n)};
  };
  for (int second = 900; second <= 2700; second += 60) {
    jumps.until(second);
    lacks.until(second);
    EXPECT_EQ(jumps.last.heat_factor[0], lacks.last.heat_factor[0]) << second;
  }
  EXPECT_EQ(jumps.last.sensor_health[0].fault, SensorFault::jump);
  EXPECT_EQ(jumps.last.sensor_health[0].state, SensorState::failed) << "off its old course there is no way back";
  EXPECT_EQ(jumps.last.sensor_quality[0], SensorQuality::withheld);
}

TEST(WatchSensors, a_repaired_sensor_returns_without_a_step_of_the_nose) {
  const rom::Network network = tests::small_network();
  const CyclePlan plan = estimated();
  Watched run(network, plan, 0.5);
  run.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 900 && n < 1000) frame.sensors[2].value = 31.0;
    if (n >= 1000) frame.sensors[2].value += 0.5;  // another sensor is in now
  };
  run.until(1290);
  EXPECT_EQ(run.last.sensor_health[2].state, SensorState::returning);
  double before_m = run.last.deformation_m[0];
  double most_m = 0.0;
  for (int second = 1291; second <= 2400; ++second) {
    run.until(second);
    most_m = std::max(most_m, std::abs(run.last.deformation_raw_m[0] - before_m));
    before_m = run.last.deformation_raw_m[0];
  }
  EXPECT_EQ(run.last.sensor_health[2].state, SensorState::good);
  EXPECT_LT(most_m, plan.slew_m_per_s);
  EXPECT_NEAR(run.last.sensor_update[2].offset, 0.5, 0.1) << "half a kelvin is the sensor's, not the machine's";
}

/// The twin believes that its sensors are tared to 0.02 K; one goes off by 0.5 K/h.
TEST(WatchSensors, a_sensor_off_by_what_untared_ones_may_be_has_its_offset_opened_and_fails_where_it_goes_on) {
  const rom::Network network = tests::small_network();
  for (const double most_K : {0.5, 5.0}) {
    CyclePlan plan = estimated();
    plan.estimator->offset_deviation_K = 0.02;
    for (SensorPlan& sensor : plan.sensors) sensor.offset_deviation_K = 0.02;
    Watched run(network, plan, 0.5);
    run.tamper = [&](int n, DeviceFrame& frame) {
      frame.sensors[1].value += std::clamp((n - 600) * 0.5 / 3600.0, 0.0, most_K);
    };
    run.until(100);
    run.heap_calls = 0;  // the first cycle may
    double offset_K = 0.0, most_learnt_K = 0.0;
    for (int second = 100; second <= 9000 && run.last.sensors_failed == 0; second += 10) {
      run.until(second);
      most_learnt_K = std::max(most_learnt_K, run.last.sensor_update[1].offset - offset_K);
      offset_K = run.last.sensor_update[1].offset;
    }
    const bool goes_on = most_K > 1.0;
    EXPECT_GT(most_learnt_K, 0.05) << "its offset was opened, and readings said what it is";
    EXPECT_EQ(run.last.sensor_health[1].state, goes_on ? SensorState::failed : SensorState::good);
    EXPECT_EQ(run.last.sensor_health[1].fault, goes_on ? SensorFault::drift : SensorFault::none);
    EXPECT_EQ(run.last.sensors_failed, goes_on ? 1 : 0);
    EXPECT_EQ(run.heap_calls, 0);
  }
}

/// Too fast for an untared offset, too slow for a jump: the estimate is loosened first, and would follow it.
TEST(WatchSensors, a_drift_that_a_loosened_estimate_follows_is_found_and_the_truth_stays_inside_until_then) {
  const rom::Network network = tests::small_network();
  for (const double rate_K_per_h : {5.0, -10.0}) {
    Watched run(network, estimated(), 0.5);
    run.tamper = [&](int n, DeviceFrame& frame) {
      frame.sensors[1].value += std::max(0, n - 1200) * rate_K_per_h / 3600.0;
    };
    run.until(1200);
    run.heap_calls = 0;
    int seconds = 0, inside = 0;
    for (; run.last.sensors_failed == 0 && run.n < 9000; ++seconds) {
      run.until(run.n + 1);
      const double error_m = run.last.deformation_raw_m[0] - run.machine.model.outputs.deformations_m[0];
      inside += std::abs(error_m) <= 2.0 * run.last.deformation_deviation_m[0] ? 1 : 0;
    }
    EXPECT_EQ(run.last.sensor_health[1].fault, SensorFault::drift) << rate_K_per_h;
    EXPECT_EQ(run.last.sensors_failed, 1);
    EXPECT_GE(inside, 0.93 * seconds) << rate_K_per_h << " K/h, found after " << seconds << " s";
    EXPECT_EQ(run.heap_calls, 0);
    run.until(run.n + 900);
    EXPECT_LT(std::abs(run.last.deformation_raw_m[0] - run.machine.model.outputs.deformations_m[0]),
              2.0 * run.last.deformation_deviation_m[0]);
    EXPECT_EQ(run.last.sensors_failed, 1);
  }
}

TEST(WatchSensors, no_order_calls_the_heap_not_even_the_first_tare) {
  const rom::Network network = tests::small_network();
  Watched run(network, at_rest(estimated()), 0.0);
  run.until(1000);
  ASSERT_NE(run.last.quality & bits(Quality::sensor_tare_offered), 0);
  run.heap_calls = 0;
  for (const SensorOrder order : {SensorOrder::tare, SensorOrder::tare, SensorOrder::acknowledge}) {
    run.give(order, 20);
  }
  EXPECT_EQ(run.last.sensor_tare_count, 2);
  EXPECT_EQ(run.heap_calls, 0);
}

TEST(WatchSensors, switched_off_only_range_and_age_count) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.health.reset();
  Watched run(network, plan, 0.5);
  run.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 100) frame.sensors[0].value += 4.0;
  };
  run.until(200);
  EXPECT_EQ(run.last.sensor_quality[0], SensorQuality::good);
  EXPECT_EQ(run.last.sensors_failed, 0);
  RegisterImage image{};
  fill_image(run.last, run.last.time_ns, image);
  EXPECT_TRUE(std::isnan(get(image, Register::sensor_state)));
}

TEST(WatchSensors, registers_show_state_fault_and_tare_and_take_the_orders) {
  const rom::Network network = tests::small_network();
  Watched run(network, estimated(), 0.5);
  run.tamper = [](int n, DeviceFrame& frame) {
    if (n >= 300) frame.sensors[1].value = 31.0;
  };
  run.until(310);
  RegisterImage image{};
  fill_image(run.last, run.last.time_ns, image);
  EXPECT_EQ(get(image, Register::sensor_state, 1), 2.0);
  EXPECT_EQ(get(image, Register::sensor_fault, 1), 2.0);
  EXPECT_EQ(get(image, Register::sensor_state, 0), 0.0);
  EXPECT_TRUE(std::isnan(get(image, Register::sensor_state, 5)));
  EXPECT_TRUE(std::isnan(get(image, Register::sensor_partner, 1)));
  EXPECT_TRUE(std::isfinite(get(image, Register::sensor_misfit, 0)));
  EXPECT_EQ(get(image, Register::sensor_tare, 0), 0.0);
  EXPECT_EQ(get(image, Register::sensors_failed), 1.0);
  EXPECT_EQ(get(image, Register::model_in_doubt), 0.0);

  OrderDesk desk;
  PlcCommand command;
  Snapshot snapshot;
  const WriteRange written{entry_of(Register::command_sensors).address, 1};
  for (const auto& [number, order] :
       {std::pair{1.0, SensorOrder::tare}, {2.0, SensorOrder::clear_tare}, {3.0, SensorOrder::acknowledge}}) {
    const std::uint32_t before = command.sensor_orders;
    put(image, Register::command_sensors, number);
    for (const Order& taken : take_orders(written, {}, image)) desk.give(taken);
    desk.hand_out(command);
    OrderResults done{};
    done.fill(OrderResult::done);
    desk.settle(done, {}, snapshot);
    EXPECT_EQ(command.sensor_orders, before + 1);
    EXPECT_EQ(command.sensor_order, order);
    EXPECT_EQ(get(image, Register::command_sensors), 0.0);
  }
}

constexpr const char* small_config = R"(network = "x.rom"
[serve]
[signals]
speed = { source = "plc" }
load = { source = "plc" }
coolant = { source = "constant", value = 20.0 }
ambient = { source = "constant", value = 20.0 }
[start]
temperature_degC = 20.0
)";

TEST(HealthConfig, limits_and_tare_are_read_and_off_is_off) {
  const Config defaults = parse_config(small_config, "x.toml");
  ASSERT_TRUE(defaults.cycle.health.has_value());
  EXPECT_EQ(defaults.cycle.health->jump_K, correction::HealthLimits{}.jump_K);
  const Config set = parse_config(std::string(small_config) +
                                      "[health]\njump_K = 0.7\nopen_above_degC = 500.0\nspikes = 2\n"
                                      "[health.tare]\nrest_s = 3600.0\nreference = \"ambient\"\n",
                                  "x.toml");
  EXPECT_EQ(set.cycle.health->jump_K, 0.7);
  EXPECT_NEAR(set.cycle.health->open_above_K, 773.15, 1e-9);
  EXPECT_EQ(set.cycle.health->spikes, 2);
  EXPECT_EQ(set.cycle.tare.rest_s, 3600.0);
  EXPECT_TRUE(set.cycle.tare_to_ambient);
  EXPECT_FALSE(
      parse_config(std::string(small_config) + "[health]\nenabled = false\n", "x.toml").cycle.health.has_value());
}

TEST(HealthConfig, a_limit_out_of_range_is_refused_with_its_line) {
  try {
    parse_config(std::string(small_config) + "[health]\njump_K = -1.0\n", "x.toml");
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("x.toml:11"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("health.jump_K"), std::string::npos) << error.what();
  }
}

}  // namespace cycle_watch_sensors_test
}  // namespace spindle_twin::firmware
