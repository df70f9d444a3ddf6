#pragma once

#include <limits>
#include <string>

namespace spindle_twin::rom {

/// Allowed interval of a number. Every number must be finite besides.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_excluded = false;
  bool max_excluded = false;
};

inline constexpr Range any_number{};
inline constexpr Range positive{0.0, std::numeric_limits<double>::infinity(), true, false};
inline constexpr Range not_negative{0.0, std::numeric_limits<double>::infinity(), false, false};
constexpr Range between(double min, double max) { return {min, max, false, false}; }

/// Whether a number is finite and in the range.
bool is_allowed(Range range, double value);
/// "a number from 0 (excluded) to 1": the range in words, for messages. Not in the cycle (heap), nor is printed().
std::string allowed(Range range);
/// A number as messages show it.
std::string printed(double value);

}  // namespace spindle_twin::rom
