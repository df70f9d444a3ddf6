#pragma once

#include <stdexcept>

namespace spindle_twin::rom {

/// Throws std::invalid_argument: what a caller within the program did wrong, not what a file or a person did
/// (InputError).
inline void require(bool condition, const char* message) {
  if (!condition) throw std::invalid_argument(message);
}

}  // namespace spindle_twin::rom
