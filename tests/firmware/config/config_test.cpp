#include "firmware/config/config.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/firmware/config/texts_of_signals.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace config_config_test {

const std::string good = R"(network = "small.rom"
[cycle]
clock_rate = 60.0
[serve]
port = 1502
allow = ["127.0.0.1", "192.168.1.0/24"]
[device]
port = 1503
[[sensor]]
key_point = "sleeve_inner"
register = 0
type = "float32"
[[sensor]]
key_point = "sleeve_outer"
register = 2
scale = 0.01
offset = 0.5
[signals]
speed = { source = "plc" }
load = { source = "device", register = 10, scale = 0.001 }
coolant = { source = "constant", value = 27.0 }
ambient = { source = "device", register = 12, type = "float32" }
[correction]
law = "paper"
relaxation = 0.5
)";

std::string with(const std::string& from, const std::string& to) { return tests::with(good, from, to); }

std::string error_of(const std::string& text) {
  return tests::refusal_of([&] { bind_config(parse_config(text, "/etc/twin.toml"), tests::small_network()); });
}

TEST(Config, values_come_in_si) {
  const Config config = parse_config(good, "/etc/twin.toml");
  const SpindlePlan plan = bind_config(config, tests::small_network());
  EXPECT_EQ(config.network.path, "/etc/small.rom");
  EXPECT_TRUE(plan.cycle.sensors[0].configured);
  EXPECT_FALSE(plan.cycle.sensors[1].configured);
  EXPECT_TRUE(plan.cycle.sensors[2].configured);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[0].max_K, 423.15);
  ASSERT_EQ(plan.devices.size(), 1U);
  const std::vector<Channel>& channels = plan.devices[0].channels;
  ASSERT_EQ(channels.size(), 4U);
  EXPECT_EQ(channels[1].index, 2U);
  EXPECT_DOUBLE_EQ(convert(channels[1].conversion, 100.0).value, 274.65);
  EXPECT_DOUBLE_EQ(convert(channels[2].conversion, 100.0).value, 0.1);
  EXPECT_DOUBLE_EQ(convert(channels[3].conversion, 1.0).value, 274.15);
  EXPECT_DOUBLE_EQ(plan.devices[0].poll_s, 1.0 / 60.0);
  EXPECT_DOUBLE_EQ(plan.cycle.signals[2].value, 300.15);
  EXPECT_EQ(plan.cycle.signals[0].source, SignalSource::plc);
  ASSERT_TRUE(plan.cycle.paper.has_value());
  EXPECT_DOUBLE_EQ(plan.cycle.paper->relaxation, 0.5);
  ASSERT_EQ(plan.cycle.paper->groups.size(), 1U);
  EXPECT_EQ(plan.cycle.paper->groups[0].key_points, (std::vector<int>{0, 2}));
  EXPECT_EQ(config.serve.address, "127.0.0.1");
}

TEST(Config, a_flow_is_that_of_the_circuit_that_it_names) {
  rom::Network network = tests::small_network();
  network.boundaries.circuits = {{"jacket", 0, 4180.0, {2}}, {"cover", 1, 4180.0, {3}}, {"nut", 1, 4180.0, {}}};
  network.boundaries.operating.flow_kg_per_s = Eigen::Vector3d(0.1, 0.2, 0.3);
  const std::string text = with("[signals]\n", "[signals]\nflow.cover = { source = \"constant\", value = 0.25 }\n");
  const CyclePlan plan = bind_config(parse_config(text, "twin.toml"), network).cycle;
  EXPECT_EQ(plan.signals[first_flow_signal].value, 0.1) << "of the operating state where nobody says";
  EXPECT_EQ(plan.signals[first_flow_signal + 1].value, 0.25);
  EXPECT_EQ(plan.signals[first_flow_signal + 2].value, 0.3);
}

TEST(Config, without_an_allow_list_only_this_machine_is_answered) {
  const Config config = parse_config(with("allow = [\"127.0.0.1\", \"192.168.1.0/24\"]\n", ""), "twin.toml");
  EXPECT_TRUE(is_allowed(config.serve.allow, parse_address_range("127.0.0.1")->address));
  EXPECT_FALSE(is_allowed(config.serve.allow, parse_address_range("192.168.1.7")->address));
}

