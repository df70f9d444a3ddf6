#pragma once

#include <string>
#include <vector>

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// `path`, relative to the folder of the configuration.
std::string beside(const std::string& config_path, const std::string& path);

/// However a path is written, and whether the file is there yet or not.
std::string one_way_to(const std::string& path);

/// Throws rom::InputError at the key that names it where there is no such file.
void check_is_there(const std::string& path, const rom::SourceLine& where, const std::string& field);

/// [history], [orders] and [checkpoint]: the files that the daemon writes. None may be another of them, nor one of
/// files_read(), which are known by now. Throws rom::InputError with file, line, field and what is allowed.
void read_files(const rom::TomlTable& root, Config& config);

/// A file that the daemon reads and what it is, "the network".
struct FileRead {
  std::string path;
  std::string what;
};

/// Of one spindle: its configuration, network and calibration.
std::vector<FileRead> files_read(const Config& config);

/// Of all spindles: certificates, keys and accounts.
std::vector<FileRead> files_read(const ServePlan& serve, const ShowPlan& show, const PlantPlan& plant);

}  // namespace spindle_twin::firmware
