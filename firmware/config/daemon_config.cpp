#include "firmware/config/daemon_config.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <utility>

#include "firmware/config/read_files.hpp"
#include "firmware/config/read_served.hpp"

namespace spindle_twin::firmware {
namespace {

using rom::TomlTable;

constexpr std::size_t most_spindles = 32;
constexpr int last_unit = 247;  // those above are reserved, MODBUS over Serial Line 2.2

DaemonConfig of_one(const std::string& path) {
  ConfiguredSpindle spindle{"", 1, read_config(path)};
  DaemonConfig daemon{spindle.config.log_level, spindle.config.serve, spindle.config.show, spindle.config.plant, {}};
  daemon.spindles.push_back(std::move(spindle));
  return daemon;
}

/// What two spindles must not have in common, with who has it.
class Taken {
 public:
  void take(const std::string& thing, const std::string& who, const TomlTable& table, const std::string& key) {
    const auto [entry, is_new] = owners_.try_emplace(thing, who);
    if (!is_new) table.fail(key, thing + " is that of \"" + entry->second + "\" already; each spindle needs its own");
  }
  /// A file that is only read, by several if they like. The words for it, "the network of left".
  void read(const std::string& file, const std::string& words) { readers_.try_emplace(one_way_to(file), words); }
  /// Whose it is that would be written over; empty: nobody's.
  std::string reader_of(const std::string& file) const {
    const auto reader = readers_.find(one_way_to(file));
    return reader == readers_.end() ? std::string() : reader->second;
  }

 private:
  std::map<std::string, std::string> owners_, readers_;
};

/// For a path of HTTP, a label and a line of the log.
std::string read_name(const TomlTable& table) {
  std::string name = table.string("name");
  const bool is_plain = std::all_of(name.begin(), name.end(),
                                    [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
  constexpr std::size_t longest = 32;
  if (name.empty() || name.size() > longest || !is_plain) {
    table.fail("name", "must be 1 to 32 letters, digits, '_' or '-', is \"" + name + "\"");
  }
  return name;
}

ConfiguredSpindle read_one(const TomlTable& table, const std::string& list, Listeners& listeners, Taken& taken) {
  ConfiguredSpindle spindle;
  spindle.name = read_name(table);
  taken.take("the name " + spindle.name, spindle.name, table, "name");
  spindle.unit = static_cast<int>(table.integer("unit", 1, last_unit));
  taken.take("unit " + std::to_string(spindle.unit), spindle.name, table, "unit");
  const std::string path = beside(list, table.string("config"));
  check_is_there(path, table.where("config"), table.path("config"));
  spindle.config = read_config_of_one(TomlTable::read(path), path, list, listeners);
  for (const std::string& file : state_files(spindle.config)) {
    taken.take("the file " + one_way_to(file), spindle.name, table, "config");
  }
  for (const FileRead& file : files_read(spindle.config)) taken.read(file.path, file.what + " of " + spindle.name);
  return spindle;
}

/// What one spindle writes, no other reads, nor all together.
void check_written(const std::vector<TomlTable>& tables, const DaemonConfig& daemon, const Taken& taken) {
  for (std::size_t s = 0; s < tables.size(); ++s) {
    for (const std::string& file : state_files(daemon.spindles[s].config)) {
      std::string reader = taken.reader_of(file);
      if (reader.empty()) continue;
      tables[s].fail("config", "its file \"" + file + "\" is " + reader.append(", which would be written over"));
    }
  }
}

DaemonConfig of_several(const TomlTable& root, const std::string& path) {
  DaemonConfig daemon;
  daemon.log_level = read_log_level(root);
  Listeners listeners;
  const TomlTable serve = root.table("serve");
  if (serve.has("plc_timeout_s")) {
    serve.fail("plc_timeout_s", "is of each spindle and stands in [serve] of its own file");
  }
  daemon.serve = read_serve(serve, path, listeners);
  daemon.show = read_http(root, path, listeners);
  daemon.plant = read_plant(root.optional_table("plant"), path);
  Taken taken;
  taken.read(path, "the list of spindles");
  for (const FileRead& file : files_read(daemon.serve, daemon.show, daemon.plant)) taken.read(file.path, file.what);
  const std::vector<TomlTable> tables = root.tables("spindle");
  for (const TomlTable& table : tables) {
    if (daemon.spindles.size() == most_spindles) table.fail("name", "is one too many; at most 32 spindles are allowed");
    daemon.spindles.push_back(read_one(table, path, listeners, taken));
  }
  check_written(tables, daemon, taken);
  root.finish();
  return daemon;
}

}  // namespace

std::vector<std::string> state_files(const Config& config) {
  std::vector<std::string> files;
  for (const std::string& path :
       {config.keep.orders_path, config.keep.checkpoint_path, config.history.path, config.keep.parameters_path}) {
    if (!path.empty()) files.push_back(path);
  }
  if (!config.exchange.slot.empty()) files.push_back(config.exchange.slot + "/exchange");
  return files;
}

std::vector<rom::InputError> unwritable_files(const Config& config) {
  std::vector<rom::InputError> found;
  for (const std::string& file : state_files(config)) {
    std::string folder = std::filesystem::path(file).parent_path().string();
    if (folder.empty()) folder = ".";
    if (access(folder.c_str(), W_OK | X_OK) == 0) continue;
    const int reason = errno;
    found.emplace_back(rom::SourceLine{config.path, 0}, file,
                       "could not be written by this user, its folder: " + std::string(std::strerror(reason)));
  }
  return found;
}

DaemonConfig read_daemon_config(const std::string& path) {
  const TomlTable root = TomlTable::read(path);
  return root.has("spindle") ? of_several(root, path) : of_one(path);
}

}  // namespace spindle_twin::firmware
