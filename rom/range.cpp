#include "rom/range.hpp"

#include <cmath>
#include <sstream>

namespace spindle_twin::rom {

std::string printed(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::string allowed(Range range) {
  const bool low = std::isfinite(range.min), high = std::isfinite(range.max);
  if (low && high) {
    return "a number from " + printed(range.min) + (range.min_excluded ? " (excluded)" : "") + " to " +
           printed(range.max) + (range.max_excluded ? " (excluded)" : "");
  }
  if (low) return "a number " + std::string(range.min_excluded ? "above " : "of at least ") + printed(range.min);
  if (high) return "a number " + std::string(range.max_excluded ? "below " : "of at most ") + printed(range.max);
  return "a finite number";
}

bool is_allowed(Range range, double value) {
  return std::isfinite(value) && (range.min_excluded ? value > range.min : value >= range.min) &&
         (range.max_excluded ? value < range.max : value <= range.max);
}

}  // namespace spindle_twin::rom
