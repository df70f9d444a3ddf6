#pragma once

#include <string>

#include "firmware/config/config.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::firmware {

/// `path`, relative to the folder of the configuration.
std::string beside(const std::string& config_path, const std::string& path);

/// [history], [orders] and [checkpoint]: the files that the daemon writes. Throws rom::InputError with file, line,
/// field and what is allowed.
void read_files(const rom::TomlTable& root, Config& config);

}  // namespace spindle_twin::firmware