TEST(Config, estimator_corrects_by_default_and_each_sensor_may_have_its_own_noise) {
  const std::string text = with("law = \"paper\"\nrelaxation = 0.5\n",
                                "noise_K = 0.05\nlag_s = 4.0\n[correction.prior]\nheat = 0.15\nheat_common = 0.5\n"
                                "[output]\nslew_um_per_s = 0.1\n");
  std::string own = text;
  own.replace(own.find("scale = 0.01"), 12,
              "scale = 0.01\nnoise_K = 0.1\noffset_K = 0.2\nlag_s = 20.0\ninterval_s = 10.0");
  const SpindlePlan plan = bind_config(parse_config(own, "twin.toml"), tests::small_network());
  ASSERT_TRUE(plan.cycle.estimator.has_value());
  EXPECT_FALSE(plan.cycle.paper.has_value());
  EXPECT_TRUE(plan.cycle.estimator_corrects);
  EXPECT_DOUBLE_EQ(plan.cycle.estimator->period_s, 10.0);
  EXPECT_DOUBLE_EQ(plan.cycle.estimator->priors.heat, 0.15);
  EXPECT_DOUBLE_EQ(plan.cycle.estimator->priors.heat_common, 0.5);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[0].noise_K, 0.05);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[0].offset_deviation_K, 0.02);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[0].lag_s, 4.0);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[2].noise_K, 0.1);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[2].offset_deviation_K, 0.2);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[2].lag_s, 20.0);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[2].interval_s, 10.0);
  EXPECT_DOUBLE_EQ(plan.cycle.sensors[2].stale_after_s, 30.0) << "by default three of its own intervals";
  EXPECT_DOUBLE_EQ(plan.cycle.slew_m_per_s, 1e-7);
}

TEST(Config, without_a_correction_table_the_estimator_corrects_and_without_a_law_it_stands_by) {
  const std::string table = "[correction]\nlaw = \"paper\"\nrelaxation = 0.5\n";
  EXPECT_TRUE(bind_config(parse_config(with(table, ""), "twin.toml"), tests::small_network()).cycle.estimator_corrects);
  const CyclePlan none =
      bind_config(parse_config(with(table, "[correction]\nlaw = \"none\"\n"), "twin.toml"), tests::small_network())
          .cycle;
  EXPECT_TRUE(none.estimator.has_value());
  EXPECT_FALSE(none.estimator_corrects);
}

TEST(ConfigErrors, the_estimators_options_say_what_is_allowed) {
  const std::string paper = "law = \"paper\"\nrelaxation = 0.5\n";
  EXPECT_EQ(error_of(with(paper, "period_s = 0.5\n")),
            "/etc/twin.toml:24: correction.period_s: must be a number from 1 to 60, is 0.5");
  EXPECT_EQ(error_of(with(paper, "[correction.prior]\nheat = 3.0\n")),
            "/etc/twin.toml:25: correction.prior.heat: must be a number from 0 to 2, is 3");
  EXPECT_EQ(error_of(with("scale = 0.01", "noise_K = 0.0")),
            "/etc/twin.toml:16: sensor[2].noise_K: must be a number from 0.0001 to 10, is 0");
  EXPECT_EQ(error_of(good + "[output]\nslew_um_per_s = 0.0\n").rfind("/etc/twin.toml:27: output.slew_um_per_s: ", 0),
            0U);
  const std::string unknown = error_of(with(paper, "relaxation = 0.5\n"));
  EXPECT_NE(unknown.find("correction.relaxation: unknown key"), std::string::npos) << unknown;
}

TEST(ConfigErrors, the_published_laws_options_say_what_is_allowed) {
  const std::string law = "law = \"paper\"\n", relaxation = "relaxation = 0.5\n";
  EXPECT_EQ(error_of(with(law + relaxation, law + "joint_exponent = 1.5\n")),
            "/etc/twin.toml:25: correction.joint_exponent: must be a number from 0 to 1, is 1.5");
  EXPECT_EQ(error_of(with(law + relaxation, law + "relaxation = 0.0\n")),
            "/etc/twin.toml:25: correction.relaxation: must be a number from 0 (excluded) to 1, is 0");
}

