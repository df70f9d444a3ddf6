#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "tests/bench/campaign/models.hpp"
#include "tests/bench/campaign/options.hpp"
#include "tests/bench/commissioning/commission.hpp"
#include "tests/bench/commissioning/hidden_pairs.hpp"
#include "tests/bench/commissioning/limits.hpp"
#include "tests/bench/commissioning/wrong_models.hpp"

namespace spindle_twin::bench {
namespace {

struct Options : CampaignOptions {
  TestPlan plan;
  bool hidden_pairs = false;
  bool wrong_models = false;
};

/// One number of every machine.
std::vector<double> all_of(const std::vector<Commissioned>& machines,
                           const std::function<double(const Commissioned&)>& what) {
  std::vector<double> values;
  for (const Commissioned& machine : machines) values.push_back(what(machine));
  return values;
}

double least_of(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

void print_row(const char* label, const std::vector<Commissioned>& machines,
               const std::function<const Score&(const Commissioned&)>& score) {
  const std::vector<double> errors = all_of(machines, [&](const Commissioned& each) { return score(each).error_um; });
  const std::vector<double> inside = all_of(machines, [&](const Commissioned& each) { return score(each).inside; });
  std::printf("  %-34s %7.2f %7.2f %9.3f %9.3f\n", label, median_of(errors), worst_of(errors), mean_of(inside),
              least_of(inside));
}

void print_tables(const std::vector<Commissioned>& machines) {
  for (std::size_t d = 0; d < drifts.size(); ++d) {
    std::printf("\ndrift %s\n  %-34s %7s %7s %9s %9s\n", drifts[d].name, "nose, um", "median", "worst", "inside",
                "least");
    const auto spans = all_of(machines, [&](const Commissioned& each) { return each.days[d].span_um; });
    const auto open = all_of(machines, [&](const Commissioned& each) { return each.days[d].uncorrected_um; });
    std::printf("  %-34s %7.1f %7.1f\n", "span of the truth", median_of(spans), worst_of(spans));
    std::printf("  %-34s %7.2f %7.2f\n", "neither test nor sensor", median_of(open), worst_of(open));
    for (std::size_t set = 0; set < permanent_sensors.size(); ++set) {
      const std::string sensors = std::to_string(permanent_sensors[set]) + " sensors, ";
      print_row((sensors + "no test").c_str(), machines,
                [&](const Commissioned& each) -> const Score& { return each.days[d].without_test[set]; });
      print_row((sensors + "test").c_str(), machines,
                [&](const Commissioned& each) -> const Score& { return each.days[d].with_test[set]; });
      print_row((sensors + "test, none in service").c_str(), machines,
                [&](const Commissioned& each) -> const Score& { return each.days[d].blind[set]; });
      const auto bound = all_of(machines, [&](const Commissioned& each) { return each.days[d].bound_um[set]; });
      std::printf("  %-34s %7.2f %7.2f\n", (sensors + "linear bound").c_str(), median_of(bound), worst_of(bound));
    }
  }
}

void print_parameters(const std::vector<Commissioned>& machines) {
  std::printf("\nhidden parameters that the test found, off in their own sigma\n");
  for (std::size_t set = 0; set < permanent_sensors.size(); ++set) {
    std::vector<double> squares, inside;
    for (const Commissioned& machine : machines) {
      for (const double off : machine.off[set]) {
        squares.push_back(off * off);
        inside.push_back(std::abs(off) <= 2.0 ? 1.0 : 0.0);
      }
    }
    std::printf("  %d sensors: rms %.2f, inside +-2 sigma %.3f of %zu\n", permanent_sensors[set],
                std::sqrt(mean_of(squares)), mean_of(inside), inside.size());
  }
}

/// Limits of one drift with one set of sensors.
struct Allowed {
  double median_um, worst_um, gain;
};
constexpr Allowed allowed[drifts.size()][permanent_sensors.size()] = {{{0.8, 2.7, 4.0}, {0.6, 1.3, 1.6}},
                                                                      {{1.2, 5.5, 0.0}, {0.7, 2.0, 0.0}}};

int print_limits(const std::vector<Commissioned>& machines) {
  int missed = 0;
  std::printf("\nlimits\n");
  for (std::size_t d = 0; d < drifts.size(); ++d) {
    for (std::size_t set = 0; set < permanent_sensors.size(); ++set) {
      const Allowed& most = allowed[d][set];
      const std::string who = std::to_string(permanent_sensors[set]) + " sensors, drift " + drifts[d].name + ": ";
      const auto of = [&](auto scores, auto what) {
        return all_of(machines, [&](const Commissioned& each) { return (each.days[d].*scores)[set].*what; });
      };
      const auto with = of(&Service::with_test, &Score::error_um),
                 without = of(&Service::without_test, &Score::error_um);
      const auto inside = of(&Service::with_test, &Score::inside);
      missed += limit((who + "median, um").c_str(), median_of(with), most.median_um);
      missed += limit((who + "worst machine, um").c_str(), worst_of(with), most.worst_um);
      if (most.gain > 0.0) {
        missed += limit((who + "gain of the median").c_str(), median_of(without) / median_of(with), most.gain, true);
      }
      missed += limit((who + "inside +-2 sigma, pooled").c_str(), mean_of(inside), 0.93, true);
      missed += limit((who + "inside, worst machine").c_str(), least_of(inside), 0.70, true);
      int worse = 0;
      for (std::size_t m = 0; m < machines.size(); ++m) worse += with[m] > without[m] ? 1 : 0;
      missed += limit((who + "machines that are worse for it").c_str(), worse, 0.0);
      if (d > 0) continue;
      const auto blind = of(&Service::blind, &Score::error_um);
      missed += limit((who + "none in service, median, um").c_str(), median_of(blind), 1.2);
      missed += limit((who + "none in service, worst, um").c_str(), worst_of(blind), 5.0);
    }
  }
  std::printf("%d limits missed\n", missed);
  return missed;
}

/// What no calibration of this kind should miss: of the small drift.
int check_short(const std::vector<Commissioned>& machines) {
  int missed = 0;
  for (const Commissioned& machine : machines) {
    for (std::size_t set = 0; set < permanent_sensors.size(); ++set) {
      const Score& score = machine.days[0].with_test[set];
      missed += score.error_um <= 1.5 && score.inside >= 0.7 && machine.probe_um[set] <= 1.5 ? 0 : 1;
    }
  }
  if (missed > 0) std::printf("\n%d results are worse than any calibration of this kind should give\n", missed);
  return missed;
}

int run(const Options& options) {
  if (options.wrong_models) return check_wrong_models(options, options.plan);
  const rom::Network network = twin_network(options.twin);
  const fem_offline::FeModel fe = model_of(options.truth_mm);
  std::printf("seed %llu, %d machines of %s; twin: %zu nodes; truth: %g mm\n",
              static_cast<unsigned long long>(options.seed), options.runs, options.is_short ? "A" : "each of A and B",
              network.nodes.size(), options.truth_mm);
  std::fflush(stdout);
  if (options.hidden_pairs) return check_hidden_pairs(network, fe.affine(), options.twin.threads);
  const int count = options.is_short ? 1 : 2 * options.runs;
  std::vector<Commissioned> machines(static_cast<std::size_t>(count));
  std::mutex printing;
  in_parallel(options.twin.threads, count, [&](int i) {
    const HeatErrors heats = i < options.runs ? HeatErrors::independent : HeatErrors::common;
    const std::uint64_t seed = seed_of(options, i < options.runs ? i : i - options.runs, heats);
    Commissioned& machine = machines[static_cast<std::size_t>(i)];
    machine = commission(network, fe.affine(), seed, heats, options.plan);
    const std::lock_guard lock(printing);
    std::fprintf(stderr, "%s %llu:", heats == HeatErrors::independent ? "A" : "B",
                 static_cast<unsigned long long>(seed));
    for (std::size_t set = 0; set < permanent_sensors.size(); ++set) {
      std::fprintf(stderr, "  %d: %d evaluations %.0f s, chi2 %.2f, probe %.2f, held out %.2f um%s;",
                   permanent_sensors[set], machine.evaluations[set], machine.fit_s[set], machine.chi_square[set],
                   machine.probe_um[set], machine.hold_out_um[set], machine.refused[set] ? " (refused)" : "");
      for (const Service& day : machine.days) {
        std::fprintf(stderr, " %.2f -> %.2f (%.2f, inside %.2f)", day.without_test[set].error_um,
                     day.with_test[set].error_um, day.with_test[set].deviation_um, day.with_test[set].inside);
      }
    }
    std::fprintf(stderr, "\n");
  });
  print_tables(machines);
  print_parameters(machines);
  return options.is_short ? check_short(machines) : print_limits(machines);
}

}  // namespace
}  // namespace spindle_twin::bench

int main(int argc, char** argv) {
  using namespace spindle_twin::bench;
  Options options;
  CommandLine line("commissioning_campaign: virtual spindles that get one test with a probe");
  options.runs = 6;
  add_options(line, options, "machines, for each of A and B", "one machine of A with coarse models");
  line.add("--test-s", options.plan.test_s, "length of the test");
  line.add("--service-s", options.plan.service_s, "length of a day of service");
  line.add("--expansion", options.plan.expansion,
           "deviation of how much more a machine expands than the twin believes");
  line.add_flag("--touch-offs", options.plan.touch_offs, "a touch-off each half hour instead of the probe");
  line.add_flag("--hidden-pairs", options.hidden_pairs,
                "only the two spindles of the twin campaign in which a contact and a heat hide each other");
  line.add_flag("--wrong-models", options.wrong_models,
                "machines of A, six sensors, whose structure the twin's FE model has wrong");
  if (const auto code = line.parse(argc, argv)) return *code;
  settle(options);
  if (options.is_short) options.plan.test_s = options.plan.service_s = 3600.0;
  return run(options) == 0 ? 0 : 1;
}
