#include "firmware/config/read_exchange.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "firmware/config/daemon_config.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/texts.hpp"

namespace spindle_twin::firmware {
namespace config_read_exchange_test {

std::string text(const std::string& network, const std::string& exchange) {
  return "network = " + network +
         "\n[serve]\nport = 1502\n[start]\ntemperature_degC = 20.0\n[signals]\n"
         "speed = { source = \"plc\" }\nload = { source = \"plc\" }\n"
         "coolant = { source = \"plc\" }\nambient = { source = \"plc\" }\n" +
         exchange;
}

const std::string with_key = "{ file = \"x.rom\", trusted_keys = [\"" + std::string(64, 'a') + "\"] }";

TEST(ReadExchange, is_off_by_default_and_reads_minutes) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.toml");
  EXPECT_TRUE(parse_config(text("\"x.rom\"", ""), path).exchange.slot.empty());
  std::filesystem::create_directory(folder.file("slot"));
  const Config config =
      parse_config(text(with_key, "[exchange]\nslot = \"slot\"\ntrial_min = 2.0\nmargin_K = 0.2\n"), path);
  EXPECT_EQ(config.exchange.slot, folder.file("slot"));
  EXPECT_EQ(config.exchange.plan, (ExchangePlan{120.0, 3600.0, 0.1, 0.2}));
  const auto files = state_files(config);
  EXPECT_EQ(files.back(), folder.file("slot") + "/exchange") << "one daemon per slot";
}

TEST(ReadExchange, a_slot_that_is_no_folder_or_that_would_take_unsigned_networks_is_refused) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.toml");
  const auto refusal = [&](const std::string& network, const std::string& exchange) {
    return tests::refusal_of([&] { parse_config(text(network, exchange), path); });
  };
  EXPECT_NE(refusal(with_key, "[exchange]\nslot = \"slot\"\n").find("is not a folder"), std::string::npos);
  std::filesystem::create_directory(folder.file("slot"));
  EXPECT_NE(refusal("\"x.rom\"", "[exchange]\nslot = \"slot\"\n").find("trusted_keys"), std::string::npos);
  for (const char* line :
       {"trial_min = 0.0", "watch_min = 1e9", "margin = -1.0", "margin_K = -0.1", "marginal = 1.0"}) {
    const std::string said = refusal(with_key, std::string("[exchange]\nslot = \"slot\"\n") + line + "\n");
    EXPECT_NE(said.find(path + ":13: exchange."), std::string::npos) << said;
  }
}

TEST(ReadExchange, the_folder_of_the_network_is_no_slot_by_whatever_name) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.toml");
  std::filesystem::create_directory(folder.file("slot"));
  std::filesystem::create_directory_symlink(folder.file("."), folder.file("here"));
  for (const char* slot : {".", "here", "slot/.."}) {
    const std::string said = tests::refusal_of(
        [&] { parse_config(text(with_key, std::string("[exchange]\nslot = \"") + slot + "\"\n"), path); });
    EXPECT_NE(said.find("exchange.slot: is the folder of the network itself"), std::string::npos) << said;
  }
}

TEST(ReadExchange, numbers_are_taken_up_to_their_limits_and_refused_beyond) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.toml");
  std::filesystem::create_directory(folder.file("slot"));
  const auto said_to = [&](const std::string& line) {
    return tests::refusal_of(
        [&] { parse_config(text(with_key, "[exchange]\nslot = \"slot\"\n" + line + "\n"), path); });
  };
  for (const char* good : {"trial_min = 0.5", "trial_min = 10080.0", "watch_min = 0.5", "watch_min = 10080.0",
                           "margin = 0.0", "margin = 10.0", "margin_K = 0.0", "margin_K = 10.0"}) {
    EXPECT_EQ(said_to(good), "accepted") << good;
  }
  for (const char* bad : {"trial_min = 0.49", "trial_min = 10081.0", "watch_min = 0.49", "watch_min = 10081.0",
                          "margin = -0.01", "margin = 10.01", "margin_K = -0.01", "margin_K = 10.01"}) {
    EXPECT_NE(said_to(bad).find("must be a number from"), std::string::npos) << bad << ": " << said_to(bad);
  }
}

}  // namespace config_read_exchange_test
}  // namespace spindle_twin::firmware
