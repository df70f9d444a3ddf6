#include "firmware/config/load_network.hpp"

#include <algorithm>

#include "firmware/config/read_files.hpp"

namespace spindle_twin::firmware {

void check_signature(const ConfiguredNetwork& configured, const SignedFile& file) {
  if (!configured.require_signature) return;
  if (!file.signed_by) {
    throw rom::InputError(file.where, file.field,
                          file.path + " is not signed, and require_signature asks for it; `spindle-twin sign`");
  }
  const auto& keys = configured.trusted_keys;
  if (std::find(keys.begin(), keys.end(), *file.signed_by) == keys.end()) {
    throw rom::InputError(
        file.where, file.field,
        file.path + " is signed by " + rom::to_hex(*file.signed_by) + ", which is not among the trusted_keys");
  }
}

namespace {

void check_certificate(const ConfiguredNetwork& configured, const rom::RomFile& file) {
  if (file.network.certificate.cases > 0) return;
  if (!file.network.hand_written) {
    throw rom::InputError(
        configured.where, configured.field,
        configured.path + " carries no certificate, so its error is unknown; `spindle-twin build` measures one");
  }
  if (!configured.allow_uncertified) {
    throw rom::InputError(
        configured.where, configured.field,
        configured.path + " is hand-written and has no certificate; allow_uncertified = true runs it nevertheless");
  }
}

}  // namespace

rom::RomFile load_network(const ConfiguredNetwork& configured) {
  check_is_there(configured.path, configured.where, configured.field);
  rom::RomFile file = rom::read_rom_file(configured.path);
  check_signature(configured, {configured.path, file.signed_by, configured.where, configured.field});
  check_certificate(configured, file);
  return file;
}

}  // namespace spindle_twin::firmware
