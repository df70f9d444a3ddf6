#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <mutex>

#include "tests/bench/command_line/command_line.hpp"
#include "tests/bench/in_parallel.hpp"
#include "tests/bench/motors/follow.hpp"
#include "tests/bench/motors/two_nodes.hpp"

namespace spindle_twin::bench {
namespace {

struct Options {
  int runs = 16;
  std::uint64_t seed = 1;
  int threads = 2;
  bool is_short = false;
  bool verbose = false;
  FollowOptions follow;
};

struct Feeding {
  const char* name;
  std::array<bool, 2> fed;
};
constexpr std::array<Feeding, 3> feedings{
    {{"both", {true, true}}, {"winding only", {true, false}}, {"housing only", {false, true}}}};

struct Result {
  std::uint64_t seed = 0;
  Start start = Start::cold;
  int bodies = 0;
  double period_s = 0.0;
  double fit_K = 0.0;  ///< what the best two nodes leave of the motor
  std::array<FollowScore, feedings.size()> scores;
};

/// All starts in turn, whatever the number of runs; the same motor for the same seed.
Result run_one(const Options& options, std::uint64_t seed) {
  constexpr std::array<Start, 4> starts{Start::cold, Start::warm, Start::cold, Start::warm_stopped};
  Random random(seed);
  const Motor motor(random);
  const TwoNodesFit fit = best_two_nodes(motor, random);
  const rom::Network network = network_of(made_wrong(fit.nodes, {0, 0, 0, 0}, random));
  const MotorRun run = run_motor(motor, starts[seed % starts.size()], random());
  Result result{seed, run.start, run.bodies, run.period_s, fit.rms_K, {}};
  MotorRun named = run;
  named.seed = seed;
  for (std::size_t f = 0; f < feedings.size(); ++f) {
    FollowOptions own = options.follow;
    own.label = feedings[f].name;
    result.scores[f] = follow(network, named, feedings[f].fed, own);
  }
  return result;
}

/// Of all places that `use(feeding, place)` names, over all runs.
struct Pooled {
  double rms_K = 0.0, deviation_K = 0.0, uncorrected_K = 0.0, worst_K = 0.0, worst_early_K = 0.0;
  double within_1_K = 0.0, inside = 0.0, least_inside = 1.0, least_within = 1.0, worst_rms_K = 0.0;
};

template <class Use>
Pooled pool(const std::vector<Result>& results, const Use& use) {
  Pooled pooled;
  int count = 0;
  for (const Result& result : results) {
    for (std::size_t f = 0; f < feedings.size(); ++f) {
      for (std::size_t k = 0; k < 2; ++k) {
        if (!use(feedings[f], k)) continue;
        const PlaceScore& score = result.scores[f].places[k];
        ++count;
        pooled.rms_K += score.rms_K * score.rms_K;
        pooled.deviation_K += score.deviation_K * score.deviation_K;
        pooled.uncorrected_K += score.uncorrected_K * score.uncorrected_K;
        pooled.within_1_K += score.within_1_K;
        pooled.inside += score.inside;
        pooled.worst_K = std::max(pooled.worst_K, score.worst_K);
        pooled.worst_early_K = std::max(pooled.worst_early_K, score.worst_early_K);
        pooled.worst_rms_K = std::max(pooled.worst_rms_K, score.rms_K);
        pooled.least_inside = std::min(pooled.least_inside, score.inside);
        pooled.least_within = std::min(pooled.least_within, score.within_1_K);
      }
    }
  }
  for (double* square_K2 : {&pooled.rms_K, &pooled.deviation_K, &pooled.uncorrected_K}) {
    *square_K2 = std::sqrt(*square_K2 / count);
  }
  pooled.within_1_K /= count;
  pooled.inside /= count;
  return pooled;
}

bool fed_both(const Feeding& feeding, std::size_t) { return feeding.fed[0] && feeding.fed[1]; }
bool withheld(const Feeding& feeding, std::size_t place) { return !feeding.fed[place]; }

void print_runs(const std::vector<Result>& results) {
  std::printf("%6s %-8s %6s %6s %6s  %-13s %-8s %8s %8s %8s %8s %8s %7s %7s %8s %8s %8s\n", "seed", "start", "bodies",
              "s", "fit K", "fed", "place", "rms K", "sd K", "open K", "early K", "worst K", "<1 K", "inside",
              "rejected", "degraded", "failed");
  for (const Result& result : results) {
    for (std::size_t f = 0; f < feedings.size(); ++f) {
      const FollowScore& score = result.scores[f];
      for (std::size_t k = 0; k < 2; ++k) {
        const PlaceScore& place = score.places[k];
        std::printf(
            "%6llu %-8s %6d %6.0f %6.2f  %-13s %-8s %8.3g %8.3g %8.3g %8.3g %8.3g %7.3f %7.3f %8.3f %8.3f %8.3f%s\n",
            static_cast<unsigned long long>(result.seed), name_of(result.start), result.bodies, result.period_s,
            result.fit_K, feedings[f].name, place_names[k], place.rms_K, place.deviation_K, place.uncorrected_K,
            place.worst_early_K, place.worst_K, place.within_1_K, place.inside, score.rejected, score.degraded,
            score.failed, score.ended_running ? "" : "  not running at the end");
      }
    }
  }
}

void print_pooled(const char* name, const Pooled& pooled) {
  std::printf("%-24s %8.3f %8.3f %8.2f %8.3f %8.2f %8.2f %7.3f %7.3f %7.3f %7.3f\n", name, pooled.rms_K,
              pooled.deviation_K, pooled.uncorrected_K, pooled.worst_rms_K, pooled.worst_early_K, pooled.worst_K,
              pooled.within_1_K, pooled.least_within, pooled.inside, pooled.least_inside);
}

int print_limit(const char* what, double is, const char* comparison, double limit, bool met) {
  std::printf("  %-66s %9.3f  %s %g  %s\n", what, is, comparison, limit, met ? "met" : "MISSED");
  return met ? 0 : 1;
}
int at_most(const char* what, double is, double limit) { return print_limit(what, is, "<=", limit, is <= limit); }
int at_least(const char* what, double is, double limit) { return print_limit(what, is, ">=", limit, is >= limit); }

/// Issue 11 as it was found: a two-node network that is wrong by 30-50 %, started on a motor that has run for two
/// hours, both sensors given. All sixteen signs of the four errors. How many limits were missed.
int print_issue_case(const Options& options) {
  constexpr int motor_seed = 1540;
  const int count = options.is_short ? 4 : 16;
  std::vector<FollowScore> scores(static_cast<std::size_t>(count));
  in_parallel(options.threads, count, [&](int i) {
    // In the short form four of them, with each sign twice.
    constexpr std::array<int, 4> short_signs{0b0101, 0b1010, 0b0011, 0b1100};
    const int bits_of_signs = options.is_short ? short_signs[static_cast<std::size_t>(i)] : i;
    std::array<int, 4> signs{};
    for (std::size_t s = 0; s < signs.size(); ++s) signs[s] = (bits_of_signs >> s & 1) != 0 ? 1 : -1;
    Random random(motor_seed);
    const Motor motor(random);
    const TwoNodesFit fit = best_two_nodes(motor, random);
    const rom::Network network = network_of(made_wrong(fit.nodes, signs, random));
    FollowOptions own = options.follow;
    own.label = "issue case";
    MotorRun run = run_motor_at_rated_duty(motor, motor_seed);
    run.seed = static_cast<std::uint64_t>(i);  // in the trace
    scores[static_cast<std::size_t>(i)] = follow(network, run, {true, true}, own);
  });
  std::printf(
      "\nissue 11's case: warm after two hours at rated duty, both sensors, errors of 30-50 %% with these signs\n");
  std::printf("(capacity of winding, of housing, contact, film); K, from 20 min on\n");
  double worst_K = 0.0, unsaid = 0.0;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const FollowScore& score = scores[i];
    const double of_run_K = std::max(score.places[0].worst_K, score.places[1].worst_K);
    if (options.verbose) {
      std::printf(
          "  case %2zu: winding rms %.3g worst %.3g, housing rms %.3g worst %.3g, open loop %.3g, rejected %.2f\n", i,
          score.places[0].rms_K, score.places[0].worst_K, score.places[1].rms_K, score.places[1].worst_K,
          std::max(score.places[0].uncorrected_K, score.places[1].uncorrected_K), score.rejected);
    }
    worst_K = std::max(worst_K, of_run_K);
    unsaid = std::max(unsaid, score.rejecting_unsaid);
  }
  return at_most("issue 11's case, furthest from the truth at any time, K", worst_K, 10.0) +
         at_most("issue 11's case, share with most readings rejected and `running`", unsaid, 0.0);
}

int run(const Options& options) {
  std::printf("motor_campaign: %d motors of three to five bodies, 4 h each; seeds %llu to %llu\n", options.runs,
              static_cast<unsigned long long>(options.seed),
              static_cast<unsigned long long>(options.seed + static_cast<std::uint64_t>(options.runs) - 1));
  std::fflush(stdout);
  std::vector<Result> results(static_cast<std::size_t>(options.runs));
  std::mutex printing;
  int done = 0;
  in_parallel(options.threads, options.runs, [&](int i) {
    Result& result = results[static_cast<std::size_t>(i)];
    result = run_one(options, options.seed + static_cast<std::uint64_t>(i));
    const std::lock_guard lock(printing);
    if (!options.is_short) {
      std::fprintf(stderr, "seed %llu done, %d of %d\n", static_cast<unsigned long long>(result.seed), ++done,
                   options.runs);
    }
  });
  if (options.verbose) print_runs(results);

  const auto only = [](std::size_t feeding, std::size_t place) {
    return [=](const Feeding& one, std::size_t k) { return &one == &feedings[feeding] && k == place; };
  };
  std::printf("\n%-24s %8s %8s %8s %8s %8s %8s %7s %7s %7s %7s\n", "", "rms K", "sd K", "open K", "run rms", "early K",
              "worst K", "<1 K", "(least)", "inside", "(least)");
  print_pooled("both fed: winding", pool(results, only(0, 0)));
  print_pooled("both fed: housing", pool(results, only(0, 1)));
  print_pooled("housing withheld", pool(results, only(1, 1)));
  print_pooled("winding withheld", pool(results, only(2, 0)));
  print_pooled("winding, alone fed", pool(results, only(1, 0)));
  print_pooled("housing, alone fed", pool(results, only(2, 1)));

  const Pooled fed = pool(results, fed_both), hidden = pool(results, withheld);
  double unsaid = 0.0;
  for (const Result& result : results) {
    for (const FollowScore& score : result.scores) unsaid = std::max(unsaid, score.rejecting_unsaid);
  }
  std::printf("\nlimits, from 20 min on:\n");
  int missed = 0;
  missed += at_most("both fed: rms against the true temperatures, K", fed.rms_K, 0.5);
  missed += at_least("both fed: share within 1 K", fed.within_1_K, 0.95);
  missed += at_most("both fed: furthest from the truth, K", fed.worst_K, 10.0);
  missed += at_most("both fed: furthest from the truth before, from 2 min on, K", fed.worst_early_K, 10.0);
  missed += at_least("withheld: share of the truth inside +-2 sigma", hidden.inside, 0.90);
  missed += at_most("share of any run with most readings rejected and `running`", unsaid, 0.0);
  missed += print_issue_case(options);
  return missed;
}

}  // namespace
}  // namespace spindle_twin::bench

