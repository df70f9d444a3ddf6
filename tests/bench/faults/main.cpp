#include <cmath>
#include <cstdio>

#include "tests/bench/campaign/models.hpp"
#include "tests/bench/campaign/options.hpp"
#include "tests/bench/campaign/results.hpp"
#include "tests/bench/faults/tables.hpp"

namespace spindle_twin::bench {
namespace {

constexpr int sensors = 6;
constexpr double earliest_s = 900.0;
constexpr double latest_s = 5400.0;
constexpr double repaired_after_s = 1200.0;
constexpr double replugged_s = 3600.0;
constexpr std::array rates_K_per_h{0.2, 0.5, 1.0, 2.0, 5.0, 10.0};
constexpr double short_rate_K_per_h = 5.0;

struct Options : CampaignOptions {
  int drift_runs = 4;
  double cycle_s = 1.0;
  bool healthy_only = false;
  bool drifts_only = false;
  bool swapped_from_start = false;
  bool replugged = false;
  Unplugged unplugged{300.0};
  bool only_swapped() const { return swapped_from_start || replugged; }
  bool verbose = false;
};

/// What is drawn for one sensor of one virtual spindle.
struct Drawn {
  Fault fault;  ///< sensor, partner and moment
  double sign = 1.0;
  double jump_K = 0.0;
  bool repaired = false;
};

Drawn draw(int sensor, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Drawn drawn;
  drawn.fault.sensor = sensor;
  drawn.fault.partner = (sensor + 1 + static_cast<int>(unit(random) * (sensors - 1))) % sensors;
  drawn.fault.from_s = std::floor(earliest_s + (latest_s - earliest_s) * unit(random));
  drawn.sign = unit(random) < 0.5 ? -1.0 : 1.0;
  drawn.jump_K = drawn.sign * (1.0 + 4.0 * unit(random));
  drawn.repaired = unit(random) < 0.5;
  return drawn;
}

/// All faults but drifts; before them the run in which the sensor is only withdrawn. Short: an open sensor stands for
/// the other electrical faults, which are found in the same sample.
void add_sudden(const Drawn& drawn, bool is_short, std::vector<Fault>& faults) {
  Fault fault = drawn.fault;
  fault.kind = FaultKind::withdrawn;
  faults.push_back(fault);
  for (const FaultKind kind : all_faults) {
    if (kind == FaultKind::drift) continue;
    if (is_short && (kind == FaultKind::shorted || kind == FaultKind::out_of_range)) continue;
    if (kind == FaultKind::swapped) {
      fault.kind = FaultKind::withdrawn_pair;
      fault.until_s = 1e18;
      faults.push_back(fault);
    }
    fault.kind = kind;
    fault.size_K = kind == FaultKind::spikes ? 5.0 * drawn.sign : drawn.jump_K;
    fault.until_s = drawn.repaired && kind != FaultKind::swapped ? fault.from_s + repaired_after_s : 1e18;
    faults.push_back(fault);
  }
}

void add_drifts(const Drawn& drawn, bool is_short, std::vector<Fault>& faults) {
  Fault fault = drawn.fault;
  fault.from_s = earliest_s;  // so that a slow one has time
  fault.kind = FaultKind::withdrawn;
  faults.push_back(fault);
  fault.kind = FaultKind::drift;
  for (const double rate_K_per_h : rates_K_per_h) {
    if (is_short && rate_K_per_h != short_rate_K_per_h) continue;
    fault.rate_K_per_s = drawn.sign * rate_K_per_h / 3600.0;
    faults.push_back(fault);
  }
}

/// The faults of one virtual spindle; first none.
std::vector<Fault> draw_faults(std::uint64_t seed, const Options& options, bool drifts) {
  std::mt19937_64 random(seed);
  std::vector<Fault> faults{{}};
  if (options.healthy_only) return faults;
  for (int sensor = 0; sensor < sensors; ++sensor) {
    const Drawn drawn = draw(sensor, random);
    if (options.is_short && sensor != static_cast<int>(seed % sensors)) continue;
    if (!options.drifts_only) add_sudden(drawn, options.is_short, faults);
    if (drifts) add_drifts(drawn, options.is_short, faults);
  }
  return faults;
}

/// The end of the first standstill for for_s that ends behind replugged_s; -1: there is none.
double stood_s(const Truth& truth, double for_s) {
  double stood = 0.0;
  for (std::size_t k = 0; k < truth.read.size(); ++k) {
    stood = truth.read[k].speed_rpm == 0.0 ? stood + sample_s : 0.0;
    const double end_s = static_cast<double>(k + 1) * sample_s;
    if (stood >= for_s && end_s >= replugged_s) return end_s;
  }
  return -1.0;
}

/// Every two sensors that differ by more than 1 K rms, exchanged from the start or while they were unplugged, and there
/// put back right as well; the healthy spindle first. None where the daemon is to be off while the spindle stands, and
/// it never stands for so long.
std::vector<Fault> all_exchanges(const Truth& truth, const Options& options) {
  constexpr double least_K = 1.0;
  std::vector<Fault> faults{{}};
  const double from_s = options.unplugged.daemon_off ? stood_s(truth, options.unplugged.for_s) : replugged_s;
  if (options.replugged && from_s < 0.0) return faults;
  const auto samples = static_cast<double>(truth.key_points_K.rows());
  for (int one = 0; one < sensors; ++one) {
    for (int other = one + 1; other < sensors; ++other) {
      const double difference_K = (truth.key_points_K.col(one) - truth.key_points_K.col(other)).norm();
      if (difference_K <= least_K * std::sqrt(samples)) continue;
      Fault fault;
      fault.kind = FaultKind::swapped;
      fault.sensor = one;
      fault.partner = other;
      if (options.replugged) {
        fault.from_s = from_s;
        fault.unplugged = options.unplugged;
        fault.kind = FaultKind::replugged;
        faults.push_back(fault);
        fault.kind = FaultKind::swapped;
      }
      faults.push_back(fault);
    }
  }
  return faults;
}

void print_how(const Options& options) {
  const Unplugged& unplugged = options.unplugged;
  if (!options.replugged) {
    std::printf("\nExchanged from the start");
    return;
  }
  std::printf("\nExchanged after an hour, while one was unplugged for %g s, the other for %g s, %s", unplugged.for_s,
              unplugged.for_s + unplugged.partner_later_s,
              unplugged.daemon_off   ? "the spindle at rest and the daemon off"
              : unplugged.reads_open ? "reading open"
                                     : "reading nothing");
}

int run(const Options& options) {
  const rom::Network network = twin_network(options.twin);
  const fem_offline::FeModel fe = model_of(options.truth_mm);
  std::printf("seed %llu, %d virtual spindles of 2 h, cycles of %g s, %zu nodes\n",
              static_cast<unsigned long long>(options.seed), options.runs, options.cycle_s, network.nodes.size());
  std::vector<SpindleRuns> all(static_cast<std::size_t>(options.runs));
  in_parallel(options.twin.threads, options.runs, [&](int i) {
    const HeatErrors heats = i % 2 == 0 ? HeatErrors::independent : HeatErrors::common;
    FollowOptions follow_options;
    follow_options.cycle_s = options.cycle_s;
    follow_options.priors = priors_of(heats);
    const correction::ParameterModel parameters(network, follow_options.priors);
    const std::uint64_t seed = seed_of(options, i / 2, heats);
    const Truth truth = cached_truth(options.twin.cache, fe.affine(), parameters, seed, heats);
    SpindleRuns& runs = all[static_cast<std::size_t>(i)];
    runs.seed = seed;
    if (!options.only_swapped()) {
      follow_options.with_health = false;
      runs.unwatched = follow(network, truth, {}, follow_options);
      follow_options.with_health = true;
    }
    const std::vector<Fault> faults =
        options.only_swapped() ? all_exchanges(truth, options) : draw_faults(seed, options, i < options.drift_runs);
    for (const Fault& fault : faults) {
      runs.followed.push_back(follow(network, truth, fault, follow_options));
      if (options.verbose) print_run(seed, runs.followed.back());
    }
    std::fprintf(stderr, "spindle %d of %d\n", i + 1, options.runs);
  });
  if (!options.only_swapped()) return print_tables(all, options.cycle_s);
  print_how(options);
  return print_exchanges(all);
}

}  // namespace
}  // namespace spindle_twin::bench

