#pragma once

#include "firmware/config/config.hpp"
#include "rom/file/rom_file.hpp"

namespace spindle_twin::firmware {

/// Reads the configured file and accepts it or not. Throws rom::InputError, with one reason: whatever the file itself
/// is refused for (damage, unknown version, a signature that does not fit); no signature, or one by a key that is not
/// trusted, where one is required; no certificate, unless the network is hand-written, says so, and the configuration
/// allows it.
rom::RomFile load_network(const ConfiguredNetwork& configured);

}  // namespace spindle_twin::firmware