int main(int argc, char** argv) {
  using namespace spindle_twin::bench;
  Options options;
  using spindle_twin::bench::Allowed;
  spindle_twin::bench::CommandLine line(
      "motor_campaign: simulated motors against a hand-written network of two nodes that is 30-50 % wrong");
  line.add("--runs", options.runs, "motors of 4 h; each is followed with both sensors and with one of them",
           Allowed{1, 10000});
  line.add("--seed", options.seed, "of the first motor; the next ones count up");
  line.add("--threads", options.threads, "that work at once", Allowed{1, 64});
  line.add_flag("--short", options.is_short, "four motors, for a quick look");
  line.add_flag("--verbose", options.verbose, "a line for each motor, sensors in use and place");
  line.add("--correction", options.follow.correction,
           "lines for the daemon's table [correction], such as \"floor_K = 0.3\"");
  line.add("--health", options.follow.health, "lines for [health], such as \"enabled = false\"");
  line.add("--trace", options.follow.trace_path,
           "writes every cycle to this file, as CSV: truth, predictions, deviations, readings, state, quality; "
           "of the first motor, then of issue 11's cases");
  if (const auto code = line.parse(argc, argv)) return *code;
  if (options.is_short) options.runs = 4;
  if (!options.follow.trace_path.empty()) {
    options.runs = options.threads = 1;
    std::filesystem::remove(options.follow.trace_path);
  }
  return run(options) == 0 ? 0 : 1;
}
