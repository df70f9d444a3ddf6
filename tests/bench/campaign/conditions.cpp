#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "tests/bench/campaign/campaign.hpp"
#include "tests/bench/campaign/models.hpp"
#include "tests/bench/campaign/results.hpp"

namespace spindle_twin::bench {
namespace {

struct Case {
  const char* name;
  Conditions conditions;
  bool heavy;  ///< many times the steps of the others
};

constexpr double lag_s = 30.0;
constexpr double day_s = 86400.0;
constexpr double wrong_exponent = 0.15;
const std::array<Case, 6> cases{{{"2 h, readings every 10 s", {}, false},
                                 {"sensors that lag 30 s", {run_s, sample_s, lag_s, false}, false},
                                 {"standstill from 60 to 90 min", {run_s, sample_s, 0.0, true}, false},
                                 {"speed laws wrong by 0.15", {run_s, sample_s, 0.0, false, wrong_exponent}, false},
                                 {"readings and updates every 1 s", {run_s, 1.0, 0.0, false}, true},
                                 {"24 h", {day_s, sample_s, 0.0, false}, true}}};
constexpr int all_sensors = 6;
constexpr double least_inside = 0.9;

}  // namespace

int print_conditions(const rom::Network& network, const fem_offline::AffineModel& model,
                     const correction::EstimatorOptions& options, const ConditionRuns& runs) {
  std::printf("\nOther conditions, %d sensors, the same spindles in each row (A): nose from %g s on\n", all_sensors,
              judged_from_s);
  std::printf("%-32s %5s %8s %8s %8s %8s %10s %9s\n", "condition", "runs", "rms um", "open um", "worst/s", "in 2s",
              "keypt K", "rejected");
  const correction::ParameterModel parameters(network, options.priors);
  int missed = 0;
  for (const Case& one : cases) {
    const int count = one.heavy ? runs.heavy : runs.light;
    std::vector<Score> scores(static_cast<std::size_t>(count)), open(scores);
    in_parallel(runs.threads, count, [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      const Truth truth = make_truth(model, parameters, runs.first_seed + static_cast<std::uint64_t>(i),
                                     HeatErrors::independent, one.conditions);
      scores[at] = run_estimator(network, truth, all_sensors, false, options);
      open[at] = run_open_loop(network, truth);
    });
    Score sum;
    double worst = 0.0, open_um2 = 0.0;
    for (std::size_t i = 0; i < scores.size(); ++i) {
      sum.error_um += scores[i].error_um * scores[i].error_um / count;
      sum.inside += scores[i].inside / count;
      sum.key_points_K += scores[i].key_points_K * scores[i].key_points_K / count;
      sum.rejected += scores[i].rejected;
      worst = std::max(worst, scores[i].error_um / scores[i].deviation_um);
      open_um2 += open[i].error_um * open[i].error_um / count;
    }
    missed += sum.inside >= least_inside ? 0 : 1;
    std::printf("%-32s %5d %8.2f %8.2f %8.2f %8.3f %10.3f %9ld%s\n", one.name, count, std::sqrt(sum.error_um),
                std::sqrt(open_um2), worst, sum.inside, std::sqrt(sum.key_points_K), sum.rejected,
                sum.inside >= least_inside ? "" : "   fewer than 90 % inside");
    std::fflush(stdout);
  }
  return missed;
}

}  // namespace spindle_twin::bench
