#include <gtest/gtest.h>

#include <string>

#include "firmware/config/config.hpp"
#include "tests/firmware/config/texts_of_signals.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/texts.hpp"

/// Configurations of which each table is right by itself, and that cannot be meant as they stand.
namespace spindle_twin::firmware {
namespace config_contradictions_test {

std::string error_of(const std::string& text) {
  return tests::refusal_of([&] { bind_config(parse_config(text, "/etc/twin.toml"), tests::small_network()); });
}

TEST(ConfigErrors, a_file_that_the_daemon_writes_is_none_that_it_reads_and_no_other_of_them) {
  const std::string start = all_from_the_plc + "[start]\ntemperature_degC = 25.0\n";
  const auto error = [&](const std::string& tables) { return error_of(start + tables); };
  for (const std::string table : {"checkpoint", "orders", "history"}) {
    for (const std::string path : {"small.rom", "./small.rom", "sub/../twin.toml"}) {
      EXPECT_NE(error("[" + table + "]\npath = \"" + path + "\"\n").find("would be written over"), std::string::npos)
          << table << ' ' << path;
    }
  }
  EXPECT_EQ(error("[checkpoint]\npath = \"x\"\n[history]\npath = \"x\"\n"),
            "/etc/twin.toml:11: checkpoint.path: \"/etc/x\" is history.path, which would be written over");
  EXPECT_NE(error("[checkpoint]\npath = \"x\"\n[history]\npath = \"x.orders\"\n").find("is history.path"),
            std::string::npos)
      << "orders stand beside the checkpoint where nothing else is said";
  EXPECT_EQ(error("[orders]\npath = \"x.lock\"\n[checkpoint]\npath = \"x\"\n"),
            "/etc/twin.toml:13: checkpoint.path: needs \"/etc/x.lock\" as its lock file, which is orders.path");
  EXPECT_EQ(error("[history]\npath = \"\"\n"), "/etc/twin.toml:11: history.path: must name a file, is empty");
  EXPECT_EQ(error("[history]\npath = \"" + std::string(5000, 'x') + "\"\n"),
            "/etc/twin.toml:11: history.path: is longer than a file's path may be");
  EXPECT_EQ(error("[checkpoint]\npath = \"x\"\n[history]\npath = \"y\"\nparameters = \"z\"\n"), "accepted");
}

TEST(ConfigErrors, what_nobody_can_mean_is_refused) {
  const std::string start = all_from_the_plc + "[start]\ntemperature_degC = 25.0\n";
  const auto changed = [&](const std::string& from, const std::string& to) {
    return error_of(tests::with(start, from, to));
  };
  EXPECT_EQ(changed("[serve]\n", "[serve]\nallow = []\n"),
            "/etc/twin.toml:3: serve.allow: must name at least one address or range; nobody else is answered");
  EXPECT_EQ(changed("[serve]\n", "[serve]\nallow_write = []\n"), "accepted") << "nobody may write";
  const std::string speed = "speed = { source = \"plc\" }";
  EXPECT_EQ(changed(speed, "speed = { source = \"plc\", first = 9000.0, max = 8000.0 }"),
            "/etc/twin.toml:4: signals.speed.first: must lie from min to max, is 9000");
  EXPECT_EQ(changed(speed, "speed = { source = \"plc\", first = 8000.0, max = 8000.0 }"), "accepted");
  EXPECT_EQ(
      error_of(
          start +
          "[device]\n[[sensor]]\nkey_point = \"sleeve_inner\"\nregister = 6\n[[sensor]]\nkey_point = \"sleeve_outer\"\n"
          "register = 6\n"),
      "/etc/twin.toml:15: sensor[2].key_point: input register 6 is read for \"sleeve_inner\" already; each needs its "
      "own");
  EXPECT_EQ(
      error_of(
          start +
          "[device]\n[[sensor]]\nkey_point = \"sleeve_inner\"\nregister = 6\n[[sensor]]\nkey_point = \"sleeve_outer\"\n"
          "register = 6\ntable = \"holding\"\n"),
      "accepted");
}

/// Two sensors of one device; `first` and `second` are the keys that say where they stand in it.
std::string two_sensors(const std::string& first, const std::string& second, const std::string& device = "") {
  return all_from_the_plc + "[start]\ntemperature_degC = 25.0\n[device]\n" + device +
         "[[sensor]]\nkey_point = \"sleeve_inner\"\n" + first + "[[sensor]]\nkey_point = \"sleeve_outer\"\n" + second;
}

TEST(ConfigErrors, one_register_is_no_word_of_two_numbers) {
  const std::string wide = "type = \"float32\"\n";
  EXPECT_EQ(
      error_of(two_sensors("register = 6\n" + wide, "register = 7\n" + wide)),
      "/etc/twin.toml:17: sensor[2].register: input register 7 has a word in common with the number of 2 words that "
      "another channel reads from input register 6");
  EXPECT_NE(error_of(two_sensors("register = 6\n", "register = 5\n" + wide)).find("the number of 1 word that"),
            std::string::npos);
  EXPECT_EQ(error_of(two_sensors("register = 6\n" + wide, "register = 8\n" + wide)), "accepted");
  EXPECT_EQ(error_of(two_sensors("register = 6\n" + wide, "register = 7\ntable = \"holding\"\n" + wide)), "accepted");
  const std::string preset = "preset = \"isma_sfar_s_6ti\"\n";
  EXPECT_NE(error_of(two_sensors("register = 51\n" + wide, "channel = 0\n", preset)).find("sensor[2].channel: input"),
            std::string::npos);
  // A sensor and a signal of one register, as signed and as unsigned number.
  const std::string load = "load = { source = \"plc\" }";
  const std::string one = "[device]\n[[sensor]]\nkey_point = \"sleeve_inner\"\nregister = 6\n";
  const std::string start = all_from_the_plc + "[start]\ntemperature_degC = 25.0\n" + one;
  EXPECT_EQ(error_of(tests::with(start, load, "load = { source = \"device\", register = 6, type = \"uint16\" }")),
            "accepted");
}

TEST(ConfigErrors, a_reading_may_grow_as_old_as_the_next_one_is_away) {
  const std::string slow = "poll_s = 20.0\n";
  EXPECT_EQ(error_of(two_sensors("register = 6\n", "register = 7\n", slow)), "accepted") << "three polls are usual";
  EXPECT_EQ(error_of(two_sensors("register = 6\n", "register = 7\nstale_after_s = 20.0\n", slow)), "accepted");
  EXPECT_EQ(error_of(two_sensors("register = 6\n", "register = 7\nstale_after_s = 10.0\n", slow)),
            "/etc/twin.toml:18: sensor[2].stale_after_s: must be at least the 20 s between two readings of its device "
            "(poll_s), or none is fresh to the end; is 10");
  for (const std::string rate : {"10.0", "60.0"}) {
    const std::string text = two_sensors("register = 6\n", "register = 7\nstale_after_s = 3.9\n", "poll_s = 3.9\n");
    EXPECT_EQ(error_of(tests::with(text, "[serve]\n", "[cycle]\nclock_rate = " + rate + "\n[serve]\n")), "accepted")
        << rate;
  }
}

TEST(ConfigErrors, a_step_beyond_the_limit_would_never_move) {
  const std::string start = all_from_the_plc + "[start]\ntemperature_degC = 25.0\n[compensation]\nlimit_um = 10.0\n";
  EXPECT_EQ(error_of(start + "step_um = 10.0\n"), "accepted");
  EXPECT_EQ(error_of(start + "step_um = 10.1\n"),
            "/etc/twin.toml:12: compensation.step_um: must be at most the limit, 10 um, or nothing ever moves");
}

}  // namespace config_contradictions_test
}  // namespace spindle_twin::firmware
