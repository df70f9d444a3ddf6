#include "correction/growth/judge_growth.hpp"

#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace spindle_twin::correction {
namespace {

constexpr std::size_t least_readings = 3;
constexpr double least_growth_m = 1e-6;
constexpr double standard_errors = 2.0;
constexpr double week_s = 7.0 * 86400.0;
constexpr double monday_s = 4.0 * 86400.0;  ///< 5 January 1970

/// One reading against the first of its stretch and origin.
struct Grown {
  double unix_s, growth_m, left_m, published_m;
};

/// Steps: the first reading of each stretch and origin is the reference of the others.
std::vector<Grown> grown_since_first(std::span<const GrowthReading> readings, std::optional<bool> only_compensated) {
  std::map<std::pair<std::size_t, ReadingOrigin>, const GrowthReading*> first;
  std::vector<Grown> grown;
  for (const GrowthReading& reading : readings) {
    const bool compensated = reading.origin == ReadingOrigin::by_hand_compensated;
    if (only_compensated && *only_compensated != compensated) continue;
    const auto [known, is_first] = first.try_emplace({reading.stretch, reading.origin}, &reading);
    if (is_first) continue;
    const double measured_m = reading.measured_m - known->second->measured_m;
    const double published_m = reading.predicted_m - known->second->predicted_m;
    grown.push_back({reading.unix_s, compensated ? published_m : measured_m,
                     compensated ? measured_m : measured_m - published_m, published_m});
  }
  return grown;
}

void keep_worst(double value, double& worst) {
  if (std::abs(value) > std::abs(worst)) worst = value;
}

/// From the mean of with² − without² and its standard error.
Verdict verdict_of(const std::vector<double>& differences) {
  const auto count = static_cast<double>(differences.size());
  if (differences.size() < least_readings) return Verdict::too_few;
  double mean = 0.0, squares = 0.0;
  for (const double difference : differences) mean += difference / count;
  for (const double difference : differences) squares += (difference - mean) * (difference - mean);
  const double error = standard_errors * std::sqrt(squares / (count - 1.0) / count);
  if (mean > error) return Verdict::makes_worse;
  return mean < -error ? Verdict::helps : Verdict::not_told;
}

/// Least squares through zero of `value` over what was published.
std::optional<double> slope_over_published(const std::vector<Grown>& grown, double Grown::*value) {
  double published_squares = 0.0, products = 0.0;
  for (const Grown& each : grown) {
    published_squares += each.published_m * each.published_m;
    products += each.*value * each.published_m;
  }
  const auto count = static_cast<double>(grown.size());
  if (grown.size() < least_readings || published_squares < count * least_growth_m * least_growth_m) return {};
  return products / published_squares;
}

}  // namespace

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::helps:
      return "helps";
    case Verdict::makes_worse:
      return "makes it worse";
    case Verdict::not_told:
      return "cannot be told";
    default:
      return "too few readings";
  }
}

GrowthJudgement judge_growth(std::span<const GrowthReading> readings, double from_s, double to_s) {
  GrowthJudgement judged;
  std::vector<double> differences;
  for (const Grown& grown : grown_since_first(readings, std::nullopt)) {
    if (grown.unix_s < from_s || grown.unix_s >= to_s) continue;
    judged.growth_rms_m += grown.growth_m * grown.growth_m;
    judged.left_rms_m += grown.left_m * grown.left_m;
    keep_worst(grown.growth_m, judged.growth_worst_m);
    keep_worst(grown.left_m, judged.left_worst_m);
    differences.push_back(grown.left_m * grown.left_m - grown.growth_m * grown.growth_m);
  }
  judged.readings = differences.size();
  if (judged.readings == 0) return judged;
  judged.growth_rms_m = std::sqrt(judged.growth_rms_m / static_cast<double>(judged.readings));
  judged.left_rms_m = std::sqrt(judged.left_rms_m / static_cast<double>(judged.readings));
  judged.verdict = verdict_of(differences);
  return judged;
}

std::optional<double> applied_scale(std::span<const GrowthReading> readings) {
  const auto slope = slope_over_published(grown_since_first(readings, true), &Grown::left_m);
  if (!slope) return std::nullopt;
  return 1.0 - *slope;
}

std::optional<double> measured_times(std::span<const GrowthReading> readings) {
  return slope_over_published(grown_since_first(readings, false), &Grown::growth_m);
}

std::vector<GrowthWeek> judge_weeks(std::span<const GrowthReading> readings) {
  std::set<double> numbers;
  for (const GrowthReading& reading : readings) numbers.insert(std::floor((reading.unix_s - monday_s) / week_s));
  std::vector<GrowthWeek> weeks;
  for (const double number : numbers) {
    const double from_s = monday_s + number * week_s;
    const GrowthJudgement judged = judge_growth(readings, from_s, from_s + week_s);
    if (judged.readings > 0) weeks.push_back({from_s, judged});
  }
  return weeks;
}

AppliedAs applied_as(std::optional<double> scale) {
  constexpr double near = 0.25, too_small = 0.5, too_large = 1.5;
  if (!scale) return AppliedAs::not_told;
  if (std::abs(*scale - 1.0) <= near) return AppliedAs::as_published;
  if (std::abs(*scale + 1.0) <= near) return AppliedAs::wrong_sign;
  if (std::abs(*scale) <= near) return AppliedAs::not_at_all;
  return *scale > too_large || *scale < too_small ? AppliedAs::wrong_scale : AppliedAs::not_told;
}

}  // namespace spindle_twin::correction