int main(int argc, char** argv) {
  using namespace spindle_twin::bench;
  Options options;
  CommandLine line("fault_campaign: virtual spindles whose sensors fail");
  options.runs = 8;
  add_options(line, options, "virtual spindles, each with every fault on every sensor",
              "one spindle, one sensor, coarse models: a quick look");
  line.limit("--runs", {1, 96});  // beyond that A would take the seeds of B
  line.add("--drift-runs", options.drift_runs, "how many of them also with drifts");
  line.add_flag("--healthy-only", options.healthy_only, "no faults: false alarms, and what watching costs");
  line.add_flag("--drifts-only", options.drifts_only, "no other faults, on the first --drift-runs spindles");
  line.exclude("--drifts-only", "--healthy-only");
  line.exclude("--drifts-only", "--short");
  line.add_flag("--swapped-from-start", options.swapped_from_start,
                "instead, every two sensors that differ are exchanged from the start");
  line.add_flag("--replugged", options.replugged,
                "the same after an hour, while both are unplugged; and put back right");
  line.add("--unplugged-s", options.unplugged.for_s, "for so long", Allowed{0.0, 3000.0});
  line.add("--partner-later-s", options.unplugged.partner_later_s, "one of the two for so much longer",
           Allowed{0.0, 3000.0});
  line.add_flag("--daemon-off", options.unplugged.daemon_off, "the daemon is off meanwhile, and the spindle stands");
  line.add_flag("--reads-open", options.unplugged.reads_open, "each reads open meanwhile, not nothing");
  line.exclude("--replugged", "--swapped-from-start");
  for (const char* name : {"--unplugged-s", "--partner-later-s", "--daemon-off", "--reads-open"}) {
    line.need(name, "--replugged");
  }
  line.add("--cycle-s", options.cycle_s, "period of the daemon", Allowed{0.1, 10.0});
  line.add_flag("--verbose", options.verbose, "a line per run");
  if (const auto code = line.parse(argc, argv)) return *code;
  settle(options);
  if (options.is_short) {
    options.drift_runs = 1;
    options.cycle_s = 5.0;
  }
  return run(options) == 0 ? 0 : 1;
}
