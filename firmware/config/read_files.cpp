#include "firmware/config/read_files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <map>
#include <system_error>

#include "firmware/keep/sqlite_history.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

using rom::TomlTable;

/// Whose each file is.
class FileOwners {
 public:
  explicit FileOwners(const Config& config) {
    for (const FileRead& file : files_read(config)) owners_[one_way_to(file.path)] = file.what;
    for (const FileRead& file : files_read(config.serve, config.show, config.plant)) {
      owners_[one_way_to(file.path)] = file.what;
    }
  }
  void take(const std::string& path, const TomlTable& table, const std::string& key) {
    const auto [owner, is_new] = owners_.try_emplace(one_way_to(path), table.path(key));
    if (!is_new) table.fail(key, "\"" + path + "\" is " + owner->second + ", which would be written over");
    const std::string lock = path + ".lock";
    const auto [taken, is_own] = owners_.try_emplace(one_way_to(lock), "the lock file of " + table.path(key));
    if (!is_own) table.fail(key, "needs \"" + lock + "\" as its lock file, which is " + taken->second);
  }

 private:
  std::map<std::string, std::string> owners_;
};

/// A file that the daemon writes.
void take_state_file(const std::string& path, const TomlTable& table, const std::string& key, FileOwners& owners) {
  std::error_code unknown;
  const auto status = std::filesystem::status(path, unknown);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    table.fail(key, "\"" + path + "\" exists and is not a regular file");
  }
  if (unknown.value() == ENAMETOOLONG) table.fail(key, "is longer than a file's path may be");
  owners.take(path, table, key);
}

/// The same, relative to the configuration's folder.
std::string read_state_file(const TomlTable& table, const std::string& key, const std::string& config_path,
                            FileOwners& owners) {
  const std::string name = table.string(key);
  if (name.empty()) table.fail(key, "must name a file, is empty");
  std::string path = beside(config_path, name);
  take_state_file(path, table, key, owners);
  return path;
}

HistoryPlan read_history(const TomlTable& table, const std::string& config_path, FileOwners& owners) {
  constexpr double bytes_per_MiB = 1048576.0;
  const auto in_MiB = [](std::uint64_t bytes) { return static_cast<double>(bytes) / bytes_per_MiB; };
  HistoryPlan plan;
  plan.path = read_state_file(table, "path", config_path, owners);
  const bool is_sqlite = is_sqlite_path(plan.path);
  const double segment_MiB =
      is_sqlite ? 8.0 : table.number_or("segment_MiB", in_MiB(plan.segment_bytes), rom::between(0.01, 1e5));
  const double most_MiB = table.number_or("most_MiB", std::max(in_MiB(plan.most_bytes), 2.0 * segment_MiB),
                                          rom::between(2.0 * segment_MiB, 1e7));
  plan.segment_bytes = static_cast<std::uint64_t>(segment_MiB * bytes_per_MiB);
  plan.most_bytes = static_cast<std::uint64_t>(most_MiB * bytes_per_MiB);
  if (is_sqlite) plan.most_days = table.number_or("most_days", plan.most_days, rom::between(0.01, 36500.0));
  if (is_sqlite && table.has("segment_MiB")) table.fail("segment_MiB", "is of CSV files only; path ends in .sqlite");
  if (!is_sqlite && table.has("most_days")) table.fail("most_days", "needs a path that ends in .sqlite");
  return plan;
}

}  // namespace

std::string beside(const std::string& config_path, const std::string& path) {
  return (std::filesystem::path(config_path).parent_path() / path).lexically_normal().string();
}

std::string one_way_to(const std::string& path) {
  std::error_code unknown;
  const std::filesystem::path way =
      std::filesystem::weakly_canonical(std::filesystem::absolute(path, unknown), unknown);
  return unknown ? path : way.string();
}

void check_is_there(const std::string& path, const rom::SourceLine& where, const std::string& field) {
  std::error_code unknown;
  if (!std::filesystem::exists(path, unknown)) throw rom::InputError(where, field, "there is no file \"" + path + "\"");
}

std::vector<FileRead> files_read(const Config& config) {
  std::vector<FileRead> files{{config.path, "the configuration"}, {config.network.path, "the network"}};
  if (config.calibration) files.push_back({config.calibration->path, "the calibration"});
  for (const std::string& key : config.network.key_files) files.push_back({key, "one of the trusted_keys"});
  return files;
}

std::vector<FileRead> files_read(const ServePlan& serve, const ShowPlan& show, const PlantPlan& plant) {
  std::vector<FileRead> files;
  if (serve.tls) {
    files.push_back({serve.tls->certificate, "serve.tls.certificate"});
    files.push_back({serve.tls->key, "serve.tls.key"});
    files.push_back({serve.tls->clients_ca, "serve.tls.clients_ca"});
    if (!serve.tls->revoked.empty()) files.push_back({serve.tls->revoked, "serve.tls.revoked"});
  }
  if (plant.tls) {
    files.push_back({plant.tls->ca, "plant.tls.ca"});
    files.push_back({plant.tls->certificate, "plant.tls.certificate"});
    files.push_back({plant.tls->key, "plant.tls.key"});
  }
  if (show.commands) files.push_back({show.commands->accounts_path, "http.commands.accounts"});
  return files;
}

void read_files(const TomlTable& root, Config& config) {
  const std::string& path = config.path;
  FileOwners owners(config);
  if (const auto history = root.optional_table("history")) {
    config.history = read_history(*history, path, owners);
    if (history->has("parameters")) config.keep.parameters_path = read_state_file(*history, "parameters", path, owners);
  }
  const auto orders = root.optional_table("orders");
  const std::string beside_config = std::filesystem::path(path).replace_extension(".orders").string();
  config.keep.orders_path = orders ? read_state_file(*orders, "path", path, owners) : beside_config;
  if (const auto checkpoint = root.optional_table("checkpoint")) {
    KeepPlan& keep = config.keep;
    keep.checkpoint_path = read_state_file(*checkpoint, "path", path, owners);
    if (!orders) keep.orders_path = keep.checkpoint_path + ".orders";
    keep.interval_s = checkpoint->number_or("interval_s", keep.interval_s, rom::between(1.0, 86400.0));
    keep.max_age_s = rom::seconds_per_hour * checkpoint->number_or("max_age_h", keep.max_age_s / rom::seconds_per_hour,
                                                                   rom::between(0.0, 8760.0));
  }
  if (!orders) take_state_file(config.keep.orders_path, root, "orders", owners);
}

}  // namespace spindle_twin::firmware
