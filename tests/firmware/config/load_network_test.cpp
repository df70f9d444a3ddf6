#include "firmware/config/load_network.hpp"

#include <gtest/gtest.h>

#include "rom/file/signature.hpp"
#include "rom/file/whole_file.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace config_load_network_test {

namespace fs = std::filesystem;

class LoadNetwork : public ::testing::Test {
 protected:
  LoadNetwork() {
    configured.path = folder.file("x.rom");
    configured.where = {"twin.toml", 7};
    configured.field = "network";
  }

  void write() const { rom::write_network(network, configured.path); }

  std::string refusal() const {
    try {
      load_network(configured);
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "";
  }

  tests::TemporaryFolder folder;
  ConfiguredNetwork configured;
  rom::Network network = tests::small_network();
};

TEST_F(LoadNetwork, a_certified_network_needs_nothing_said) {
  write();
  EXPECT_EQ(load_network(configured).network.certificate.cases, 20u);
}

TEST_F(LoadNetwork, a_network_of_the_fe_model_without_certificate_is_never_run) {
  network.certificate = {};
  write();
  configured.allow_uncertified = true;
  EXPECT_EQ(refusal(), "twin.toml:7: network: " + configured.path +
                           " carries no certificate, so its error is unknown; `spindle-twin build` measures one");
}

TEST_F(LoadNetwork, a_hand_written_network_is_run_where_the_configuration_allows_it) {
  network.certificate = {};
  network.hand_written = true;
  write();
  EXPECT_EQ(refusal(), "twin.toml:7: network: " + configured.path +
                           " is hand-written and has no certificate; allow_uncertified = true runs it nevertheless");
  configured.allow_uncertified = true;
  EXPECT_EQ(refusal(), "");
}

TEST_F(LoadNetwork, only_what_a_trusted_key_has_signed_where_that_is_required) {
  const rom::PrivateKey ours = rom::make_private_key(), theirs = rom::make_private_key();
  configured.require_signature = true;
  configured.trusted_keys = {rom::public_key(ours)};
  write();
  EXPECT_NE(refusal().find("x.rom is not signed, and require_signature asks for it"), std::string::npos) << refusal();
  rom::sign_file(configured.path, theirs);
  EXPECT_NE(refusal().find("is signed by " + rom::to_hex(rom::public_key(theirs)) + ", which is not among"),
            std::string::npos)
      << refusal();
  rom::sign_file(configured.path, ours);
  EXPECT_EQ(refusal(), "");
  EXPECT_EQ(load_network(configured).signed_by, rom::public_key(ours));
}

TEST_F(LoadNetwork, damage_and_unknown_versions_are_the_files_own_errors) {
  write();
  const std::vector<std::uint8_t> good = rom::read_whole_file(configured.path, 1u << 20);
  std::vector<std::uint8_t> bytes = good;
  bytes[60] ^= 4;
  rom::write_whole_file(configured.path, bytes);
  EXPECT_EQ(refusal(), configured.path + ": payload: damaged: its SHA-256 is not the header's");
  bytes = good;
  bytes[8] = 7;
  rom::write_whole_file(configured.path, bytes);
  EXPECT_EQ(refusal(), configured.path + ": format version: 7 is unknown; this program reads 1 and 2");
}

/// The line `network = "x.rom"` of a configuration that is otherwise whole.
Config with_network(const std::string& line, const std::string& path = "/etc/twin.toml") {
  return parse_config(line + R"(
[serve]
[start]
temperature_degC = 20.0
[signals]
speed = { source = "plc" }
load = { source = "plc" }
coolant = { source = "constant", value = 20.0 }
ambient = { source = "constant", value = 20.0 }
)",
                      path);
}

std::string config_error(const std::string& line) {
  try {
    with_network(line);
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "";
}

TEST_F(LoadNetwork, the_configuration_names_a_file_or_says_more) {
  EXPECT_EQ(with_network("network = \"x.rom\"").network.path, "/etc/x.rom");
  EXPECT_FALSE(with_network("network = \"x.rom\"").network.allow_uncertified);
  EXPECT_TRUE(with_network("network = { file = \"x.rom\", allow_uncertified = true }").network.allow_uncertified);
  const rom::PublicKey key = rom::public_key(rom::make_private_key());
  rom::write_public_key(key, folder.file("a.pub"));
  const Config config =
      with_network("network = { file = \"x.rom\", require_signature = true, trusted_keys = [\"a.pub\", \"" +
                       rom::to_hex(key) + "\"] }",
                   folder.file("twin.toml"));
  EXPECT_TRUE(config.network.require_signature);
  EXPECT_EQ(config.network.path, configured.path);
  EXPECT_EQ(config.network.trusted_keys, (std::vector<rom::PublicKey>{key, key}));
}

TEST_F(LoadNetwork, a_wrong_configuration_is_one_error_with_its_line) {
  EXPECT_EQ(config_error("network = { file = \"x.rom\", require_signature = true }"),
            "/etc/twin.toml:1: network.trusted_keys: at least one key is needed where require_signature is true");
  EXPECT_EQ(config_error("network = { file = \"x.rom\", trusted_keys = [\"abc\"] }"),
            "/etc/twin.toml:1: network.trusted_keys: every entry must be 64 hex digits or a .pub file, is \"abc\"");
  EXPECT_EQ(config_error("network = { path = \"x.rom\" }").substr(0, 34), "/etc/twin.toml:1: network.file: th");
  EXPECT_EQ(config_error("network = 3"), "/etc/twin.toml:1: network: must be a string, is an integer");
}

}  // namespace config_load_network_test
}  // namespace spindle_twin::firmware
