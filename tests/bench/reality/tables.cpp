#include "tests/bench/reality/tables.hpp"

#include <algorithm>
#include <cstdio>

#include "tests/bench/reality/pooled.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double slew_um_per_s = 0.5;  // the daemon's default
constexpr double least_sharpness_nominal = 0.65;
constexpr double least_sharpness = 0.4;
constexpr double rounding = 1e-6;

/// Prints limits as they are judged.
class Limits {
 public:
  void most(const std::string& what, double value, double limit) { line(what, value, "<=", limit, value <= limit); }
  void least(const std::string& what, double value, double limit) { line(what, value, ">=", limit, value >= limit); }
  void open(const std::string& what) {
    std::printf("  %-66s        -        not run\n", what.c_str());
    ++open_;
  }
  int missed() const { return missed_; }
  void sum_up() const { std::printf("%d kept, %d missed, %d not run\n", kept_, missed_, open_); }

 private:
  void line(const std::string& what, double value, const char* sign, double limit, bool kept) {
    (kept ? kept_ : missed_) += 1;
    std::printf("  %-66s %8.3f %s %-8.3g%s\n", what.c_str(), value, sign, limit, kept ? "" : "  MISSED");
  }
  int kept_ = 0, missed_ = 0, open_ = 0;
};

void judge_error(const Family& family, const ErrorLimit& limit, const Scores& scores, const Scores& present,
                 Limits& limits) {
  const std::string& base = nominal_family().name;
  switch (limit.of) {
    case Measure::present: {
      const Pooled own = pool(scores, family.name, present, family.name);
      const Pooled other = pool(present, family.name, scores, family.name);
      const std::string what = family.name + ": error / present";
      if (own.runs > 0) return limits.most(what, own.error_um / other.error_um, limit.most);
      return limits.open(what);
    }
    case Measure::nominal: {
      const Pooled own = pool(scores, family.name, scores, base);
      const Pooled other = pool(scores, base, scores, family.name);
      const std::string what = family.name + ": error / nominal of the same seeds";
      if (own.runs > 0) return limits.most(what, own.error_um / other.error_um, limit.most);
      return limits.open(what);
    }
    case Measure::open_loop: {
      const Pooled own = pool(scores, family.name);
      return limits.most(family.name + ": error / open loop", own.error_um / own.open_um, limit.most);
    }
  }
}

void judge_family(const Family& family, const Scores& scores, const Scores& present, Limits& limits) {
  const Pooled own = pool(scores, family.name);
  for (const ErrorLimit& limit : family.error_limits) judge_error(family, limit, scores, present, limits);
  if (family.least_inside > 0.0) limits.least(family.name + ": inside", own.inside, family.least_inside);
  if (family.least_inside_of_a_run > 0.0) {
    limits.least(family.name + ": inside, worst run", own.least_inside, family.least_inside_of_a_run);
  }
  const bool is_nominal = family.name == nominal_family().name;
  limits.least(family.name + ": error / published deviation", own.error_um / own.deviation_um,
               is_nominal ? least_sharpness_nominal : least_sharpness);
  if (is_nominal) limits.most("nominal: time not running, s (no reset fires)", own.degraded_s, 0.0);
  if (family.truth == TruthKind::warm) {
    limits.most(family.name + ": error 15 min after the first reading, um, worst run", own.at_15_min_um, 2.0);
    limits.least(family.name + ": inside from the first minute on", own.inside_from_1_min, family.least_inside);
  }
  if (family.truth == TruthKind::flow) {
    limits.most(family.name + ": back inside after, s, worst run", own.back_s, 600.0);
  }
}

double ratio(double value, double of) { return of > 0.0 ? value / of : 0.0; }

}  // namespace

void print_run(const std::string& family, const RealityScore& score) {
  std::printf(
      "  %-18s %llu: %6.2f um of sd %5.2f, open %6.2f, worst %6.2f, inside %.3f, from 1 min %.3f, at 15 min %6.2f, "
      "failed %5.0f s (at end %5.0f), not running %5.0f s%s, quality %u, fault %u, step %.3f, rejected %.4f, back "
      "%4.0f "
      "s\n",
      family.c_str(), static_cast<unsigned long long>(score.seed), score.error_um, score.deviation_um, score.open_um,
      score.worst_um, score.inside, score.inside_from_1_min, score.at_15_min_um, score.failed_s, score.failed_at_end_s,
      score.degraded_s, score.ends_degraded ? ", ends degraded" : "", score.quality_at_end, score.faults,
      score.step_um_per_s, score.rejected, score.back_s);
  std::fflush(stdout);
}

