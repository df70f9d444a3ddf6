#include "host_tools/commands/offline/accuracy_options.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <vector>

namespace spindle_twin::host_tools {
namespace {

constexpr double part_maximum_share = 6.0;

[[noreturn]] void refuse(const std::string& text) {
  throw CLI::ValidationError("'" + text + "' is not of the form 0.05K,0.03um or 0.05K,0.03um,0.3K, all above 0");
}

/// The number before `unit`, which ends the piece.
double number(std::string_view piece, std::string_view unit, const std::string& text) {
  if (!piece.ends_with(unit)) refuse(text);
  piece.remove_suffix(unit.size());
  double value = 0.0;
  const auto [stop, error] = std::from_chars(piece.data(), piece.data() + piece.size(), value);
  if (error != std::errc() || stop != piece.data() + piece.size() || !std::isfinite(value) || value <= 0.0) {
    refuse(text);
  }
  return value;
}

}  // namespace

fem_offline::Tolerance parse_tolerance(const std::string& text) {
  std::vector<std::string_view> pieces;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    pieces.push_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (pieces.size() < 2 || pieces.size() > 3) refuse(text);
  fem_offline::Tolerance tolerance;
  tolerance.key_points_K = number(pieces[0], "K", text);
  tolerance.deformations_um = number(pieces[1], "um", text);
  tolerance.part_max_K =
      pieces.size() == 3 ? number(pieces[2], "K", text) : part_maximum_share * tolerance.key_points_K;
  return tolerance;
}

fem_offline::ParameterBox named_box(const std::string& name, double reference_speed_rpm) {
  fem_offline::ParameterBox box;
  if (name == "small") {
    box.contact_low = 0.3;
    box.contact_high = 3.0;
    box.film_low = 0.5;
    box.film_high = 2.0;
  }
  box.speed_high_rpm = std::max(box.speed_high_rpm, 4.0 / 3.0 * reference_speed_rpm);
  return box;
}

}  // namespace spindle_twin::host_tools
