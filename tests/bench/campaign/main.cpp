#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>

#include "tests/bench/campaign/campaign.hpp"
#include "tests/bench/campaign/models.hpp"
#include "tests/bench/campaign/options.hpp"
#include "tests/bench/campaign/results.hpp"

namespace spindle_twin::bench {
namespace {

struct Options : CampaignOptions {
  bool conditions = false;
  double speed_exponent = 0.0;
  double walk = 1.0;
  double floor_K = correction::EstimatorOptions{}.floor_K;
};

correction::EstimatorOptions estimator_options(const Options& options, HeatErrors heats) {
  correction::EstimatorOptions estimator;
  estimator.priors = priors_of(heats);
  estimator.priors.heat_walk_per_root_min *= options.walk;
  estimator.priors.contact_walk_per_root_min *= options.walk;
  estimator.priors.film_walk_per_root_min *= options.walk;
  estimator.floor_K = options.floor_K;
  return estimator;
}

/// How many limits were missed.
int run(const Options& options) {
  const rom::Network network = twin_network(options.twin);
  std::printf(
      "seed %llu, %d runs of 2 h for each of A and B; twin: %zu nodes from a mesh of %g mm; truth: %g mm, speed "
      "exponents +-%g\n",
      static_cast<unsigned long long>(options.seed), options.runs, network.nodes.size(), options.twin.element_size_mm,
      options.truth_mm, options.speed_exponent);
  std::fflush(stdout);
  const fem_offline::FeModel fe = model_of(options.truth_mm);
  if (options.conditions) {
    const ConditionRuns runs{std::min(options.runs, 4), std::min(options.runs, 2), options.twin.threads,
                             1000 * options.seed};
    return print_conditions(network, fe.affine(), estimator_options(options, HeatErrors::independent), runs);
  }
  std::vector<RunResult> results(static_cast<std::size_t>(2 * options.runs));
  std::mutex printing;
  int done = 0;
  in_parallel(options.twin.threads, 2 * options.runs, [&](int i) {
    const HeatErrors heats = i < options.runs ? HeatErrors::independent : HeatErrors::common;
    const correction::EstimatorOptions estimator = estimator_options(options, heats);
    const correction::ParameterModel parameters(network, estimator.priors);
    const std::uint64_t seed = seed_of(options, i < options.runs ? i : i - options.runs, heats);
    const Truth truth = cached_truth(options.twin.cache, fe.affine(), parameters, seed, heats, options.speed_exponent);
    RunResult& result = results[static_cast<std::size_t>(i)];
    result.seed = seed;
    result.heats = heats;
    result.span_um = 1e6 * (truth.nose_m.maxCoeff() - truth.nose_m.minCoeff());
    describe_heats(parameters, truth, result);
    result.open_loop = run_open_loop(network, truth);
    for (std::size_t s = 0; s < set_ups.size(); ++s) {
      const SetUp& set_up = set_ups[s];
      if (s > 0 && set_ups[s - 1].sensors == set_up.sensors) {
        result.paper[s] = result.paper[s - 1];
        result.paper_corrected[s] = result.paper_corrected[s - 1];
      } else {
        result.paper[s] = run_paper(network, truth, set_up.sensors, false);
        result.paper_corrected[s] = run_paper(network, truth, set_up.sensors, true);
      }
      result.estimator[s] = run_estimator(network, truth, set_up.sensors, set_up.touch_off, estimator);
      result.bound_um[s] = bound_um(network, truth, set_up.sensors, set_up.touch_off, estimator);
    }
    const std::lock_guard lock(printing);
    std::fprintf(stderr, "%s %llu:", heats == HeatErrors::independent ? "A" : "B",
                 static_cast<unsigned long long>(seed));
    for (std::size_t s = 0; s < set_ups.size(); ++s) {
      std::fprintf(stderr, "  %s %.2f of %.2f um", set_ups[s].name, result.estimator[s].error_um,
                   result.estimator[s].deviation_um);
    }
    std::fprintf(stderr, "; run %d of %d\n", ++done, 2 * options.runs);
  });
  print_tables(results);
  if (!options.is_short) return print_limits(results);
  int missed = 0;
  for (const RunResult& result : results) {
    for (const Score& score : result.estimator) {
      missed += score.key_points_K <= 0.04 && score.inside >= 0.8 && score.error_um <= 2.5 * score.deviation_um ? 0 : 1;
    }
  }
  if (missed > 0) std::printf("\n%d results are worse than any estimator of this kind should give\n", missed);
  return missed;
}

}  // namespace
}  // namespace spindle_twin::bench

int main(int argc, char** argv) {
  using namespace spindle_twin::bench;
  Options options;
  CommandLine line("twin_campaign: virtual spindles against their twins");
  options.runs = 48;
  add_options(line, options, "of 2 h, for each of A and B",
              "one run for each of A and B with coarse models, for a quick look");
  line.add("--speed-exponent", options.speed_exponent, "deviation of the true heats' exponents of speed",
           Allowed{0.0, 0.5});
  line.add("--walk", options.walk, "times the default random walk of the ln factors");
  line.add("--floor-K", options.floor_K, "model error at a sensor");
  line.add_flag(
      "--conditions", options.conditions,
      "instead: lagging sensors, standstill, wrong speed laws, updates every second and a day, up to 4 runs each");
  if (const auto code = line.parse(argc, argv)) return *code;
  settle(options);
  return run(options) == 0 ? 0 : 1;
}
