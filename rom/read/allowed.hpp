#pragma once

#include <string>

#include "rom/range.hpp"

namespace spindle_twin::rom {

/// A number as messages show it.
std::string printed(double value);
/// "a number from 0 (excluded) to 1": the range in words, for messages.
std::string allowed(Range range);
/// Whether a number is finite and in the range.
bool is_allowed(Range range, double value);

}  // namespace spindle_twin::rom