TEST(Config, a_probe_stands_at_a_deformation_output) {
  const std::string probe =
      "[[displacement]]\noutput = \"nose\"\nregister = 20\nscale = 0.1\nsd_um = 0.5\ninterval_s = 30.0\n";
  const SpindlePlan plan = bind_config(parse_config(good + probe, "twin.toml"), tests::small_network());
  EXPECT_TRUE(plan.cycle.probes[0].configured);
  EXPECT_FALSE(plan.cycle.probes[1].configured);
  EXPECT_DOUBLE_EQ(plan.cycle.probes[0].deviation_m, 0.5e-6);
  EXPECT_DOUBLE_EQ(plan.cycle.probes[0].interval_s, 30.0);
  const Channel& channel = plan.devices[0].channels[2];
  ASSERT_EQ(channel.kind, Channel::Kind::displacement);
  EXPECT_DOUBLE_EQ(convert(channel.conversion, 1.0).value, 1e-7);
  EXPECT_NE(error_of(good + probe + probe).find("\"nose\" has a probe already"), std::string::npos);
  EXPECT_EQ(
      error_of(good + "[[displacement]]\noutput = \"tip\"\nregister = 20\nsd_um = 1.0\n"),
      "/etc/twin.toml:27: displacement[1].output: the network has no deformation output \"tip\"; it has nose, rear");
}

TEST(Config, groups_name_sensors_and_sources) {
  const std::string text =
      good + "[[correction.group]]\nname = \"rear\"\nsensors = [\"sleeve_outer\"]\nsources = [\"bearing\"]\n";
  const SpindlePlan plan = bind_config(parse_config(text, "twin.toml"), tests::small_network());
  EXPECT_EQ(plan.cycle.paper->groups[0].key_points, (std::vector<int>{2}));
  EXPECT_EQ(plan.cycle.paper->groups[0].sources, (std::vector<int>{0}));
}

TEST(ConfigErrors, an_unknown_key_point_lists_those_there_are) {
  EXPECT_EQ(
      error_of(with("\"sleeve_outer\"", "\"sleve_outer\"")),
      "/etc/twin.toml:14: sensor[2].key_point: the network has no key point \"sleve_outer\"; it has sleeve_inner, "
      "sleeve_middle, sleeve_outer");
}

TEST(ConfigErrors, two_sensors_at_one_key_point) {
  EXPECT_EQ(error_of(with("\"sleeve_outer\"", "\"sleeve_inner\"")),
            "/etc/twin.toml:14: sensor[2].key_point: \"sleeve_inner\" has a sensor already");
}

TEST(ConfigErrors, an_unknown_key_names_its_line) {
  const std::string error = error_of(with("clock_rate", "clock_rat"));
  EXPECT_EQ(error.rfind("/etc/twin.toml:3: cycle.clock_rat: unknown key, did you mean \"clock_rate\"?", 0), 0U)
      << error;
}

TEST(ConfigErrors, ports_addresses_and_ranges_say_what_is_allowed) {
  EXPECT_EQ(error_of(with("port = 1502", "port = 70000")),
            "/etc/twin.toml:5: serve.port: must be an integer from 1 to 65535, is 70000");
  EXPECT_EQ(error_of(with("port = 1503", "port = 1503\naddress = \"plant\"")),
            "/etc/twin.toml:9: device.address: must be an IPv4 address such as 127.0.0.1, is \"plant\"");
  EXPECT_EQ(error_of(with("192.168.1.0/24", "192.168.1.0/40")),
            "/etc/twin.toml:6: serve.allow: every entry must be an IPv4 address or range such as 192.168.1.0/24, is "
            "\"192.168.1.0/40\"");
  EXPECT_EQ(error_of(with("clock_rate = 60.0", "clock_rate = -1.0")),
            "/etc/twin.toml:3: cycle.clock_rate: must be a number from 0.1 to 1000, is -1");
  EXPECT_EQ(
      error_of(with("relaxation = 0.5", "relaxation = nan")).rfind("/etc/twin.toml:25: correction.relaxation:", 0), 0U);
}

