#include "tests/bench/faults/tables.hpp"

#include <algorithm>
#include <cstdio>
#include <map>

namespace spindle_twin::bench {
namespace {

constexpr double slew_um_per_s = 0.5;

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return -1.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// What all runs with one kind of fault gave.
struct Row {
  int runs = 0, found = 0, late = 0, false_alarms = 0, twice = 0, beyond = 0, repaired = 0, returned = 0, harmless = 0;
  double inside = 0.0;
  double worst_until_found = 0.0;
  double step_um = 0.0, raw_step_um = 0.0;
  std::vector<double> delay_s, withheld_s, error_um, reference_um, ratio;

  void note(const Followed& run, const Followed& reference, double cycle_s) {
    ++runs;
    if (run.delay_s >= 0.0) {
      ++found;
      delay_s.push_back(run.delay_s);
    }
    if (run.withheld_s >= 0.0) withheld_s.push_back(run.withheld_s);
    late += is_late(run, cycle_s) ? 1 : 0;
    false_alarms += run.false_alarms;
    inside += run.inside_until_found;
    worst_until_found = std::max(worst_until_found, run.largest_until_found);
    step_um = std::max(step_um, run.step_um);
    raw_step_um = std::max(raw_step_um, run.raw_step_um);
    error_um.push_back(run.error_um);
    reference_um.push_back(reference.error_um);
    ratio.push_back(run.error_um / reference.error_um);
    if (run.error_um > 2.0 * reference.error_um) {
      ++twice;
      // Without the sensor nobody could have asked for less than what it leaves open.
      if (run.error_um > reference.deviation_um) ++beyond;
    }
    if (run.fault.until_s < 1e17 && run.delay_s >= 0.0) {
      ++repaired;
      returned += run.returned_s >= 0.0 ? 1 : 0;
    }
  }

