#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "firmware/config/config.hpp"
#include "firmware/config/expect_of_sensors.hpp"
#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/history.hpp"
#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace cycle_measured_heat_test {

/// A winding of 6 W/K to a housing of 5 W/K to the room, 0.8 of the measured loss in the winding; no deformation, no
/// coolant.
rom::Network two_node() { return rom::read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/two_node.toml"); }

const std::string ambient = "ambient = { source = \"constant\", value = 20.0 }\n";

std::string config_with(const std::string& signals, const std::string& start = "temperature_degC = 20.0") {
  return R"(network = { file = "two_node.rom", allow_uncertified = true }
[serve]
[device]
port = 1503
[start]
)" + start +
         R"(
[cycle]
period_s = 10.0
[signals]
speed = { source = "constant", value = 0.0 }
load = { source = "constant", value = 0.0 }
)" + signals;
}

CyclePlan plan_with(const std::string& signals, const std::string& start = "temperature_degC = 20.0") {
  return bind_config(parse_config(config_with(signals, start), "twin.toml"), two_node()).cycle;
}

std::string error_of(const std::string& text, const rom::Network& network) {
  return tests::refusal_of([&] { bind_config(parse_config(text, "twin.toml"), network); });
}

struct Twin {
  explicit Twin(const CyclePlan& plan) : network(two_node()), cycle(network, plan, runtime) {}

