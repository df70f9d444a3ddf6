#include "tests/bench/reality/pooled.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::bench {
namespace {

constexpr double long_failed_s = 600.0;

}  // namespace

Pooled pool(const Scores& scores, const std::string& family, const Scores& also, const std::string& also_family) {
  Pooled sum;
  for (const auto& [key, score] : scores) {
    if (key.first != family || !also.contains({also_family, key.second})) continue;
    ++sum.runs;
    sum.error_um += score.error_um * score.error_um;
    sum.deviation_um += score.deviation_um * score.deviation_um;
    sum.open_um += score.open_um * score.open_um;
    sum.inside += score.inside;
    sum.least_inside = std::min(sum.least_inside, score.inside);
    sum.inside_from_1_min += score.inside_from_1_min;
    sum.rejected += score.rejected;
    sum.worst_um = std::max(sum.worst_um, score.worst_um);
    sum.failed_s = std::max(sum.failed_s, score.failed_s);
    sum.degraded_s = std::max(sum.degraded_s, score.degraded_s);
    sum.step_um_per_s = std::max(sum.step_um_per_s, score.step_um_per_s);
    sum.back_s = std::max(sum.back_s, score.back_s);
    sum.at_15_min_um = std::max(sum.at_15_min_um, std::abs(score.at_15_min_um));
    sum.with_failed += score.failed_s > 0.0 ? 1 : 0;
    sum.with_failed_at_end += score.failed_at_end_s > long_failed_s ? 1 : 0;
    sum.ends_degraded += score.ends_degraded ? 1 : 0;
  }
  const double runs = std::max(1, sum.runs);
  for (double* rms : {&sum.error_um, &sum.deviation_um, &sum.open_um}) *rms = std::sqrt(*rms / runs);
  for (double* mean : {&sum.inside, &sum.inside_from_1_min, &sum.rejected}) *mean /= runs;
  return sum;
}

}  // namespace spindle_twin::bench