TEST(ConfigErrors, missing_parts_are_named) {
  EXPECT_EQ(error_of(with("network = \"small.rom\"\n", "")), "/etc/twin.toml:1: network: this key is required");
  EXPECT_EQ(error_of(with("speed = { source = \"plc\" }\n", "")),
            "/etc/twin.toml:18: signals.speed: this key is required");
  EXPECT_EQ(error_of(with("[device]\nport = 1503\n", "")),
            "/etc/twin.toml:8: sensor[1].key_point: sensors need a [[device]] table");
}

TEST(ConfigErrors, choices_list_what_is_allowed) {
  EXPECT_EQ(error_of(with("type = \"float32\"", "type = \"float64\"")),
            "/etc/twin.toml:12: sensor[1].type: must be one of int16, uint16, offset16, int32, uint32, float32, "
            "float32_cdab, is \"float64\"");
  EXPECT_EQ(error_of(with("law = \"paper\"", "law = \"magic\"")),
            "/etc/twin.toml:24: correction.law: must be one of estimator, paper, none, is \"magic\"");
}

TEST(ConfigErrors, a_group_with_a_source_that_is_not_there) {
  const std::string error =
      error_of(good + "[[correction.group]]\nname = \"rear\"\nsensors = [\"sleeve_outer\"]\nsources = [\"motor\"]\n");
  EXPECT_NE(error.find("the network has no heat source \"motor\"; it has bearing, rotor"), std::string::npos) << error;
}

TEST(ConfigErrors, a_network_too_large_for_the_map) {
  rom::Network network = tests::small_network();
  while (network.parts.size() <= slots::parts) network.parts.push_back(network.parts[0]);
  try {
    bind_config(parse_config(good, "/etc/twin.toml"), network);
    FAIL() << "no error";
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()), "/etc/twin.toml:1: network: has 33 parts, the register map has room for 32");
  }
}

TEST(Config, until_it_is_written_a_signal_is_standstill_without_load_at_twenty_degrees) {
  const Config config = parse_config(all_from_the_plc + "[start]\ntemperature_degC = 25.0\n", "x.toml");
  const auto signals = bind_config(config, tests::small_network()).cycle.signals;
  for (std::size_t s = 0; s < 4; ++s) EXPECT_DOUBLE_EQ(signals[s].value, s < 2 ? 0.0 : 293.15) << s;
}

TEST(ConfigErrors, start_without_sensors_needs_a_temperature) {
  const std::string& text = all_from_the_plc;
  EXPECT_EQ(error_of(text),
            "/etc/twin.toml:1: start: temperature_degC is required here when there is no sensor to start from");
  EXPECT_EQ(error_of(text + "[start]\ntemperature_degC = 25.0\n"), "accepted");
}

