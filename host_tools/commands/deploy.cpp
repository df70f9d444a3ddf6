#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host_tools/commands/commands.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/signature.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"

// spindle-twin deploy X.rom SLOT [--key factory.key]
// spindle-twin deploy X.rom HOST:SLOT [--key factory.key]
namespace spindle_twin::host_tools {
namespace {

struct DeployOptions {
  std::string network, where, key;
};

/// The network as it goes into the slot: checked whole, and signed. The file itself stays as it is.
std::vector<std::uint8_t> signed_bytes(const DeployOptions& options) {
  const std::string& path = options.network;
  std::vector<std::uint8_t> bytes = rom::read_whole_file(path, rom::rom_largest_file_bytes);
  const rom::RomFile file = rom::decode_rom_file(bytes, path);
  if (file.network.certificate.cases == 0 && !file.network.hand_written) {
    throw rom::InputError({path, 0}, "certificate",
                          "there is none, so no daemon runs it; `spindle-twin build` measures one");
  }
  if (!options.key.empty()) {
    bytes = rom::sign_bytes(std::move(bytes), rom::read_private_key(options.key));
  } else if (!file.signed_by) {
    throw rom::InputError({path, 0}, "signature",
                          "there is none, and a daemon takes none without; --key NAME.key signs what is deployed");
  }
  return bytes;
}

/// What a remote shell takes for nothing but a name.
void check_plain(const std::string& text, const std::string& field) {
  const bool is_plain =
      !text.empty() && text.front() != '-' && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) != 0 || std::strchr("._-/@", c) != nullptr;
      });
  if (is_plain) return;
  throw rom::InputError({"spindle-twin deploy", 0}, field,
                        "is \"" + text + "\"; allowed are letters, digits and . _ - / @, no '-' at the beginning");
}

/// The bytes as a file without a name, from its beginning.
int as_input(const std::vector<std::uint8_t>& bytes) {
  const int file = memfd_create("network", MFD_CLOEXEC);
  std::size_t done = 0;
  while (file >= 0 && done < bytes.size()) {
    const ssize_t n = write(file, bytes.data() + done, bytes.size() - done);
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  if (file < 0 || done < bytes.size() || lseek(file, 0, SEEK_SET) != 0) {
    throw rom::InputError({"spindle-twin deploy", 0}, "",
                          std::string("no memory for the network: ") + std::strerror(errno));
  }
  return file;
}

/// `ssh HOST COMMAND` with the bytes as its input; its exit code.
int run_ssh(const std::string& host, const std::string& command, const std::vector<std::uint8_t>& bytes) {
  const int input = as_input(bytes);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
  std::array<std::string, 3> words{"ssh", host, command};
  std::array<char*, 4> arguments{words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "ssh", &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(input);
  if (failed != 0) {
    throw rom::InputError({host, 0}, "ssh", std::string("cannot be run: ") + std::strerror(failed));
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Beside its name, compared with its hash, synced, then renamed: a cut connection leaves nothing that counts.
void deploy_by_ssh(const std::string& host, const std::string& slot, const std::string& name,
                   const std::vector<std::uint8_t>& bytes) {
  check_plain(host, "HOST");
  check_plain(slot, "DIR");
  check_plain(name, "name of the network file");
  const std::string target = slot + "/" + name;
  const std::string part = target + std::string(rom::unfinished_mark) + std::to_string(getpid());
  const std::string command = "cat > " + part + " && echo '" +
                              rom::sha256_hex({reinterpret_cast<const char*>(bytes.data()), bytes.size()}) + "  " +
                              part + "' | sha256sum -c --status && sync " + part + " && mv -f " + part + " " + target +
                              " || { rm -f " + part + "; exit 1; }";
  const int code = run_ssh(host, command, bytes);
  if (code != 0) {
    throw rom::InputError({host + ":" + target, 0}, "ssh",
                          "ended with " + std::to_string(code) + "; nothing has changed in the slot");
  }
}

void deploy(const DeployOptions& options) {
  const std::string name = std::filesystem::path(options.network).filename().string();
  if (!name.ends_with(".rom") || name.starts_with("accepted-") || name.starts_with("previous-")) {
    throw rom::InputError({options.network, 0}, "name",
                          "must end in .rom and not begin with accepted- or previous-, which are the daemon's own");
  }
  const std::vector<std::uint8_t> bytes = signed_bytes(options);
  const std::size_t colon = options.where.find(':');
  if (colon != std::string::npos && options.where.find('/') > colon) {
    deploy_by_ssh(options.where.substr(0, colon), options.where.substr(colon + 1), name, bytes);
  } else if (std::filesystem::is_directory(options.where)) {
    rom::write_whole_file((std::filesystem::path(options.where) / name).string(), bytes);
  } else {
    throw rom::InputError({options.where, 0}, "SLOT", "is no folder; allowed are a folder, or HOST:FOLDER by ssh");
  }
  const rom::RomFile file = rom::decode_rom_file(bytes, options.network);
  std::printf(
      "%s: SHA-256 %s, signed by %s, is in %s; the daemon's log and the registers from 1700 on say what becomes "
      "of it\n",
      options.network.c_str(), file.sha256.c_str(), rom::to_hex(*file.signed_by).c_str(), options.where.c_str());
}

}  // namespace

void add_deploy(CLI::App& app) {
  CLI::App* command = app.add_subcommand("deploy", "Put a signed network into the slot of a daemon that runs");
  const auto options = std::make_shared<DeployOptions>();
  command->add_option("network", options->network, "network file, .rom")->required();
  command->add_option("where", options->where, "the slot's folder, or HOST:FOLDER by ssh")->required();
  command->add_option("--key", options->key, "private key, .key, to sign what is deployed; else the file is signed");
  command->callback([options] { deploy(*options); });
}

}  // namespace spindle_twin::host_tools
