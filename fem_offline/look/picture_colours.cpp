#include "fem_offline/look/picture_colours.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace spindle_twin::fem_offline {
namespace {

double encoded(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

double decoded(double value) { return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4); }

/// Linear light; outside 0 to 1 where the screen has no such colour.
std::array<double, 3> linear_from_oklab(double lightness, double a, double b) {
  const double l = std::pow(lightness + 0.3963377774 * a + 0.2158037573 * b, 3.0);
  const double m = std::pow(lightness - 0.1055613458 * a - 0.0638541728 * b, 3.0);
  const double s = std::pow(lightness - 0.0894841775 * a - 1.2914855480 * b, 3.0);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

struct ControlPoint {
  double chroma;
  double hue_degrees;
};
constexpr std::array<ControlPoint, 5> control_points{
    {{0.12, 300.0}, {0.12, 262.0}, {0.10, 200.0}, {0.16, 152.0}, {0.18, 106.0}}};
constexpr double darkest = 0.28, lightest = 0.93;

}  // namespace

Colour from_oklch(double lightness, double chroma, double hue_degrees) {
  const double hue = hue_degrees * std::numbers::pi / 180.0;
  for (double kept = chroma;; kept -= 0.002) {
    const double used = std::max(kept, 0.0);
    const auto linear = linear_from_oklab(lightness, used * std::cos(hue), used * std::sin(hue));
    const auto [least, most] = std::minmax_element(linear.begin(), linear.end());
    if (kept > 0.0 && (*least < 0.0 || *most > 1.0)) continue;
    const auto shown = [&](int c) { return encoded(std::clamp(linear[static_cast<std::size_t>(c)], 0.0, 1.0)); };
    return {shown(0), shown(1), shown(2), 1.0};
  }
}

double lightness_of(const Colour& colour) {
  const double r = decoded(colour.red), g = decoded(colour.green), b = decoded(colour.blue);
  return 0.2104542553 * std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b) +
         0.7936177850 * std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b) -
         0.0040720468 * std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
}

Colour field_colour(double share) {
  const double at = std::clamp(share, 0.0, 1.0);
  const double scaled = at * static_cast<double>(control_points.size() - 1);
  const auto from = std::min(static_cast<std::size_t>(scaled), control_points.size() - 2);
  const double t = scaled - static_cast<double>(from);
  const ControlPoint &a = control_points[from], &b = control_points[from + 1];
  return from_oklch(darkest + at * (lightest - darkest), (1.0 - t) * a.chroma + t * b.chroma,
                    (1.0 - t) * a.hue_degrees + t * b.hue_degrees);
}

Colour part_colour(std::size_t part) {
  constexpr double golden_angle_degrees = 137.508;
  const double number = static_cast<double>(part);
  return from_oklch(part % 2 == 0 ? 0.90 : 0.84, 0.065, 60.0 + golden_angle_degrees * number);
}

}  // namespace spindle_twin::fem_offline
