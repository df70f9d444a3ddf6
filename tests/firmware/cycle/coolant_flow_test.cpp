#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/config/config.hpp"
#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/history.hpp"
#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace cycle_coolant_flow_test {

constexpr double operating_kg_per_s = 0.02;
constexpr double heat_capacity_J_per_kgK = 4180.0;

/// The small network with its coolant film as the one segment of a circuit. The root of its area has no rounding, so
/// that G/A times area over m c is exactly 1 at a trickle.
rom::Network jacket_network() {
  rom::Network network = tests::small_network();
  rom::Conductance& film = network.boundaries.conductances[2];
  film.nominal_W_per_m2K *= film.area_m2 / 0.0625;
  film.area_m2 = 0.0625;
  network.factors_m[2](4, 0) = 0.25;
  network.boundaries.circuits = {{"jacket", 0, heat_capacity_J_per_kgK, {2}}};
  network.boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, operating_kg_per_s);
  return network;
}

std::string config_with(const std::string& flow) {
  return R"(network = "small.rom"
[serve]
[device]
port = 1503
[start]
temperature_degC = 27.0
[cycle]
period_s = 60.0
[signals]
speed = { source = "constant", value = 6000.0 }
load = { source = "constant", value = 1.0 }
coolant = { source = "constant", value = 27.0 }
ambient = { source = "constant", value = 27.0 }
)" + flow;
}

CyclePlan plan_with(const std::string& flow) {
  return bind_config(parse_config(config_with(flow), "twin.toml"), jacket_network()).cycle;
}

std::unique_ptr<rom::FallbackStepper> runtime(const rom::Network& network) {
  return rom::make_runtime_stepper(network);
}

