#pragma once

#include "firmware/config/config.hpp"
#include "rom/file/rom_file.hpp"

namespace spindle_twin::firmware {

/// A file that the configuration names, and whose signature fits it.
struct SignedFile {
  std::string path;
  std::optional<rom::PublicKey> signed_by;
  rom::SourceLine where;  ///< of the key that names it
  std::string field;
};

/// Throws rom::InputError with place, file and reason where signatures are required of the network, and so of what
/// changes its predictions, and this file has none of a trusted key.
void check_signature(const ConfiguredNetwork& configured, const SignedFile& file);

/// Reads the configured file and accepts it or not. Throws rom::InputError, with one reason: whatever the file itself
/// is refused for (damage, unknown version, a signature that does not fit); no signature, or one by a key that is not
/// trusted, where one is required; no certificate, unless the network is hand-written, says so, and the configuration
/// allows it.
rom::RomFile load_network(const ConfiguredNetwork& configured);

}  // namespace spindle_twin::firmware
