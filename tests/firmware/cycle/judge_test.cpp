#include "firmware/cycle/judge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
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
    EXPECT_FALSE(inputs.sensed.signals[1].silent) << "it was never heard";
    inputs.command.alive_ns[1] = 100 * second_ns;
    inputs.at(100.0 + 0.9 * timeout_s);
    EXPECT_FALSE(inputs.sensed.signals[1].silent);
    inputs.at(100.0 + 1.1 * timeout_s);
    EXPECT_TRUE(inputs.sensed.signals[1].silent);
    inputs.plan.plc_timeout_s = 0.0;
    inputs.at(100.0 + 1.1 * timeout_s);
    EXPECT_FALSE(inputs.sensed.signals[1].silent);
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

/// Each limit belongs to what it bounds.
TEST(Judge, a_sensor_at_the_ends_of_its_range_and_of_its_time_is_good_and_beyond_it_is_not) {
  CyclePlan plan;
  plan.sensors[2] = {.configured = true, .min_K = 250.0, .max_K = 400.0, .stale_after_s = 4.0};
  Judgement judgement = first_judgement(plan);
  SensedInputs sensed;
  const auto judged = [&](double value_K, double age_s) {
    sensed.sensors[2] = {value_K, age_s, second_ns};
    judge(plan, sensed, judgement);
    EXPECT_EQ(judgement.configured, 1U);
    EXPECT_EQ(judgement.good, judgement.sensors[2] == SensorQuality::good ? 1U : 0U);
    return judgement.sensors[2];
  };
  for (const double value_K : {250.0, 400.0}) {
    EXPECT_EQ(judged(value_K, 4.0), SensorQuality::good);
    EXPECT_EQ(judgement.data_age_s, 4.0);
    EXPECT_EQ(judged(value_K, 4.001), SensorQuality::stale);
    EXPECT_TRUE(std::isnan(judgement.data_age_s));
  }
  EXPECT_EQ(judged(249.999, 0.0), SensorQuality::out_of_range);
  EXPECT_EQ(judgement.quality & bits(Quality::sensor_out_of_range), bits(Quality::sensor_out_of_range));
  EXPECT_EQ(judged(400.001, 0.0), SensorQuality::out_of_range);
}

TEST(Judge, the_data_are_as_old_as_the_oldest_good_reading_whichever_it_is) {
  CyclePlan plan;
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}, slots::key_points - 1}) plan.sensors[k].configured = true;
  plan.sensors[1].stale_after_s = 5.0;
  Judgement judgement = first_judgement(plan);
  SensedInputs sensed;
  sensed.device_connected = true;
  for (int turn = 0; turn < 3; ++turn) {
    sensed.sensors[0] = {300.0, turn == 0 ? 2.5 : 1.0, 1};
    sensed.sensors[1] = {300.0, 7.0, 1};
    sensed.sensors[slots::key_points - 1] = {300.0, turn == 1 ? 2.75 : 0.5, 1};
    judge(plan, sensed, judgement);
    EXPECT_EQ(judgement.data_age_s, turn == 0 ? 2.5 : turn == 1 ? 2.75 : 1.0);
    EXPECT_EQ(judgement.configured, 3U);
    EXPECT_EQ(judgement.good, 2U);
    EXPECT_EQ(judgement.quality, bits(Quality::sensor_stale));
  }
}

/// One signal, told by hand.
struct OneSignal {
  explicit OneSignal(const SignalPlan& of, std::size_t signal = 0) : s(signal) {
    plan.signals[s] = of;
    judgement = first_judgement(plan);
  }
  bool believes(double value, double age_s, std::int64_t time_ns) {
    sensed.signals[s] = {value, age_s, time_ns, is_silent};
    judge(plan, sensed, judgement);
    const bool held = (judgement.quality & bits(Quality::signal_held)) != 0;
    EXPECT_EQ(judgement.signals_held, held ? 1U << s : 0U);
    return !held;
  }
  std::size_t s;
  bool is_silent = false;  ///< who tells it
  CyclePlan plan;
  SensedInputs sensed;
  Judgement judgement;
};

