#pragma once

#include <string_view>

#include "rom/range.hpp"

namespace spindle_twin::rom {

/// A number or switch that a person may set, declared once. A struct of options has
///   template <class Options, class Visit> static void each(Options& options, Visit&& visit)
/// which calls visit(Option, member) for every double, int or bool, members at their defaults. Configurations are read
/// and options checked by it (rom/read/options.hpp), and a test holds the commented example to it.
struct Option {
  std::string_view key;       ///< in a configuration; in the member's unit
  std::string_view doc;       ///< for the commented example
  Range range = any_number;   ///< of what is written; a switch has none
  bool or_zero = false;       ///< 0 switches it off; otherwise at least 1e-9, so that a covariance can hold it
  double written_as_0 = 0.0;  ///< the member where 0 is written: 0 degC in kelvin
};

/// A standard deviation or the like: none at all, or one that a covariance can hold, up to `most`.
constexpr Option zero_or_some(std::string_view key, std::string_view doc, double most) {
  return {key, doc, between(0.0, most), true};
}

inline constexpr double least_but_zero = 1e-9;

}  // namespace spindle_twin::rom
