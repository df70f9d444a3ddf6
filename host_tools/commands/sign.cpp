#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "correction/calibration/calibration.hpp"
#include "host_tools/commands/commands.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/signature.hpp"
#include "rom/read/input_error.hpp"

// spindle-twin keys new factory            writes factory.key and factory.pub
// spindle-twin sign X.rom --key factory.key                 or X.calibration
// spindle-twin verify-signature X.rom --key factory.pub
namespace spindle_twin::host_tools {
namespace {

/// A folder gets keys of a standard name.
std::string key_name(const std::string& name) {
  return std::filesystem::is_directory(name) ? (std::filesystem::path(name) / "spindle-twin").string() : name;
}

void make_keys(const std::string& where) {
  const std::string name = key_name(where);
  if (std::filesystem::exists(name + ".pub")) {
    throw rom::InputError({name + ".pub", 0}, "", "cannot be written: File exists");
  }
  const rom::PrivateKey key = rom::make_private_key();
  rom::write_private_key(key, name + ".key");
  rom::write_public_key(rom::public_key(key), name + ".pub");
  std::printf("%s.key  private, for `spindle-twin sign`; keep it to yourself\n%s.pub  public, for trusted_keys: %s\n",
              name.c_str(), name.c_str(), rom::to_hex(rom::public_key(key)).c_str());
}

rom::PublicKey trusted_key(const std::string& text) {
  rom::PublicKey key{};
  return rom::parse_public_key(text, key) ? key : rom::read_public_key(text);
}

/// A network, or else a calibration.
std::optional<rom::PublicKey> signer_of_file(const std::string& path) {
  if (rom::is_rom_file(path)) return rom::read_rom_file(path).signed_by;
  return correction::read_calibration_file(path).signed_by;
}

void sign(const std::string& path, const rom::PrivateKey& key) {
  if (rom::is_rom_file(path)) return rom::sign_file(path, key);
  write_calibration(correction::read_calibration(path), path, &key);
}

void verify(const std::string& path, const std::vector<std::string>& trusted) {
  const std::optional<rom::PublicKey> signed_by = signer_of_file(path);
  if (!signed_by) throw rom::InputError({path, 0}, "signature", "there is none");
  const std::string signer = rom::to_hex(*signed_by);
  bool known = trusted.empty();
  for (const std::string& text : trusted) known = trusted_key(text) == *signed_by || known;
  if (!known) throw rom::InputError({path, 0}, "signature", "by " + signer + ", which is none of the keys given");
  std::printf("%s: signed by %s%s\n", path.c_str(), signer.c_str(),
              trusted.empty() ? "; whether that key is to be trusted, --key tells" : "");
}

}  // namespace

void add_keys(CLI::App& app) {
  CLI::App* command = app.add_subcommand("keys", "Make the keys that network files and calibrations are signed with");
  command->require_subcommand(1);
  const auto name = std::make_shared<std::string>();
  CLI::App* fresh = command->add_subcommand("new", "Write NAME.key (private) and NAME.pub (public); never over others");
  fresh->add_option("name", *name, "name with path, or a folder")->required();
  fresh->callback([name] { make_keys(*name); });
}

void add_sign(CLI::App& app) {
  struct SignOptions {
    std::string network, key;
  };
  CLI::App* command = app.add_subcommand("sign", "Sign a network file or a calibration, in place");
  const auto options = std::make_shared<SignOptions>();
  command->add_option("network", options->network, "network file, .rom, or .calibration")->required();
  command->add_option("--key", options->key, "private key, .key")->required();
  command->callback([options] {
    const rom::PrivateKey key = rom::read_private_key(options->key);
    sign(options->network, key);
    std::printf("%s: signed by %s\n", options->network.c_str(), rom::to_hex(rom::public_key(key)).c_str());
  });
}

void add_verify_signature(CLI::App& app) {
  struct SignOptions {
    std::string network;
    std::vector<std::string> keys;
  };
  CLI::App* command = app.add_subcommand("verify-signature", "Say who signed a network file or a calibration");
  const auto options = std::make_shared<SignOptions>();
  command->add_option("network", options->network, "network file, .rom, or .calibration")->required();
  command->add_option("--key", options->keys, "public keys that count, .pub files or 64 hex digits");
  command->callback([options] { verify(options->network, options->keys); });
}

}  // namespace spindle_twin::host_tools