TEST(Judge, a_signal_at_the_ends_of_its_range_and_of_its_time_is_believed_and_beyond_it_is_not) {
  for (const std::size_t s : {std::size_t{0}, signal_count - 1}) {
    OneSignal signal({SignalSource::plc, 1.0, -2.0, 3.0, 0.5}, s);
    for (const double value : {-2.0, 3.0}) {
      EXPECT_TRUE(signal.believes(value, 0.5, 1));
      EXPECT_EQ(signal.judgement.signals[s], value);
    }
    EXPECT_FALSE(signal.believes(0.0, 0.501, 1)) << "stale";
    EXPECT_EQ(signal.judgement.signals_implausible, 0U);
    for (const double value : {-2.001, 3.001}) {
      EXPECT_FALSE(signal.believes(value, 0.0, 1));
      EXPECT_EQ(signal.judgement.signals_implausible, 1U << s);
      EXPECT_EQ(signal.judgement.signals[s], 3.0);
    }
  }
}

TEST(Judge, a_change_is_believed_from_the_time_on_in_which_it_could_come_so_fast) {
  for (const double clock_rate : {1.0, 4.0}) {
    OneSignal signal({SignalSource::device, clock_rate > 1.0 ? 900.0 : not_a_value, 0.0, 1000.0, 0.0, 2.0});
    signal.plan.clock_rate = clock_rate;
    const auto in_ns = [&](double model_s) { return 1 + static_cast<std::int64_t>(model_s / clock_rate * 1e9); };
    EXPECT_TRUE(signal.believes(300.0, 0.0, 1)) << "the first of all is as good as any";
    EXPECT_FALSE(signal.believes(316.0, 0.0, in_ns(7.5)));
    EXPECT_TRUE(signal.believes(316.0, 0.0, in_ns(8.0)));
    EXPECT_FALSE(signal.believes(308.0, 0.0, in_ns(11.5)));
    EXPECT_TRUE(signal.believes(308.0, 0.0, in_ns(12.0)));
    EXPECT_TRUE(signal.believes(308.0, 0.0, in_ns(12.0))) << "a repeat";
    EXPECT_FALSE(signal.believes(308.5, 0.0, in_ns(12.0)));
    EXPECT_TRUE(signal.believes(308.0, 0.0, in_ns(11.0))) << "no change is never too fast";
  }
}

