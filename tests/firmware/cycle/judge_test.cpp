#include "firmware/cycle/judge.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace spindle_twin::firmware {
namespace cycle_judge_test {

constexpr std::int64_t second_ns = 1'000'000'000;

struct Inputs {
  CyclePlan plan;
  DeviceFrame frame;
  PlcCommand command;
  SensedInputs sensed;
  Judgement judgement;

  Inputs() {
    plan.sensors[0].configured = true;
    plan.signals[0] = {SignalSource::device, 1000.0, 0.0, 30000.0, 3.0};
    plan.signals[1] = {SignalSource::plc, 0.5, 0.0, 2.0, 0.0};
    plan.signals[2] = {SignalSource::constant, 300.0, 200.0, 400.0, 0.0};
    plan.signals[3] = {SignalSource::constant, 300.0, 200.0, 400.0, 0.0};
    judgement = first_judgement(plan);
    frame.connected = true;
    frame.sensors[0] = {300.0, 10 * second_ns};
    frame.signals[0] = {6000.0, 10 * second_ns};
    command.signals[1] = {0.75, 10 * second_ns};
  }

  void at(double time_s) {
    sense(plan, frame, command, static_cast<std::int64_t>(time_s * 1e9), sensed);
    judge(plan, sensed, judgement);
  }
};

TEST(Sense, a_plc_is_silent_after_its_time_of_any_length_and_without_one_never) {
  for (const double timeout_s : {0.5, 10.0}) {
    Inputs inputs;
    inputs.plan.plc_timeout_s = timeout_s;
    inputs.at(100.0);
    EXPECT_FALSE(inputs.sensed.plc_silent) << "it was never heard";
    inputs.command.alive_ns = 100 * second_ns;
    inputs.at(100.0 + 0.9 * timeout_s);
    EXPECT_FALSE(inputs.sensed.plc_silent);
    inputs.at(100.0 + 1.1 * timeout_s);
    EXPECT_TRUE(inputs.sensed.plc_silent);
    inputs.plan.plc_timeout_s = 0.0;
    inputs.at(100.0 + 1.1 * timeout_s);
    EXPECT_FALSE(inputs.sensed.plc_silent);
  }
}

TEST(Judge, fresh_readings_are_good_and_used) {
  Inputs inputs;
  inputs.at(11.5);
  EXPECT_EQ(inputs.judgement.sensors[0], SensorQuality::good);
  EXPECT_EQ(inputs.judgement.sensors[1], SensorQuality::not_configured);
  EXPECT_EQ(inputs.judgement.quality, 0);
  EXPECT_DOUBLE_EQ(inputs.judgement.data_age_s, 1.5);
  EXPECT_DOUBLE_EQ(inputs.judgement.signals[0], 6000.0);
  EXPECT_DOUBLE_EQ(inputs.judgement.signals[1], 0.75);
}

TEST(Judge, age_counts_in_model_time) {
  Inputs inputs;
  inputs.plan.clock_rate = 60.0;
  inputs.at(10.04);
  EXPECT_EQ(inputs.judgement.sensors[0], SensorQuality::good);
  inputs.at(10.06);
  EXPECT_EQ(inputs.judgement.sensors[0], SensorQuality::stale);
  EXPECT_EQ(inputs.judgement.quality & bits(Quality::sensor_stale), bits(Quality::sensor_stale));
}

TEST(Judge, each_fault_of_a_sensor_has_its_own_quality) {
  Inputs inputs;
  inputs.frame.sensors[0].value = std::numeric_limits<double>::quiet_NaN();
  inputs.at(10.0);
  EXPECT_EQ(inputs.judgement.sensors[0], SensorQuality::not_finite);
  inputs.frame.sensors[0].value = 500.0;
  inputs.at(10.0);
  EXPECT_EQ(inputs.judgement.sensors[0], SensorQuality::out_of_range);
  inputs.frame.sensors[0].value = 100.0;
  inputs.at(10.0);
  EXPECT_EQ(inputs.judgement.sensors[0], SensorQuality::out_of_range);
  inputs.frame.sensors[0] = {};
  inputs.at(10.0);
  EXPECT_EQ(inputs.judgement.sensors[0], SensorQuality::never_read);
  EXPECT_EQ(inputs.judgement.quality, bits(Quality::sensor_missing));
  EXPECT_EQ(inputs.judgement.good, 0U);
}

TEST(Judge, a_signal_out_of_range_or_stale_holds_its_last_good_value) {
  Inputs inputs;
  inputs.at(10.0);
  inputs.frame.signals[0].value = 99000.0;
  inputs.at(11.0);
  EXPECT_DOUBLE_EQ(inputs.judgement.signals[0], 6000.0);
  EXPECT_EQ(inputs.judgement.quality, bits(Quality::signal_held));
  inputs.frame.signals[0].value = 7000.0;
  inputs.at(14.0);
  EXPECT_DOUBLE_EQ(inputs.judgement.signals[0], 6000.0);
}

TEST(Judge, a_signal_never_read_takes_its_first_value) {
  Inputs inputs;
  inputs.frame.signals[0] = {};
  inputs.at(10.0);
  EXPECT_DOUBLE_EQ(inputs.judgement.signals[0], 1000.0);
  EXPECT_EQ(inputs.judgement.quality, bits(Quality::signal_held));
}

TEST(Judge, a_plc_signal_without_staleness_limit_never_grows_stale) {
  Inputs inputs;
  inputs.frame.signals[0].time_ns = inputs.frame.sensors[0].time_ns = 100000 * second_ns;
  inputs.at(100000.0);
  EXPECT_DOUBLE_EQ(inputs.judgement.signals[1], 0.75);
  EXPECT_EQ(inputs.judgement.quality, 0);
}

TEST(Judge, each_signal_goes_to_its_own_environment_circuit_and_heat) {
  rom::Network network;
  network.boundaries.environments = {{"room", rom::EnvironmentKind::ambient},
                                     {"jacket", rom::EnvironmentKind::coolant}};
  Judgement judgement;
  for (std::size_t s = 0; s < signal_count; ++s) judgement.signals[s] = 100.0 + static_cast<double>(s);
  rom::OperatingState operating;
  operating.environment_K.setZero(2);
  operating.flow_kg_per_s.setZero(slots::circuits);
  operating.heat_W.setZero(slots::heats);
  set_operating(network, judgement, operating);
  const auto told = [](auto signal) { return 100.0 + static_cast<double>(signal); };
  EXPECT_EQ(operating.speed_rpm, told(Signal::speed));
  EXPECT_EQ(operating.load, told(Signal::load));
  EXPECT_EQ(operating.environment_K, Eigen::Vector2d(told(Signal::ambient), told(Signal::coolant)));
  for (Eigen::Index c = 0; c < static_cast<Eigen::Index>(slots::circuits); ++c) {
    EXPECT_EQ(operating.flow_kg_per_s[c], told(static_cast<Eigen::Index>(first_flow_signal) + c)) << c;
  }
  for (Eigen::Index h = 0; h < static_cast<Eigen::Index>(slots::heats); ++h) {
    EXPECT_EQ(operating.heat_W[h], told(static_cast<Eigen::Index>(first_heat_signal) + h)) << h;
  }
  EXPECT_EQ(operating.current_A, told(Signal::current));
  EXPECT_EQ(operating.power_W, told(Signal::power));
  put_signal(network.boundaries, static_cast<std::size_t>(Signal::power), not_a_value, operating);
  EXPECT_FALSE(operating.power_W);
  EXPECT_EQ(operating.current_A, told(Signal::current));
}

TEST(Judge, a_flow_or_heat_that_the_network_does_not_have_changes_nothing) {
  rom::OperatingState operating;
  operating.flow_kg_per_s.setZero(1);
  operating.heat_W.setZero(1);
  for (std::size_t s = first_flow_signal; s < signal_count; ++s) {
    if (s != first_flow_signal && s != first_heat_signal) put_signal(rom::Boundaries{}, s, 7.0, operating);
  }
  EXPECT_EQ(operating.flow_kg_per_s[0], 0.0);
  EXPECT_EQ(operating.heat_W[0], 0.0);
}

TEST(Judge, a_lost_device_shows_at_once) {
  Inputs inputs;
  inputs.frame.connected = false;
  inputs.at(10.0);
  EXPECT_EQ(inputs.judgement.quality, bits(Quality::device_offline));
}

}  // namespace cycle_judge_test
}  // namespace spindle_twin::firmware