TEST(Config, sessions_of_the_page_end_within_limits_that_are_refused_beyond) {
  const tests::TemporaryFolder folder;
  const std::string accounts = folder.file("accounts");
  std::ofstream(accounts) << "anna:$argon2id$v=19$m=8,t=1,p=1$c2FsdHNhbHRzYWx0c2FsdA$" << std::string(43, 'A') << "\n";
  std::filesystem::permissions(accounts, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const auto commands = [&](const std::string& line) {
    return good + "[http]\n[http.commands]\naccounts = \"" + accounts + "\"\n" + line + "\n";
  };
  EXPECT_EQ(error_of(commands("")), "accepted");
  for (const char* line : {"idle_min = 1.0", "idle_min = 1440.0", "longest_h = 0.1", "longest_h = 168.0"}) {
    EXPECT_EQ(error_of(commands(line)), "accepted") << line;
  }
  for (const char* line : {"idle_min = 0.9", "idle_min = 1441.0", "longest_h = 0.09", "longest_h = 168.1"}) {
    EXPECT_NE(error_of(commands(line)).find("must be a number from"), std::string::npos) << line;
  }
  const CommandPlan plan = *parse_config(commands("idle_min = 2.0\nlongest_h = 3.0"), "x.toml").show.commands;
  EXPECT_DOUBLE_EQ(plan.idle_s, 120.0);
  EXPECT_DOUBLE_EQ(plan.longest_s, 10800.0);
}

TEST(Config, texts_and_numbers_that_hang_together_are_taken_up_to_their_ends) {
  const std::string named = good + "[plant]\nhost = \"broker\"\nnode = \"mill\"\ngroup = \"";
  EXPECT_EQ(error_of(named + std::string(64, 'a') + "\"\n"), "accepted");
  EXPECT_NE(error_of(named + std::string(65, 'a') + "\"\n").find("must be 1 to 64"), std::string::npos);
  EXPECT_EQ(error_of(named + "A_z-0. 9\"\n"), "accepted");
  const std::string noticed = good + "[http]\nnotice = \"";
  EXPECT_EQ(error_of(noticed + std::string(300, 'a') + "\"\n"), "accepted");
  EXPECT_NE(error_of(noticed + std::string(301, 'a') + "\"\n").find("at most 300"), std::string::npos);
  for (const char* minutes : {"0.0", "5.0", "235.0", "240.0"}) {
    EXPECT_EQ(error_of(good + "[compensation]\nlook_ahead_min = " + minutes + "\n"), "accepted") << minutes;
  }
  for (const char* minutes : {"-5.0", "2.5", "241.0", "245.0"}) {
    EXPECT_NE(error_of(good + "[compensation]\nlook_ahead_min = " + minutes + "\n"), "accepted") << minutes;
  }
  EXPECT_EQ(error_of(with("clock_rate = 60.0", "clock_rate = 10.0\nperiod_s = 0.01")), "accepted");
  EXPECT_NE(error_of(with("clock_rate = 60.0", "clock_rate = 10.1\nperiod_s = 0.01")).find("at least 0.001 s"),
            std::string::npos);
  EXPECT_NE(error_of(with("register = 2", "register = 2\nmin_degC = 20.0\nmax_degC = 20.0")).find("above min_degC"),
            std::string::npos);
  const std::string probe = good + "[[displacement]]\noutput = \"nose\"\nregister = 20\nsd_um = 1.0\n";
  EXPECT_EQ(error_of(probe + "min_um = 1.0\nmax_um = 1.001\n"), "accepted");
  EXPECT_NE(error_of(probe + "min_um = 1.0\nmax_um = 1.0\n").find("above min_um"), std::string::npos);
}

TEST(Config, the_log_says_who_commands_so_it_must_be_read) {
  const tests::TemporaryFolder folder;
  const std::string accounts = folder.file("accounts");
  std::ofstream(accounts) << "anna:$argon2id$v=19$m=8,t=1,p=1$c2FsdHNhbHRzYWx0c2FsdA$" << std::string(43, 'A') << "\n";
  std::filesystem::permissions(accounts, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const auto said = [&](const std::string& level, const std::string& http, const std::string& commands) {
    return error_of("log_level = \"" + level + "\"\n" + good + "[http]\n" + http +
                    (commands == "none" ? "" : "[http.commands]\naccounts = \"" + accounts + "\"\n" + commands));
  };
  EXPECT_EQ(said("warning", "", ""), "accepted");
  EXPECT_EQ(said("error", "", "none"), "accepted");
  EXPECT_NE(said("error", "", "").find("log_level: must be \"warning\" or lower"), std::string::npos);
  const std::string open = "address = \"0.0.0.0\"\n";
  EXPECT_NE(said("info", open, "").find("unencrypted: must be true"), std::string::npos);
  EXPECT_NE(said("info", open, "behind_tls = false\nunencrypted = false\n").find("unencrypted"), std::string::npos);
  EXPECT_EQ(said("info", open, "behind_tls = true\n"), "accepted");
  EXPECT_EQ(said("info", open, "unencrypted = true\n"), "accepted");
}

TEST(Config, the_commented_example_is_valid) {
  const Config config = read_config(SPINDLE_TWIN_SOURCE_DIR "/firmware/spindle-twind.example.toml");
  EXPECT_EQ(config.sensors.size(), 3U);
}

TEST(Config, nobody_listens_for_http_unless_told_to_and_then_on_the_loopback_only) {
  EXPECT_FALSE(parse_config(good, "/etc/twin.toml").show.enabled);
  const ShowPlan show = parse_config(good + "[http]\n", "/etc/twin.toml").show;
  EXPECT_TRUE(show.enabled);
  EXPECT_EQ(show.address, "127.0.0.1");
  EXPECT_TRUE(is_allowed(show.allow, 0x7F000001U));
  EXPECT_FALSE(is_allowed(show.allow, 0xC0A80101U));
  EXPECT_EQ(error_of(good + "[http]\nport = 0\n").find("/etc/twin.toml:27: http.port: "), 0U);
  EXPECT_EQ(error_of(good + "[http]\naddress = \"here\"\n").find("/etc/twin.toml:27: http.address: "), 0U);
  EXPECT_EQ(error_of(good + "[http]\npath = \"/\"\n").find("/etc/twin.toml:27: http.path: "), 0U);
}

TEST(Config, nothing_is_published_unless_told_to) {
  EXPECT_FALSE(parse_config(good, "/etc/twin.toml").plant.enabled);
  const std::string named = good + "[plant]\nhost = \"broker\"\nnode = \"mill 7\"\n";
  const PlantPlan plant = parse_config(named, "/etc/twin.toml").plant;
  EXPECT_TRUE(plant.enabled);
  EXPECT_EQ(plant.port, 1883);
  EXPECT_EQ(plant.group, "spindles");
  EXPECT_EQ(plant.node, "mill 7");
  EXPECT_EQ(error_of(good + "[plant]\nhost = \"broker\"\n").find("/etc/twin.toml:26: plant.node: "), 0U);
  EXPECT_EQ(error_of(good + "[plant]\nnode = \"a\"\n").find("/etc/twin.toml:26: plant.host: "), 0U);
  for (const char* name : {"", "a/b", "a+", "#", "\\n"}) {
    const std::string said = error_of(named + "group = \"" + name + "\"\n");
    EXPECT_EQ(said.find("/etc/twin.toml:29: plant.group: must be 1 to 64 letters"), 0U) << said;
  }
  EXPECT_EQ(parse_config(named + "registers = [\"nose\", \"quality\"]\n", "/etc/twin.toml").plant.registers.size(), 2U);
  for (const char* name : {"nosy", "nose_int16", "command_tare"}) {
    const std::string said = error_of(named + "registers = [\"nose\", \"" + name + "\"]\n");
    EXPECT_EQ(said.find("/etc/twin.toml:29: plant.registers: \"" + std::string(name) + "\" is none"), 0U) << said;
  }
  const std::string files = "[plant.tls]\nca = \"ca\"\ncertificate = \"c\"\nkey = \"k\"\n";
  EXPECT_EQ(error_of(named + files).find("/etc/twin.toml:31: plant.tls.certificate: /etc/c: "), 0U);
}

TEST(Config, a_history_is_bounded_by_days_in_a_database_and_by_segments_in_text) {
  const HistoryPlan plan =
      parse_config(good + "[history]\npath = \"a.sqlite\"\nmost_MiB = 16.0\nmost_days = 7.0\n", "/etc/twin.toml")
          .history;
  EXPECT_EQ(plan.path, "/etc/a.sqlite");
  EXPECT_EQ(plan.most_bytes, std::uint64_t{16} << 20);
  EXPECT_EQ(plan.most_days, 7.0);
  EXPECT_NE(error_of(good + "[history]\npath = \"a.sqlite\"\nsegment_MiB = 1.0\n").find("segment_MiB: is of CSV"),
            std::string::npos);
  EXPECT_NE(error_of(good + "[history]\npath = \"a.csv\"\nmost_days = 1.0\n").find("most_days: needs a path"),
            std::string::npos);
  EXPECT_NE(error_of(good + "[history]\npath = \"a.sqlite\"\nmost_MiB = 1.0\n").find("history.most_MiB: "),
            std::string::npos);
}

}  // namespace config_config_test
}  // namespace spindle_twin::firmware
