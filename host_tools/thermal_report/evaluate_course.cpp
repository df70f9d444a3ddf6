#include "host_tools/thermal_report/evaluate_course.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr double shortest_constant_s = 10.0, longest_in_spans = 5.0;
constexpr double at_border = 0.01;  // of ln τ
constexpr std::size_t least_readings = 8;
constexpr double longest_unread_share = 1.0 / 6.0;
constexpr double clear_swing = 5.0;  // times what is left
constexpr int sections = 60;

struct Readings {
  std::vector<double> time_s, value;
};

Readings between(const Course& course, double from_s, double until_s) {
  Readings found;
  for (std::size_t i = 0; i < course.time_s.size(); ++i) {
    if (course.time_s[i] < from_s || course.time_s[i] > until_s) continue;
    found.time_s.push_back(course.time_s[i]);
    found.value.push_back(course.value[i]);
  }
  return found;
}

/// Whether readings follow each other, from the first instant to the last.
bool cover(const Readings& readings, double from_s, double until_s) {
  const double longest_s = longest_unread_share * (until_s - from_s);
  double read_s = from_s;
  for (const double time_s : readings.time_s) {
    if (time_s - read_s > longest_s) return false;
    read_s = time_s;
  }
  return until_s - read_s <= longest_s;
}

/// Straight line through value over 1 − e^(−t/τ).
TimeConstant at_constant(const Readings& readings, double from_s, double constant_s) {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  const auto form = [&](double time_s) { return -std::expm1(-(time_s - from_s) / constant_s); };
  for (std::size_t i = 0; i < readings.value.size(); ++i) {
    const double e = form(readings.time_s[i]);
    n += 1.0;
    x += e;
    y += readings.value[i];
    xx += e * e;
    xy += e * readings.value[i];
  }
  const double spread = xx - x * x / n;
  const double swing = spread > 0.0 ? (xy - x * y / n) / spread : 0.0;
  const double first = (y - swing * x) / n;
  double squares = 0.0;
  for (std::size_t i = 0; i < readings.value.size(); ++i) {
    squares += std::pow(readings.value[i] - first - swing * form(readings.time_s[i]), 2.0);
  }
  return {constant_s, swing, std::sqrt(squares / n)};
}

}  // namespace

std::optional<Drift> drift_between(const Course& course, double from_s, double until_s) {
  const Readings readings = between(course, from_s, until_s);
  if (readings.value.size() < 2 || !cover(readings, from_s, until_s)) return {};
  const auto [lowest, highest] = std::minmax_element(readings.value.begin(), readings.value.end());
  const double change = readings.value.back() - readings.value.front();
  const double hours = (readings.time_s.back() - readings.time_s.front()) / rom::seconds_per_hour;
  return Drift{readings.value.size(), *highest - *lowest, change, change / hours};
}

std::optional<double> steepest_per_h(const Course& course, double from_s, double until_s, double span_s) {
  const Readings readings = between(course, from_s, until_s);
  std::optional<double> steepest;
  for (std::size_t begin = 0, end = 0; begin < readings.value.size(); ++begin) {
    while (end < readings.value.size() && readings.time_s[end] - readings.time_s[begin] < span_s) ++end;
    if (end == readings.value.size()) break;
    const double hours = (readings.time_s[end] - readings.time_s[begin]) / rom::seconds_per_hour;
    const double rate = std::abs(readings.value[end] - readings.value[begin]) / hours;
    steepest = std::max(steepest.value_or(0.0), rate);
  }
  return steepest;
}

std::optional<TimeConstant> fit_time_constant(const Course& course, double from_s, double until_s) {
  const Readings readings = between(course, from_s, until_s);
  if (readings.value.size() < least_readings || !cover(readings, from_s, until_s)) return {};
  const double lowest = std::log(shortest_constant_s);
  const double highest = std::log(longest_in_spans * (until_s - from_s));
  if (highest <= lowest) return {};
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double low = lowest, high = highest;
  const auto rms_at = [&](double logarithm) { return at_constant(readings, from_s, std::exp(logarithm)).rms; };
  std::array<double, 2> inner{high - golden * (high - low), low + golden * (high - low)};
  std::array<double, 2> rms{rms_at(inner[0]), rms_at(inner[1])};
  for (int section = 0; section < sections; ++section) {
    if (rms[0] < rms[1]) {
      high = inner[1];
      inner = {high - golden * (high - low), inner[0]};
      rms = {rms_at(inner[0]), rms[0]};
    } else {
      low = inner[0];
      inner = {inner[1], low + golden * (high - low)};
      rms = {rms[1], rms_at(inner[1])};
    }
  }
  const double found = 0.5 * (low + high);
  if (found - lowest < at_border || highest - found < at_border) return {};
  const TimeConstant fitted = at_constant(readings, from_s, std::exp(found));
  if (std::abs(fitted.swing) < clear_swing * fitted.rms) return {};
  return fitted;
}

}  // namespace spindle_twin::host_tools
