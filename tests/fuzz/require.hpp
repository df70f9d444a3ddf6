#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace spindle_twin::firmware {

/// What must hold whatever a fuzzer makes up. Throws std::logic_error with the law that does not.
inline void require(bool condition, std::string_view law) {
  if (!condition) throw std::logic_error(std::string(law));
}

}  // namespace spindle_twin::firmware
