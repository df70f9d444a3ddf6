#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "firmware/config/config.hpp"
#include "firmware/keep/checkpoint.hpp"
#include "firmware/keep/history.hpp"
#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace cycle_motor_signals_test {

constexpr std::size_t current = static_cast<std::size_t>(Signal::current);
constexpr std::size_t power = static_cast<std::size_t>(Signal::power);
constexpr double rated_current_A = 16.0;  // of motor_spindle_laws.toml

std::string text_of_example() {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle_laws.toml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The hand-written motor spindle, all of whose heats are laws; of its winding copper_loss.
rom::Network by_current() { return rom::parse_by_hand(text_of_example(), "laws.toml"); }

/// The same with a motor whose losses are known by its efficiency.
rom::Network by_power() {
  std::string text = text_of_example();
  const std::size_t from = text.find("law = { kind = \"copper_loss\"");
  text.replace(from, text.find('\n', from) - from,
               "law = { kind = \"motor_efficiency\", efficiency = 0.9, rated_power_W = 2000.0 }");
  return rom::parse_by_hand(text, "laws.toml");
}

std::string config_with(const std::string& signals) {
  return R"(network = { file = "x.rom", allow_uncertified = true }
[serve]
[device]
port = 1503
[start]
temperature_degC = 20.0
[signals]
speed = { source = "constant", value = 0.0 }
load = { source = "constant", value = 1.0 }
coolant = { source = "constant", value = 20.0 }
ambient = { source = "constant", value = 20.0 }
)" + signals;
}

CyclePlan plan_with(const std::string& signals, const rom::Network& network) {
  return bind_config(parse_config(config_with(signals), "twin.toml"), network).cycle;
}

std::string error_of(const std::string& signals, const rom::Network& network) {
  return tests::refusal_of([&] { bind_config(parse_config(config_with(signals), "twin.toml"), network); });
}

struct Twin {
  Twin(const rom::Network& of, const std::string& signals)
      : network(of), cycle(network, plan_with(signals, of), runtime) {
    frame.connected = true;
  }

  const Snapshot& step() {
    last = cycle.step(frame, command, at_s(now), 0);
    ++now;
    return last;
  }

  /// What the nodes have taken up since everything was at 20 degC.
  double stored_J() const {
    Remembered remembered;
    cycle.remember(remembered);
    const auto nodes = static_cast<Eigen::Index>(remembered.nodes_K.size());
    const Eigen::VectorXd rise_K = Eigen::Map<const Eigen::VectorXd>(remembered.nodes_K.data(), nodes).array() - 293.15;
    return (network.capacity_J_per_K * rise_K).sum();
  }

  rom::Network network;
  Cycle cycle;
  DeviceFrame frame;
  PlcCommand command;
  Snapshot last;
  int now = 0;
};

/// 3 I² R₂₀ k_ac of the example's winding at 20 °C.
double copper_W(double current_A) { return 3.0 * current_A * current_A * 0.22 * 1.15; }

// At a standstill everything at the temperature of air and water, the winding's is the only heat, and in the first
// second it has warmed by a fraction of a kelvin: what is stored is what the law gives.

TEST(MotorSignals, copper_heats_by_the_measured_current_through_the_whole_cycle) {
  for (const double current_A : {4.0, 8.0, -8.0, 12.0}) {
    Twin twin(by_current(), "current = { source = \"device\", register = 4, scale = 0.01 }\n");
    twin.frame.signals[current] = {current_A, at_s(0)};
    twin.step();
    EXPECT_NEAR(twin.stored_J() / copper_W(current_A), 1.0, 1e-3) << current_A;
    EXPECT_EQ(twin.last.signals[current], current_A);
    EXPECT_EQ(twin.last.quality & bits(Quality::signal_held), 0);
    EXPECT_EQ(twin.last.state, State::running);
  }
}

TEST(MotorSignals, the_motor_loses_its_share_of_the_measured_power_when_it_drives_and_when_it_brakes) {
  for (const double power_W : {500.0, 4000.0, -4000.0}) {
    Twin twin(by_power(), "power = { source = \"device\", register = 4 }\n");
    twin.frame.signals[power] = {power_W, at_s(0)};
    twin.step();
    EXPECT_NEAR(twin.stored_J(), 0.1 * std::abs(power_W), 1e-3 * 0.1 * std::abs(power_W));
  }
}