TEST(Judge, a_change_told_once_too_early_is_believed_when_its_time_has_passed) {
  for (const double clock_rate : {1.0, 4.0}) {
    OneSignal signal({SignalSource::plc, not_a_value, 0.0, 1000.0, 0.0, 2.0});
    signal.plan.clock_rate = clock_rate;
    EXPECT_TRUE(signal.believes(300.0, 0.0, 1'000'000'000));
    const auto a_tenth_later = 1'000'000'000 + static_cast<std::int64_t>(1e8 / clock_rate);
    EXPECT_FALSE(signal.believes(304.0, 0.0, a_tenth_later));
    EXPECT_FALSE(signal.believes(304.0, 1.8, a_tenth_later)) << "as old in model time as it must become";
    EXPECT_TRUE(signal.believes(304.0, 1.95, a_tenth_later));
  }
}

TEST(Judge, what_a_silent_client_told_is_held_until_it_is_heard_again) {
  OneSignal signal({SignalSource::plc, 1.0, 0.0, 9.0, 0.0});
  signal.is_silent = true;
  EXPECT_FALSE(signal.believes(5.0, 0.0, 1));
  EXPECT_EQ(signal.judgement.signals_implausible, 0U);
  signal.is_silent = false;
  EXPECT_TRUE(signal.believes(6.0, 1e9, 1)) << "without a time it never grows stale";
}

TEST(Sense, silence_is_of_each_signal_and_of_those_that_a_plc_tells_only) {
  Inputs inputs;
  inputs.plan.plc_timeout_s = 2.0;
  inputs.command.alive_ns.fill(100 * second_ns);
  inputs.at(103.0);
  EXPECT_TRUE(inputs.sensed.signals[1].silent);
  EXPECT_FALSE(inputs.sensed.signals[0].silent) << "a device's";
  EXPECT_FALSE(inputs.sensed.signals[2].silent) << "a constant";
  inputs.plan.signals[0] = inputs.plan.signals[1];
  inputs.command.alive_ns[0] = 102 * second_ns;
  inputs.at(103.0);
  EXPECT_FALSE(inputs.sensed.signals[0].silent) << "another client's, which talks";
  EXPECT_TRUE(inputs.sensed.signals[1].silent);
}
TEST(Judge, a_device_is_missed_where_a_sensor_or_a_signal_comes_from_one) {
  for (const bool sensor : {false, true}) {
    for (const SignalSource source :
         {SignalSource::none, SignalSource::constant, SignalSource::device, SignalSource::plc}) {
      OneSignal signal({source, 1.0, 0.0, 9.0, 0.0});
      signal.plan.sensors[0].configured = sensor;
      for (const bool connected : {false, true}) {
        signal.sensed.device_connected = connected;
        signal.believes(5.0, 0.0, 1);
        const bool missed = !connected && (sensor || source == SignalSource::device);
        EXPECT_EQ((signal.judgement.quality & bits(Quality::device_offline)) != 0, missed);
      }
    }
  }
}

TEST(Sense, ages_count_from_the_reading_in_model_time_and_none_is_below_zero) {
  CyclePlan plan;
  plan.clock_rate = 4.0;
  plan.signals[1].source = SignalSource::plc;
  plan.signals[2].source = SignalSource::device;
  plan.signals[3] = {SignalSource::constant, 5.0};
  DeviceFrame frame;
  PlcCommand command;
  SensedInputs sensed;
  constexpr std::size_t last = slots::key_points - 1;
  frame.sensors[last] = {300.0, 10 * second_ns};
  frame.displacements[1] = {1e-6, 1};
  frame.signals[2] = {2.0, 12 * second_ns};
  command.signals[1] = {3.0, 13 * second_ns};
  sense(plan, frame, command, 12 * second_ns, sensed);
  EXPECT_EQ(sensed.sensors[last].age_s, 8.0);
  EXPECT_EQ(sensed.sensors[last].value, 300.0);
  EXPECT_EQ(sensed.sensors[last].time_ns, 10 * second_ns);
  EXPECT_TRUE(std::isinf(sensed.sensors[0].age_s));
  EXPECT_NEAR(sensed.displacements[1].age_s, 48.0, 1e-7) << "read at the clock's first nanosecond";
  EXPECT_EQ(sensed.signals[1].age_s, 0.0) << "it came in meanwhile";
  EXPECT_EQ(sensed.signals[2].age_s, 0.0);
  EXPECT_EQ(sensed.signals[3].age_s, 0.0);
  EXPECT_EQ(sensed.signals[3].value, 5.0);
}

TEST(Sense, a_plc_is_silent_beyond_its_time_by_the_clock_and_not_at_it) {
  for (const double clock_rate : {1.0, 60.0}) {
    CyclePlan plan;
    plan.clock_rate = clock_rate;
    PlcCommand command;
    SensedInputs sensed;
    const auto is_silent = [&](double timeout_s, std::int64_t alive_ns, std::int64_t now_ns) {
      plan.plc_timeout_s = timeout_s;
      command.alive_ns.fill(alive_ns);
      plan.signals[0].source = SignalSource::plc;
      sense(plan, {}, command, now_ns, sensed);
      return sensed.signals[0].silent;
    };
    EXPECT_FALSE(is_silent(2.0, second_ns, 3 * second_ns));
    EXPECT_TRUE(is_silent(2.0, second_ns, 3 * second_ns + 1000));
    EXPECT_TRUE(is_silent(2.0, 1, 3 * second_ns)) << "heard in the clock's first nanosecond";
    EXPECT_FALSE(is_silent(0.0, second_ns, 3 * second_ns));
  }
}

}  // namespace cycle_judge_test
}  // namespace spindle_twin::firmware
