#pragma once

#include <string>

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// `path`, relative to the folder of the configuration.
std::string beside(const std::string& config_path, const std::string& path);

/// However a path is written, and whether the file is there yet or not.
std::string one_way_to(const std::string& path);

/// [history], [orders] and [checkpoint]: the files that the daemon writes. None may be another of them, nor one that it
/// reads: the configuration, the network and the calibration, which are known by now. Throws rom::InputError with file,
/// line, field and what is allowed.
void read_files(const rom::TomlTable& root, Config& config);

}  // namespace spindle_twin::firmware
