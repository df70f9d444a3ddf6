#pragma once

#include <CLI/App.hpp>
#include <string>

namespace spindle_twin::host_tools {

/// A number from `smallest` to `largest`; unlike CLI::Range it refuses nan.
inline CLI::Validator finite_range(double smallest, double largest, const std::string& shown) {
  return {[=](std::string& text) {
            double value = 0.0;
            const bool inside = CLI::detail::lexical_cast(text, value) && value >= smallest && value <= largest;
            return inside ? std::string() : "'" + text + "' is not a number from " + shown;
          },
          shown};
}

}  // namespace spindle_twin::host_tools