  /// Whether the fault was found later than it must be.
  static bool is_late(const Followed& run, double cycle_s) {
    switch (run.fault.kind) {
      case FaultKind::open:
      case FaultKind::shorted:
      case FaultKind::out_of_range:
      case FaultKind::jump:
        return run.delay_s < 0.0 || run.delay_s > 3.0 * cycle_s + 1e-9;
      case FaultKind::stuck:
        return run.moving_s >= 0.0 && run.fault.from_s + run.moving_s + 120.0 < std::min(run_s, run.fault.until_s) &&
               (run.delay_s < 0.0 || run.delay_s > run.moving_s + 120.0);
      default:
        return false;
    }
  }
};

void print_row(const char* name, const Row& row) {
  std::printf(
      "%-16s %5d %6d %5d %8.0f %8.0f %8.0f %8.2f %8.2f %6.2f %7.2f %6d %6d %7.3f %7.2f %6d %6.2f %6.2f %4d/%-4d\n",
      name, row.runs, row.found, row.late, quantile(row.delay_s, 0.5), quantile(row.delay_s, 1.0),
      quantile(row.withheld_s, 0.5), quantile(row.error_um, 0.5), quantile(row.reference_um, 0.5),
      quantile(row.ratio, 0.5), quantile(row.ratio, 1.0), row.twice, row.beyond, row.inside / std::max(1, row.runs),
      row.worst_until_found, row.false_alarms, row.step_um, row.raw_step_um, row.returned, row.repaired);
}

void print_head(const char* first) {
  std::printf("%-16s %5s %6s %5s %8s %8s %8s %8s %8s %6s %7s %6s %6s %7s %7s %6s %6s %6s %9s\n", first, "runs", "found",
              "late", "med s", "max s", "held s", "um", "ref um", "x", "worst x", "> 2x", "& >sd", "in 2sd", "err/sd",
              "false", "step", "raw", "returned");
}

const char* place_of(int sensor) {
  constexpr std::array places{"rear sleeve", "rear sleeve", "rear sleeve", "front seat", "winding", "jacket"};
  return places[static_cast<std::size_t>(sensor)];
}

}  // namespace

void print_run(std::uint64_t seed, const Followed& run) {
  std::printf(
      "  %llu %-12s sensor %d partner %d from %5.0f size %5.2f K rate %6.2f K/h: found %6.0f s as %d, %6.3f um "
      "(sd %.3f), in 2sd until then %.2f, moving after %.0f, false %d, withheld %d, step %.2f raw %.2f\n",
      static_cast<unsigned long long>(seed), name_of(run.fault.kind), run.fault.sensor, run.fault.partner,
      run.fault.from_s, run.fault.size_K, 3600.0 * run.fault.rate_K_per_s, run.delay_s, static_cast<int>(run.named),
      run.error_um, run.deviation_um, run.inside_until_found, run.moving_s, run.false_alarms, run.withheld, run.step_um,
      run.raw_step_um);
  std::fflush(stdout);
}

int print_tables(const std::vector<SpindleRuns>& all, double cycle_s) {
  std::map<FaultKind, Row> kinds;
  std::map<std::pair<double, std::string>, Row> drifts;
  Row swapped_for_one;
  std::vector<double> sd_growth, error_growth;
  double inside = 0.0, inside_unwatched = 0.0;
  int healthy_alarms = 0;
  long healthy_withheld = 0;
  double step_um = 0.0;
  for (const SpindleRuns& runs : all) {
    const Followed* reference = nullptr;
    const Followed* without_both = nullptr;
    const Followed& healthy = runs.followed.front();
    sd_growth.push_back(healthy.deviation_um / runs.unwatched.deviation_um);
    error_growth.push_back(healthy.error_um / runs.unwatched.error_um);
    inside += healthy.inside_until_found / static_cast<double>(all.size());
    inside_unwatched += runs.unwatched.inside_until_found / static_cast<double>(all.size());
    for (const Followed& run : runs.followed) {
      step_um = std::max(step_um, run.step_um);
      if (run.fault.kind == FaultKind::none || run.fault.is_reference()) {
        healthy_alarms += run.false_alarms;
        healthy_withheld += run.fault.kind == FaultKind::none ? run.withheld : 0;
        if (run.fault.kind == FaultKind::withdrawn) reference = &run;
        if (run.fault.kind == FaultKind::withdrawn_pair) without_both = &run;
      } else if (run.fault.kind == FaultKind::drift) {
        drifts[{std::abs(3600.0 * run.fault.rate_K_per_s), place_of(run.fault.sensor)}].note(run, *reference, cycle_s);
      } else if (run.fault.kind == FaultKind::swapped) {
        kinds[run.fault.kind].note(run, *without_both, cycle_s);
        swapped_for_one.note(run, *reference, cycle_s);
      } else {
        kinds[run.fault.kind].note(run, *reference, cycle_s);
      }
    }
  }
  const auto spindles = static_cast<double>(all.size());
  std::printf("\nHealthy: %d channels failed without a fault; %.4f %% of the readings withheld\n", healthy_alarms,
              100.0 * static_cast<double>(healthy_withheld) / (spindles * 6.0 * run_s / cycle_s));
  std::printf("Nose watched, of that unwatched: standard deviation x %.3f (median), %.3f (worst); error x %.3f, %.3f\n",
              quantile(sd_growth, 0.5), quantile(sd_growth, 1.0), quantile(error_growth, 0.5),
              quantile(error_growth, 1.0));
  std::printf("Truth inside 2 standard deviations: %.3f of the time, unwatched %.3f\n", inside, inside_unwatched);
  std::printf(
      "\nNose from the fault on; reference: the same run, the sensor withdrawn at that moment, of swapped ones "
      "both.\n");
  print_head("fault");
  int late = 0, missed = 0, beyond = 0;
  double outside = 0.0;
  for (const auto& [kind, row] : kinds) {
    print_row(name_of(kind), row);
    late += row.late;
    if (kind != FaultKind::swapped && kind != FaultKind::stuck) missed += row.runs - row.found;
    beyond += row.beyond;
  }
  if (swapped_for_one.runs > 0) print_row("swapped, one out", swapped_for_one);
  if (!drifts.empty()) {
    std::printf("\nDrift from 900 s on, K/h\n");
    print_head("rate, sensor");
    for (const auto& [key, row] : drifts) {
      char name[40];
      std::snprintf(name, sizeof name, "%4.1f %s", key.first, key.second.c_str());
      print_row(name, row);
      outside = std::max(outside, 1.0 - row.inside / std::max(1, row.runs));
    }
  }
  int limits_missed = 0;
  const auto limit = [&](const char* what, double value, double most) {
    limits_missed += value <= most ? 0 : 1;
    std::printf("  %-72s %8.3f <= %g%s\n", what, value, most, value <= most ? "" : "   MISSED");
  };
  std::printf("\nLimits:\n");
  limit("healthy channels that failed", healthy_alarms, 0);
  limit("electrical faults, jumps (4 samples), stuck (2 min of movement) found late", late, 0);
  limit("electrical faults, jumps, spikes not found", missed, 0);
  limit("nose error beyond twice the reference's and beyond its standard deviation", beyond, 0);
  limit("share of the time until a drift is found with the truth beyond 2 sd, worst", outside, 0.07);
  limit("largest change of the published nose, um/s", step_um / cycle_s, slew_um_per_s + 1e-9);
  return limits_missed;
}

int print_exchanges(const std::vector<SpindleRuns>& all) {
  struct PairRow {
    int runs = 0, found = 0, otherwise = 0;
    std::vector<double> delay_s, error_um;
  };
  std::map<std::string, PairRow> rows;
  int healthy = 0, false_alarms = 0, put_back = 0;
  for (const SpindleRuns& runs : all) {
    for (const Followed& run : runs.followed) {
      false_alarms += run.false_alarms;
      const bool is_healthy = run.fault.kind == FaultKind::none || run.fault.kind == FaultKind::replugged;
      healthy += is_healthy ? run.false_alarms : 0;
      put_back += run.fault.kind == FaultKind::replugged ? 1 : 0;
      if (is_healthy) continue;
      const std::string pair = std::string(place_of(run.fault.sensor)) + ", " + place_of(run.fault.partner);
      for (PairRow* row : {&rows[pair], &rows["~all"]}) {
        ++row->runs;
        row->error_um.push_back(run.error_um);
        if (run.named == firmware::SensorFault::swapped) {
          ++row->found;
          row->delay_s.push_back(run.delay_s);
        } else if (run.delay_s >= 0.0) {
          ++row->otherwise;
        }
      }
    }
  }
  std::printf("; found as something else: the first of the two failed, but not as swapped\n");
  std::printf("%-26s %5s %6s %10s %8s %8s %9s %9s\n", "pair", "runs", "found", "otherwise", "med s", "max s", "med um",
              "worst um");
  for (const auto& [pair, row] : rows) {
    std::printf("%-26s %5d %6d %10d %8.0f %8.0f %9.2f %9.2f\n", pair.c_str(), row.runs, row.found, row.otherwise,
                quantile(row.delay_s, 0.5), quantile(row.delay_s, 1.0), quantile(row.error_um, 0.5),
                quantile(row.error_um, 1.0));
  }
  std::printf("\nHealthy channels that failed: %d on %zu healthy spindles and %d times put back right, %d in all\n",
              healthy, all.size(), put_back, false_alarms);
  return healthy;
}

}  // namespace spindle_twin::bench