std::int64_t at_s(int cycle) { return 60'000'000'000LL * (cycle + 1); }

/// What a cycle uses at once: PLC and device as they were last.
struct Twin {
  explicit Twin(const std::string& flow) : cycle(network, plan_with(flow), runtime) { frame.connected = true; }

  const Snapshot& run(int cycles) {
    for (int n = 1; n < cycles; ++n, ++now) cycle.step(frame, command, at_s(now), 0);
    return cycle.step(frame, command, at_s(now++), 0);
  }

  rom::Network network = jacket_network();
  Cycle cycle;
  DeviceFrame frame;
  PlcCommand command;
  int now = 0;
};

/// All 100 W leave at the outer node: by the channel, m c (1 - exp(-h A / (m c))), and by 0.8 W/K to the air.
double outer_rise_K(double flow_kg_per_s) {
  const double flow_W_per_K = std::abs(flow_kg_per_s) * heat_capacity_J_per_kgK;
  const double channel_W_per_K = flow_W_per_K > 0.0 ? flow_W_per_K * -std::expm1(-25.0 / flow_W_per_K) : 0.0;
  return 100.0 / (channel_W_per_K + 0.8);
}

double outer_rise_K(const Snapshot& snapshot) { return snapshot.predicted_K[2] - 300.15; }

TEST(CoolantFlow, steady_rise_is_that_of_the_channel_at_the_flow_of_the_machine) {
  Twin twin("flow.jacket = { source = \"plc\" }\n");
  for (const double flow_kg_per_s : {0.02, 0.001, -0.001, 0.0}) {
    twin.command.signals[first_flow_signal] = {flow_kg_per_s, at_s(twin.now)};
    const Snapshot& snapshot = twin.run(flow_kg_per_s == 0.0 ? 1500 : 300);
    EXPECT_NEAR(outer_rise_K(snapshot), outer_rise_K(flow_kg_per_s), 2e-4 * outer_rise_K(flow_kg_per_s));
    EXPECT_EQ(snapshot.state, State::running);
    EXPECT_DOUBLE_EQ(snapshot.signals[first_flow_signal], flow_kg_per_s);
  }
}

TEST(CoolantFlow, a_trickle_that_leaves_at_the_walls_temperature_keeps_every_deviation_a_number) {
  Twin twin("flow.jacket = { source = \"plc\" }\n");
  for (const double flow_kg_per_s : {0.02, 1e-3, 1e-4, 1e-5, 0.02}) {
    twin.command.signals[first_flow_signal] = {flow_kg_per_s, at_s(twin.now)};
    const Snapshot& snapshot = twin.run(20);
    EXPECT_GT(snapshot.deformation_deviation_m[0], 0.0) << flow_kg_per_s;
    EXPECT_TRUE(std::isfinite(snapshot.deformation_deviation_m[0])) << flow_kg_per_s;
  }
}

TEST(CoolantFlow, until_it_was_read_once_the_operating_flow_is_used_and_said_to_be_held) {
  Twin twin("flow.jacket = { source = \"plc\" }\n");
  const Snapshot& snapshot = twin.run(300);
  EXPECT_NEAR(outer_rise_K(snapshot), outer_rise_K(operating_kg_per_s), 1e-3);
  EXPECT_NE(snapshot.quality & bits(Quality::signal_held), 0);
  EXPECT_EQ(snapshot.state, State::degraded);
}

TEST(CoolantFlow, a_configured_first_value_comes_before_the_operating_flow) {
  EXPECT_EQ(plan_with("flow.jacket = { source = \"plc\", first = 0.5 }\n").signals[first_flow_signal].value, 0.5);
  EXPECT_EQ(plan_with("flow.jacket = { source = \"constant\", value = 0.5 }\n").signals[first_flow_signal].value, 0.5);
}

TEST(CoolantFlow, a_circuit_that_is_not_configured_keeps_its_operating_flow_without_complaint) {
  Twin twin("");
  const Snapshot& snapshot = twin.run(300);
  EXPECT_NEAR(outer_rise_K(snapshot), outer_rise_K(operating_kg_per_s), 1e-3);
  EXPECT_EQ(snapshot.quality & bits(Quality::signal_held), 0);
  EXPECT_EQ(snapshot.state, State::running);
}

TEST(CoolantFlow, what_is_out_of_range_stale_or_no_number_holds_the_last_good_flow) {
  Twin twin("flow.jacket = { source = \"device\", register = 8, stale_after_s = 90.0 }\n");
  Reading& flow = twin.frame.signals[first_flow_signal];
  flow = {0.005, at_s(0)};
  EXPECT_EQ(twin.run(1).quality & bits(Quality::signal_held), 0);
  for (const double bad : {11.0, -11.0, std::numeric_limits<double>::quiet_NaN()}) {
    flow = {bad, at_s(twin.now)};
    const Snapshot& snapshot = twin.run(1);
    EXPECT_DOUBLE_EQ(snapshot.signals[first_flow_signal], 0.005);
    EXPECT_NE(snapshot.quality & bits(Quality::signal_held), 0);
  }
  flow = {0.007, at_s(twin.now)};
  EXPECT_EQ(twin.run(2).quality & bits(Quality::signal_held), 0);
  const Snapshot& stale = twin.run(1);
  EXPECT_DOUBLE_EQ(stale.signals[first_flow_signal], 0.007);
  EXPECT_NE(stale.quality & bits(Quality::signal_held), 0);
}

TEST(CoolantFlow, the_plc_writes_and_reads_it_in_tenths_of_a_gram_per_second) {
  RegisterImage image{};
  clear_commands(image);
  EXPECT_TRUE(std::isnan(get(image, Register::command_flow, 0)));
  PlcSignals told;
  put(image, Register::command_flow, -20.5, 0);
  EXPECT_TRUE(take_signals({entry_of(Register::command_flow).address, 1}, 77, image, told).any());
  EXPECT_NEAR(told.values[first_flow_signal].value, -0.0205, 1e-12);
  EXPECT_EQ(told.values[first_flow_signal].time_ns, 77);
  EXPECT_EQ(told.values[first_flow_signal + 1].time_ns, 0);

  Twin twin("flow.jacket = { source = \"plc\" }\n");
  twin.command.signals = told.values;
  fill_image(twin.run(1), 0, image);
  EXPECT_NEAR(get(image, Register::coolant_flow, 0), -20.5, 1e-9);
  EXPECT_TRUE(std::isnan(get(image, Register::coolant_flow, 1)));
  EXPECT_EQ(get(image, Register::circuit_count), 1.0);
}

TEST(CoolantFlow, the_history_holds_what_a_replay_needs) {
  Twin twin("flow.jacket = { source = \"plc\" }\n");
  const std::string header = history_header(twin.network);
  EXPECT_NE(header.find(",tare_um,flow.jacket_kg_per_s,measured."), std::string::npos) << header;
  twin.command.signals[first_flow_signal] = {0.0125, at_s(0)};
  const std::string row = history_row(twin.run(1));
  EXPECT_NE(row.find(",0.0125,"), std::string::npos) << row;
  EXPECT_EQ(std::count(header.begin(), header.end(), ','), std::count(row.begin(), row.end(), ','));
}

TEST(CoolantFlowErrors, names_and_ranges_say_what_is_allowed) {
  const auto error_of = [](const std::string& flow, const rom::Network& network) -> std::string {
    try {
      bind_config(parse_config(config_with(flow), "twin.toml"), network);
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_of("flow.helix = { source = \"plc\" }\n", jacket_network()),
            "twin.toml:14: signals.flow.helix: the network has no coolant circuit \"helix\"; it has jacket");
  EXPECT_EQ(error_of("flow.jacket = { source = \"plc\" }\n", tests::small_network()),
            "twin.toml:14: signals.flow.jacket: the network has no coolant circuit");
  EXPECT_EQ(error_of("flow.jacket = { source = \"constant\", value = 20.0 }\n", jacket_network()),
            "twin.toml:14: signals.flow.jacket.value: must be a number from -10 to 10, is 20");
  rom::Network many = jacket_network();
  while (many.boundaries.circuits.size() <= slots::circuits) {
    many.boundaries.circuits.push_back(many.boundaries.circuits.front());
  }
  EXPECT_EQ(error_of("", many), "twin.toml:1: network: has 5 coolant circuits, the register map has room for 4");
}

}  // namespace cycle_coolant_flow_test
}  // namespace spindle_twin::firmware