  const Snapshot& run(int cycles) {
    const Snapshot* last = nullptr;
    for (int i = 0; i < cycles; ++i) last = &cycle.step(frame, command, now_ns += 10'000'000'000LL, 0);
    return *last;
  }

  rom::Network network;
  Cycle cycle;
  DeviceFrame frame;
  PlcCommand command;
  std::int64_t now_ns = 0;
};

TEST(MeasuredHeat, what_the_plc_writes_warms_the_winding_and_is_served_again) {
  RegisterImage image{};
  clear_commands(image);
  EXPECT_TRUE(std::isnan(get(image, Register::command_heat, 3)));
  Twin twin(plan_with(ambient + "heat.loss = { source = \"plc\" }\n"));
  const Snapshot& unread = twin.run(1);
  EXPECT_TRUE(std::isnan(unread.signals[first_heat_signal]));
  EXPECT_NE(unread.quality & bits(Quality::signal_held), 0);

  put(image, Register::command_heat, 90.0, 0);
  PlcSignals told;
  EXPECT_TRUE(take_signals({entry_of(Register::command_heat).address, 2}, 77, image, told).any());
  twin.command.signals = told.values;
  EXPECT_EQ(twin.command.signals[first_heat_signal].value, 90.0);
  EXPECT_EQ(twin.command.signals[first_heat_signal].time_ns, 77);
  EXPECT_EQ(twin.command.signals[first_heat_signal + 1].time_ns, 0);
  const Snapshot& warm = twin.run(5000);
  EXPECT_EQ(warm.quality & bits(Quality::signal_held), 0);
  EXPECT_NEAR(warm.predicted_K[1], 293.15 + 90.0 / 5.0, 1e-2);
  EXPECT_NEAR(warm.predicted_K[0] - warm.predicted_K[1], 0.8 * 90.0 / 6.0, 1e-2);
  fill_image(warm, 0, image);
  EXPECT_EQ(get(image, Register::measured_heat, 0), 90.0);
  EXPECT_TRUE(std::isnan(get(image, Register::measured_heat, 1)));
}

TEST(MeasuredHeat, without_a_signal_it_is_what_the_network_says) {
  Twin twin(plan_with(ambient));
  const Snapshot& snapshot = twin.run(5000);
  EXPECT_NEAR(snapshot.predicted_K[1], 293.15 + 150.0 / 5.0, 1e-2);
  EXPECT_EQ(snapshot.quality & bits(Quality::signal_held), 0);
}

TEST(MeasuredHeat, a_network_without_deformation_and_coolant_runs_with_neither) {
  Twin twin(plan_with(ambient + "heat.loss = { source = \"constant\", value = 50.0 }\n"));
  twin.command.tare_orders = 1;
  const Snapshot& snapshot = twin.run(10);
  EXPECT_EQ(snapshot.state, State::running);
  EXPECT_EQ(snapshot.deformations, 0u);
  EXPECT_TRUE(std::isnan(snapshot.nose_m));
  EXPECT_EQ(snapshot.tare_m, 0.0) << "there is nothing to tare";
  EXPECT_EQ(snapshot.quality & bits(Quality::tared), 0);
  RegisterImage image{};
  fill_image(snapshot, 0, image);
  EXPECT_TRUE(std::isnan(get(image, Register::nose_float32)));
  EXPECT_TRUE(std::isnan(get(image, Register::coolant_temperature)));
  EXPECT_EQ(get(image, Register::deformation_count), 0.0);
  const std::string header = history_header(twin.network), row = history_row(snapshot);
  EXPECT_TRUE(header.ends_with(",current_A,power_W,heat.loss_W")) << header;
  EXPECT_TRUE(row.ends_with(",50")) << row;
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
  EXPECT_EQ(expect_of_sensors(twin.network, plan_with(ambient)), "");
}

TEST(MeasuredHeat, at_a_restart_the_standing_motor_has_none) {
  const CyclePlan plan = plan_with(ambient + "heat.loss = { source = \"constant\", value = 150.0 }\n");
  Twin ran(plan), again(plan);
  ran.run(3000);
  Remembered kept;
  ran.cycle.remember(kept);
  EXPECT_EQ(kept.signals[first_heat_signal], 150.0);
  EXPECT_EQ(again.cycle.resume(kept, 86400.0), Resumed::temperatures);
  const Snapshot& snapshot = again.run(1);
  EXPECT_NEAR(snapshot.predicted_K[1], 293.15, 0.1) << "cold again after a day";
}

TEST(StartTemperatures, each_node_has_its_own_and_the_others_their_mean) {
  const auto nodes_K = [](const std::string& start) { return plan_with(ambient, start).start_nodes_K; };
  EXPECT_EQ(nodes_K("temperature_degC = 20.0").size(), 0);
  EXPECT_EQ(nodes_K("temperature_degC = { winding = 80.0, housing = 40.0 }"), Eigen::Vector2d(353.15, 313.15));
  EXPECT_EQ(nodes_K("temperature_degC = { housing = 40.0 }"), Eigen::Vector2d(313.15, 313.15));
  Twin twin(plan_with(ambient + "heat.loss = { source = \"constant\", value = 0.0 }\n",
                      "temperature_degC = { winding = 80.0, housing = 40.0 }"));
  const Snapshot& snapshot = twin.run(1);
  EXPECT_NEAR(snapshot.predicted_K[0], 353.15 - 6.0 * 40.0 / 2250.0 * 10.0, 0.05) << "10 s later";
  EXPECT_NEAR(snapshot.uncorrected_K[0], snapshot.predicted_K[0], 1e-9);
}

TEST(StartTemperatureErrors, names_and_ranges_say_what_is_allowed) {
  const auto error = [](const std::string& start) { return error_of(config_with(ambient, start), two_node()); };
  EXPECT_EQ(error("temperature_degC = { rotor = 20.0 }"),
            "twin.toml:6: start.temperature_degC.rotor: the network has no node \"rotor\"; it has winding, housing");
  EXPECT_EQ(error("temperature_degC = { winding = 900.0 }"),
            "twin.toml:6: start.temperature_degC.winding: must be a number from -50 to 300, is 900");
  EXPECT_EQ(error("temperature_degC = {}"),
            "twin.toml:6: start.temperature_degC: must give at least one node its temperature");
}

TEST(MeasuredHeatErrors, names_say_what_there_is) {
  const std::string heat = "heat.iron = { source = \"plc\" }\n";
  EXPECT_EQ(error_of(config_with(ambient + heat), two_node()),
            "twin.toml:13: signals.heat.iron: the network has no measured heat \"iron\"; it has loss");
  rom::Network plain = two_node();
  plain.boundaries.sources[0].measured = false;
  EXPECT_EQ(error_of(config_with(ambient + heat), plain),
            "twin.toml:13: signals.heat.iron: the network has no measured heat");
  EXPECT_NE(error_of(config_with(ambient + "heat.loss = { source = \"plc\", first = 1e7 }\n"), two_node())
                .find("signals.heat.loss.first: must be a number from -1e+06 to 1e+06"),
            std::string::npos);
}

TEST(SurroundingErrors, a_signal_is_required_where_the_network_has_the_surrounding) {
  EXPECT_EQ(error_of(config_with(""), two_node()),
            "twin.toml:9: signals.ambient: this key is required: the network's surrounding \"room\" has this "
            "temperature");
  EXPECT_NE(error_of(config_with(ambient), tests::small_network()).find("signals.coolant: this key is required"),
            std::string::npos);
}

}  // namespace cycle_measured_heat_test
}  // namespace spindle_twin::firmware