void print_families(const std::vector<Family>& families, const Scores& scores, const Scores& present) {
  std::printf(
      "\nNose from 15 min on. present: the filter before, same seeds; rms/sd: error over published deviation;\n");
  std::printf("failed: runs in which a healthy sensor failed, the longest; not running: longest of a run.\n");
  std::printf("%-18s %-8s %4s %7s %7s %7s %8s %8s %7s %7s %7s %6s %6s %7s %8s %8s %8s %8s\n", "family", "priors",
              "runs", "rms um", "open", "present", "/present", "/nominal", "inside", "worst", "pr.ins.", "rms/sd",
              "failed", "longest", "not run.", "deg.ends", "rejected", "back s");
  for (const Family& family : families) {
    const Pooled own = pool(scores, family.name);
    if (own.runs == 0) continue;
    const Pooled before = pool(present, family.name, scores, family.name);
    const Pooled common = pool(scores, family.name, present, family.name);
    const Pooled base = pool(scores, nominal_family().name, scores, family.name);
    const Pooled beside_base = pool(scores, family.name, scores, nominal_family().name);
    std::printf(
        "%-18s %-8s %4d %7.2f %7.2f %7.2f %8.2f %8.2f %7.3f %7.3f %7.3f %6.2f %6d %7.0f %8.0f %8d %8.4f %8.0f\n",
        family.name.c_str(), family.inside_priors ? "inside" : "outside", own.runs, own.error_um, own.open_um,
        before.error_um, ratio(common.error_um, before.error_um), ratio(beside_base.error_um, base.error_um),
        own.inside, own.least_inside, before.inside, ratio(own.error_um, own.deviation_um), own.with_failed,
        own.failed_s, own.degraded_s, own.ends_degraded, own.rejected, own.back_s);
  }
}

int print_reality_limits(const std::vector<Family>& families, const Scores& scores, const Scores& present) {
  Limits limits;
  std::printf("\nLimits:\n");
  int failed_at_end = 0, degraded = 0, lag_failed = 0;
  double step_um_per_s = 0.0;
  for (const Family& family : families) {
    const Pooled own = pool(scores, family.name);
    if (own.runs == 0) continue;
    judge_family(family, scores, present, limits);
    failed_at_end += own.with_failed_at_end;
    degraded += family.must_run ? own.ends_degraded : 0;
    lag_failed += family.lag_s > 0.0 ? own.with_failed : 0;
    step_um_per_s = std::max(step_um_per_s, own.step_um_per_s);
  }
  limits.most("runs that end with a healthy sensor failed for over 10 min", failed_at_end, 0);
  limits.most("healthy runs that end degraded", degraded, 0);
  limits.most("runs with lag in which a sensor failed", lag_failed, 0);
  limits.most("fastest change of the published nose, um/s", step_um_per_s, slew_um_per_s + rounding);
  limits.sum_up();
  return limits.missed();
}

int print_short_limits(const std::vector<Family>& families, const Scores& scores) {
  Limits limits;
  std::printf("\nLimits of the short run:\n");
  for (const Family& family : families) {
    const Pooled own = pool(scores, family.name);
    if (own.runs == 0) continue;
    limits.most(family.name + ": fastest change of the published nose, um/s", own.step_um_per_s,
                slew_um_per_s + rounding);
    limits.most(family.name + ": largest error, um", own.worst_um, 50.0);
  }
  const Pooled base = pool(scores, nominal_family().name);
  limits.least("nominal: inside", base.inside, 0.8);
  limits.most("nominal: error / published deviation", base.error_um / base.deviation_um, 2.0);
  limits.most("nominal: runs in which a sensor failed", base.with_failed, 0);
  limits.sum_up();
  return limits.missed();
}

int print_pairs(const std::vector<Family>& families, const Scores& scores, const Unplugging& unplugging) {
  constexpr double apart_K = 0.6;     // twice the least jump of correction/health/limits.hpp: below, courses are alike
  constexpr double at_once_s = 20.0;  // two updates
  std::printf(
      "\nA pair a spindle, unplugged for %g s until %g s, back %s; differ: by %g K then; at once: within %g s\n",
      unplugging.for_s, Unplugging::back_s, unplugging.exchanged ? "exchanged" : "in their own places", apart_K,
      at_once_s);
  std::printf("%-18s %6s %7s %8s %6s %8s\n", "family", "pairs", "differ", "at once", "later", "longest");
  int all = 0, all_at_once = 0, taken_for_exchanged = 0;
  for (const Family& family : families) {
    if (family.run_s <= Unplugging::back_s) continue;
    int pairs = 0, differ = 0, at_once = 0, later = 0;
    double longest_s = 0.0;
    for (const auto& [key, score] : scores) {
      if (key.first != family.name) continue;
      ++pairs;
      if (score.pair_swapped_s >= 0.0) ++taken_for_exchanged;
      if (score.pair_apart_K < apart_K) continue;
      ++differ;
      if (score.pair_swapped_s < 0.0) continue;
      ++(score.pair_swapped_s <= at_once_s ? at_once : later);
      longest_s = std::max(longest_s, score.pair_swapped_s);
    }
    std::printf("%-18s %6d %7d %8d %6d %6.0f s\n", family.name.c_str(), pairs, differ, at_once, later, longest_s);
    all += differ;
    all_at_once += at_once;
  }
  Limits limits;
  if (!unplugging.exchanged) {
    limits.most("pairs put back right that are taken for exchanged", taken_for_exchanged, 0);
  } else if (all > 0) {
    limits.least("exchanged pairs that differ, found at once", static_cast<double>(all_at_once) / all, 0.8);
  }
  limits.sum_up();
  return limits.missed();
}

}  // namespace spindle_twin::bench