TEST(MotorSignals, not_told_or_not_read_yet_the_heats_follow_the_load) {
  Twin untold(by_current(), "");
  untold.step();
  EXPECT_NEAR(untold.stored_J() / copper_W(rated_current_A), 1.0, 1e-3);
  EXPECT_TRUE(std::isnan(untold.last.signals[current]));
  EXPECT_EQ(untold.last.quality & bits(Quality::signal_held), 0) << "nobody promised it";
  EXPECT_EQ(untold.last.state, State::running);

  Twin unread(by_current(), "current = { source = \"plc\" }\n");
  unread.step();
  EXPECT_NEAR(unread.stored_J(), untold.stored_J(), 1e-9);
  EXPECT_NE(unread.last.quality & bits(Quality::signal_held), 0);
  EXPECT_EQ(unread.last.state, State::degraded);

  Twin first(by_current(), "current = { source = \"plc\", first = 2.0 }\n");
  first.step();
  EXPECT_NEAR(first.stored_J() / copper_W(2.0), 1.0, 1e-3);
  Twin constant(by_current(), "current = { source = \"constant\", value = 3.0 }\n");
  constant.step();
  EXPECT_NEAR(constant.stored_J() / copper_W(3.0), 1.0, 1e-3);
}

TEST(MotorSignals, what_is_out_of_range_stale_or_no_number_holds_the_last_good_value) {
  Twin twin(by_current(), "current = { source = \"device\", register = 4, stale_after_s = 2.0 }\n");
  Reading& reading = twin.frame.signals[current];
  reading = {5.0, at_s(0)};
  EXPECT_EQ(twin.step().quality & bits(Quality::signal_held), 0);
  for (const double bad :
       {10001.0, -10001.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    reading = {bad, at_s(twin.now)};
    twin.step();
    EXPECT_EQ(twin.last.signals[current], 5.0);
    EXPECT_NE(twin.last.quality & bits(Quality::signal_held), 0);
  }
  reading = {6.0, at_s(twin.now)};
  EXPECT_EQ(twin.step().quality & bits(Quality::signal_held), 0);
  for (int n = 0; n < 3; ++n) twin.step();
  EXPECT_EQ(twin.last.signals[current], 6.0);
  EXPECT_NE(twin.last.quality & bits(Quality::signal_held), 0) << "3 s old";
}

TEST(MotorSignals, the_winding_of_the_twin_follows_a_drive_that_the_load_does_not_show) {
  const rom::Network network = by_current();
  const std::string turning = "current = { source = \"device\", register = 4 }\n";
  CyclePlan told = plan_with(turning, network), untold = plan_with("", network);
  for (CyclePlan* plan : {&told, &untold}) {
    plan->signals[0].value = 6000.0;
    plan->compare_uncorrected = false;
    plan->estimator.reset();
  }
  Cycle with(network, told, runtime), without(network, untold, runtime);
  Machine machine(network, 1.0);
  machine.model.stepper->set_temperatures(Eigen::VectorXd::Constant(10, 293.15));
  machine.operating.speed_rpm = 6000.0;
  DeviceFrame frame;
  frame.connected = true;
  double worst_K = 0.0, worst_untold_K = 0.0;
  for (int n = 0; n < 1200; ++n) {
    const double current_A = 10.0 + 8.0 * std::sin(2.0 * M_PI * n / 600.0);
    frame.signals[current] = {current_A, at_s(n)};
    machine.operating.current_A = current_A;
    const double told_K = with.step(frame, {}, at_s(n), 0).predicted_K[1];
    const double untold_K = without.step(frame, {}, at_s(n), 0).predicted_K[1];
    machine.advance(1.0);
    const double truth_K = machine.model.outputs.key_points_K[1];
    worst_K = std::max(worst_K, std::abs(told_K - truth_K));
    worst_untold_K = std::max(worst_untold_K, std::abs(untold_K - truth_K));
  }
  EXPECT_LT(worst_K, 1e-9);
  EXPECT_GT(worst_untold_K, 3.0);
}

TEST(MotorSignals, device_registers_come_in_ampere_and_watt) {
  const SpindlePlan plan = bind_config(
      parse_config(config_with("current = { source = \"device\", register = 9, type = \"uint16\", scale = 0.01 }\n"),
                   "twin.toml"),
      by_current());
  ASSERT_EQ(plan.devices.at(0).channels.size(), 1U);
  EXPECT_EQ(plan.devices[0].channels[0].index, current);
  EXPECT_DOUBLE_EQ(convert(plan.devices[0].channels[0].conversion, 1250.0).value, 12.5);
}

TEST(MotorSignals, the_plc_writes_tenths_of_an_ampere_and_hundredths_of_a_kilowatt_and_reads_what_is_in_use) {
  RegisterImage image{};
  clear_commands(image);
  EXPECT_TRUE(std::isnan(get(image, Register::command_current)));
  EXPECT_TRUE(std::isnan(get(image, Register::command_power)));
  PlcSignals told;
  put(image, Register::command_current, 12.5);
  EXPECT_TRUE(take_signals({entry_of(Register::command_current).address, 1}, 77, image, told).any());
  EXPECT_NEAR(told.values[current].value, 12.5, 1e-12);
  EXPECT_EQ(told.values[current].time_ns, 77);
  EXPECT_EQ(told.values[power].time_ns, 0);
  put(image, Register::command_power, -3.21);
  EXPECT_TRUE(take_signals({entry_of(Register::command_power).address, 1}, 78, image, told).any());
  EXPECT_NEAR(told.values[power].value, -3210.0, 1e-9);

  Twin twin(by_current(), "current = { source = \"plc\" }\n");
  fill_image(twin.step(), 0, image);
  EXPECT_TRUE(std::isnan(get(image, Register::motor_current)));
  twin.command.signals = told.values;
  fill_image(twin.step(), 0, image);
  EXPECT_EQ(get(image, Register::motor_current), 12.5);
  EXPECT_TRUE(std::isnan(get(image, Register::motor_power))) << "written, but not asked for";
}

TEST(MotorSignals, a_checkpoint_keeps_them_and_through_the_gap_the_motor_is_off) {
  Twin twin(by_current(), "current = { source = \"device\", register = 4 }\n");
  twin.frame.signals[current] = {24.0, at_s(0)};
  for (int n = 0; n < 2; ++n) twin.step();
  Remembered remembered;
  twin.cycle.remember(remembered);
  const Checkpoint kept = decode_checkpoint(encode_checkpoint({std::string(64, '0'), 0.0, remembered}), "x");
  EXPECT_EQ(kept.remembered.signals[current], 24.0);
  EXPECT_TRUE(std::isnan(kept.remembered.signals[power]));
  Twin again(by_current(), "current = { source = \"device\", register = 4 }\n");
  ASSERT_EQ(again.cycle.resume(kept.remembered, 30.0), Resumed::temperatures);
  EXPECT_LE(again.stored_J(), twin.stored_J() * (1.0 + 1e-6));
}

TEST(MotorSignals, the_history_has_them_to_the_last_bit_and_empty_where_they_are_not_known) {
  Twin twin(by_current(), "current = { source = \"device\", register = 4 }\n");
  const std::string header = history_header(twin.network);
  EXPECT_TRUE(header.ends_with(",current_A,power_W")) << header;
  twin.frame.signals[current] = {1.0 / 3.0, at_s(0)};
  const std::string row = history_row(twin.step());
  EXPECT_TRUE(row.ends_with(",0.3333333333333333,")) << row;
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
}

TEST(MotorSignalsErrors, say_where_and_what_is_allowed) {
  const std::string device = "{ source = \"device\", register = 4 }\n";
  EXPECT_EQ(
      error_of("current = " + device, tests::small_network()),
      "twin.toml:12: signals.current: no heat of the network follows it; only those of the law \"copper_loss\" do");
  EXPECT_EQ(error_of("power = " + device, by_current()),
            "twin.toml:12: signals.power: no heat of the network follows it; only those of the law "
            "\"motor_efficiency\" do");
  EXPECT_EQ(error_of("current = { source = \"constant\", value = 2e4 }\n", by_current()),
            "twin.toml:12: signals.current.value: must be a number from -10000 to 10000, is 20000");
  EXPECT_EQ(error_of("power = { source = \"plc\", first = nan }\n", by_power()),
            "twin.toml:12: signals.power.first: must be a number from -1e+06 to 1e+06, is nan");
  EXPECT_EQ(error_of("current = { source = \"drive\" }\n", by_current()),
            "twin.toml:12: signals.current.source: must be one of device, plc, constant, is \"drive\"");
  EXPECT_EQ(error_of("current = { source = \"plc\", gain = 2.0 }\n", by_current()).substr(0, 39),
            "twin.toml:12: signals.current.gain: unk");
  EXPECT_EQ(error_of("current = 5.0\n", by_current()).substr(0, 30), "twin.toml:12: signals.current:");
}

}  // namespace cycle_motor_signals_test
}  // namespace spindle_twin::firmware
