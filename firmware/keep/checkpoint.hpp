#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/cycle/remember.hpp"
#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {

/// What a cycle remembers, of which network, and when.
struct Checkpoint {
  std::string network_sha256;
  double saved_unix_s = 0.0;
  Remembered remembered;             ///< without `parameters`, which the estimator's state has in it
  std::uint32_t order_revision = 0;  ///< how many orders were on the disk then
  BootTime saved = {};               ///< its time within the boot; without a name in checkpoints of before
};

inline constexpr std::uint64_t largest_checkpoint_bytes = std::uint64_t{1} << 26;

/// A line that names the format and the SHA-256 of what follows, then the payload of keep/checkpoint.proto (nanopb).
std::vector<std::uint8_t> encode_checkpoint(const Checkpoint& checkpoint);

/// Throws rom::InputError naming `file` for anything that encode_checkpoint did not write: another format, damaged by a
/// single bit, cut.
Checkpoint decode_checkpoint(const std::vector<std::uint8_t>& bytes, const std::string& file);

/// Whole or not at all. Throws rom::InputError with the system's reason.
void write_checkpoint(const Checkpoint& checkpoint, const std::string& path);

/// Empty where there is no file. Throws rom::InputError for one that cannot be used.
std::optional<Checkpoint> read_checkpoint(const std::string& path);

}  // namespace spindle_twin::firmware
