#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "correction/growth/growth_reading.hpp"

namespace spindle_twin::correction {

enum class Verdict { too_few, helps, not_told, makes_worse };

/// "too few readings", "helps", "cannot be told", "makes it worse".
const char* name_of(Verdict verdict);

/// What a control seems to do with the compensation, from how what is left goes with what was published.
enum class AppliedAs { as_published, not_at_all, wrong_sign, wrong_scale, not_told };

/// Growth with and without compensation over some readings, each against the first of its stretch and origin, m.
struct GrowthJudgement {
  std::size_t readings = 0;  ///< without the first ones
  double growth_rms_m = 0.0, growth_worst_m = 0.0;
  double left_rms_m = 0.0, left_worst_m = 0.0;  ///< with compensation; worst with its sign
  Verdict verdict = Verdict::too_few;
};

/// without: L_i − L_0; with: (L_i − p_i) − (L_0 − p_0). Of compensated readings e nobody knows what the control did:
/// without is what was published, p_i − p_0, with e_i − e_0. `helps` and `makes_worse` where the mean of with² −
/// without² lies more than two standard errors from 0; fewer than three readings are too few. `from_s` to `to_s`
/// counts; references may lie before.
GrowthJudgement judge_growth(std::span<const GrowthReading> readings, double from_s, double to_s);

struct GrowthWeek {
  double from_unix_s = 0.0;  ///< Monday, 0:00 UTC
  GrowthJudgement judged;
};

/// The same of each week that has readings beside first ones, in their order.
std::vector<GrowthWeek> judge_weeks(std::span<const GrowthReading> readings);

/// How many times the published growth was measured: the slope of growth over published, least squares through the
/// first readings; of readings that were not compensated. 1: a right prediction, −1: one of the two has the wrong sign,
/// 0: they have nothing in common. Empty: fewer than three, or hardly any published growth (below 1 um rms).
std::optional<double> measured_times(std::span<const GrowthReading> readings);

/// How many times the published value the control applies: 1 − slope of what is left over what was published, least
/// squares through the first readings; of compensated readings only. Empty: fewer than three, or hardly any growth
/// (below 1 um rms).
std::optional<double> applied_scale(std::span<const GrowthReading> readings);

/// Within a quarter of 1 as published, of −1 the wrong sign, of 0 not at all; any other one beyond 1.5 or below 0.5, a
/// negative one too, a wrong scale; else, and without a scale, not told.
AppliedAs applied_as(std::optional<double> scale);

}  // namespace spindle_twin::correction
