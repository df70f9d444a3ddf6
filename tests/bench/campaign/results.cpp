#include "tests/bench/campaign/results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>

namespace spindle_twin::bench {
namespace {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const std::size_t middle = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<long>(middle), values.end());
  const double high = values[middle];
  if (values.size() % 2 == 1) return high;
  std::nth_element(values.begin(), values.begin() + static_cast<long>(middle) - 1, values.end());
  return 0.5 * (high + values[middle - 1]);
}

/// Root mean square, and so on, over the runs that `chosen` picks.
struct Column {
  std::vector<const RunResult*> runs;
  std::size_t set_up;

  double pooled(const std::function<double(const RunResult&)>& value) const {
    double sum = 0.0;
    for (const RunResult* run : runs) sum += value(*run) * value(*run);
    return std::sqrt(sum / static_cast<double>(runs.size()));
  }
  double middle(const std::function<double(const RunResult&)>& value) const {
    std::vector<double> all;
    for (const RunResult* run : runs) all.push_back(value(*run));
    return median(all);
  }
  double mean(const std::function<double(const RunResult&)>& value) const {
    double sum = 0.0;
    for (const RunResult* run : runs) sum += value(*run);
    return sum / static_cast<double>(runs.size());
  }
  double worst(const std::function<double(const RunResult&)>& value) const {
    double most = 0.0;
    for (const RunResult* run : runs) most = std::max(most, value(*run));
    return most;
  }
};

void print_column(const Column& column, const char* heats) {
  const std::size_t s = column.set_up;
  const auto error = [s](const RunResult& run) { return run.estimator[s].error_um; };
  const auto paper = [s](const RunResult& run) { return run.paper[s].error_um; };
  const auto corrected = [s](const RunResult& run) { return run.paper_corrected[s].error_um; };
  const auto bound = [s](const RunResult& run) { return run.bound_um[s]; };
  const auto open = [](const RunResult& run) { return run.open_loop.error_um; };
  const double better_than_paper =
      column.mean([&](const RunResult& run) { return error(run) < paper(run) ? 1.0 : 0.0; });
  const double better_than_corrected =
      column.mean([&](const RunResult& run) { return error(run) < corrected(run) ? 1.0 : 0.0; });
  const double better_than_open = column.mean([&](const RunResult& run) { return error(run) < open(run) ? 1.0 : 0.0; });
  const double rejected =
      column.mean([s](const RunResult& run) { return static_cast<double>(run.estimator[s].rejected); });
  std::printf(
      "%-5s %-14s %7.2f %7.2f %7.2f %7.2f %7.2f %7.2f %7.1f %7.1f %8.3f %7.2f %7.2f %7.2f %7.2f %7.2f %8.0f %8.0f "
      "%8.0f %8.2f\n",
      heats, set_ups[s].name, column.middle(error), column.pooled(error),
      column.middle([&](const RunResult& run) { return error(run) / bound(run); }),
      column.pooled(error) / column.pooled(bound),
      column.worst([&](const RunResult& run) { return error(run) / run.estimator[s].deviation_um; }),
      column.mean([s](const RunResult& run) { return run.estimator[s].inside; }),
      100.0 * column.middle([&](const RunResult& run) { return error(run) / run.span_um; }),
      column.pooled([s](const RunResult& run) { return run.estimator[s].rotor_K; }),
      column.pooled([s](const RunResult& run) { return run.estimator[s].key_points_K; }), column.pooled(open),
      column.pooled(paper), column.pooled(corrected), column.pooled(paper) / column.pooled(error),
      column.pooled(corrected) / column.pooled(error), 100.0 * better_than_paper, 100.0 * better_than_corrected,
      100.0 * better_than_open, rejected);
}

/// How often a Gaussian error of deviation sigma is larger than this.
double chance_beyond(double error, double sigma) { return std::erfc(error / (sigma * std::numbers::sqrt2)); }

/// Why another answer was nearer than the estimator's. An ideal filter's error is Gaussian with the bound as deviation,
/// so it loses with chance_beyond(the other's error, bound).
const char* reason(const RunResult& run, std::size_t s, double other_um) {
  const Score& own = run.estimator[s];
  if (chance_beyond(other_um, run.bound_um[s]) >= 0.05) return "nearer than these sensors can tell";
  if (own.error_um <= 2.0 * own.deviation_um) return "within its own 2 sigma";
  return "estimator beyond its own 2 sigma";
}

void print_lost(const std::vector<RunResult>& results) {
  for (std::size_t s = 0; s < set_ups.size(); ++s) {
    double expected = 0.0, lost = 0.0;
    for (const RunResult& run : results) {
      expected += chance_beyond(run.paper[s].error_um, run.bound_um[s]);
      lost += run.estimator[s].error_um < run.paper[s].error_um ? 0.0 : 1.0;
    }
    std::printf(
        "\n%s sensors: published law nearer in %.0f runs; with an error as large as the bound %.0f would be expected\n",
        set_ups[s].name, lost, expected);
    std::printf(
        "  heats seed   estimator  sigma  bound  published  corrected   open um  hidden ln heat, spread; reason\n");
    for (const RunResult& run : results) {
      const double error_um = run.estimator[s].error_um;
      if (error_um < run.paper[s].error_um && error_um < run.open_loop.error_um) continue;
      const double other_um = std::min(run.paper[s].error_um, run.open_loop.error_um);
      std::printf("  %-5s %-6llu %9.2f %6.2f %6.2f %10.2f %10.2f %9.2f  %+.2f, %.2f; %s: %s\n",
                  run.heats == HeatErrors::independent ? "A" : "B", static_cast<unsigned long long>(run.seed), error_um,
                  run.estimator[s].deviation_um, run.bound_um[s], run.paper[s].error_um,
                  run.paper_corrected[s].error_um, run.open_loop.error_um, run.heat_mean, run.heat_spread,
                  run.paper[s].error_um <= run.open_loop.error_um ? "law" : "open loop", reason(run, s, other_um));
    }
  }
}

}  // namespace

void describe_heats(const correction::ParameterModel& parameters, const Truth& truth, RunResult& result) {
  std::vector<double> heats;
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    if (parameters.list()[static_cast<std::size_t>(i)].kind == correction::ParameterKind::heat) {
      heats.push_back(truth.theta[i]);
    }
  }
  const Eigen::Map<const Eigen::ArrayXd> ln(heats.data(), static_cast<Eigen::Index>(heats.size()));
  result.heat_mean = ln.mean();
  result.heat_spread = std::sqrt((ln - ln.mean()).square().mean());
}

void print_tables(const std::vector<RunResult>& results) {
  std::printf("\nNose error from %g s on. bound: linearised posterior at the true parameters\n", judged_from_s);
  std::printf("%-5s %-14s %7s %7s %7s %7s %7s %7s %7s %7s %8s %7s %7s %7s %7s %7s %8s %8s %8s %8s\n", "heats",
              "sensors", "med um", "rms um", "med/bd", "rms/bd", "worst/s", "in 2s", "% span", "rotorK", "keypt K",
              "open um", "paper", "p+state", "paper/x", "p+s/x", "% better", "% b.p+s", "% b.open", "rejected");
  for (const HeatErrors heats : {HeatErrors::independent, HeatErrors::common}) {
    for (std::size_t s = 0; s < set_ups.size(); ++s) {
      Column column{{}, s};
      for (const RunResult& run : results) {
        if (run.heats == heats) column.runs.push_back(&run);
      }
      print_column(column, heats == HeatErrors::independent ? "A" : "B");
    }
  }
  for (std::size_t s = 0; s < set_ups.size(); ++s) {
    Column column{{}, s};
    for (const RunResult& run : results) column.runs.push_back(&run);
    print_column(column, "both");
  }
  print_lost(results);
}

int print_limits(const std::vector<RunResult>& results) {
  int missed = 0;
  const auto limit = [&](const char* what, const char* set_up, double value, const char* relation, double wanted) {
    const bool met = relation[0] == '<' ? value <= wanted : value >= wanted;
    missed += met ? 0 : 1;
    std::printf("  %-44s %-14s %8.3f  %s %.3g%s\n", what, set_up, value, relation, wanted, met ? "" : "   MISSED");
  };
  const std::array<double, set_ups.size()> median_limit{0.8, 1.0, 1.1}, pooled_limit{0.9, 1.1, 1.15},
      inside_limit{0.93, 0.93, 0.92}, independent_limit{10.0, 4.5, 3.5}, common_limit{5.0, 3.5, 3.0};
  std::printf("\nLimits, A and B together where nothing else is said:\n");
  for (std::size_t s = 0; s < set_ups.size(); ++s) {
    const char* name = set_ups[s].name;
    Column all{{}, s}, independent{{}, s}, common{{}, s};
    for (const RunResult& run : results) {
      all.runs.push_back(&run);
      (run.heats == HeatErrors::independent ? independent : common).runs.push_back(&run);
    }
    const auto error = [s](const RunResult& run) { return run.estimator[s].error_um; };
    const auto bound = [s](const RunResult& run) { return run.bound_um[s]; };
    const auto share = [s](const RunResult& run) { return 100.0 * run.estimator[s].error_um / run.span_um; };
    limit("median error / bound", name, all.middle([&](const RunResult& run) { return error(run) / bound(run); }),
          "<=", median_limit[s]);
    limit("pooled error / bound", name, all.pooled(error) / all.pooled(bound), "<=", pooled_limit[s]);
    limit("worst run, error / its own published sigma", name,
          all.worst([&](const RunResult& run) { return error(run) / run.estimator[s].deviation_um; }), "<=", 2.2);
    limit("truth inside 2 sigma", name, all.mean([s](const RunResult& run) { return run.estimator[s].inside; }),
          ">=", inside_limit[s]);
    limit("median error, % of span, A", name, independent.middle(share), "<=", independent_limit[s]);
    limit("median error, % of span, B", name, common.middle(share), "<=", common_limit[s]);
    limit("key points rms, K", name, all.pooled([s](const RunResult& run) { return run.estimator[s].key_points_K; }),
          "<=", 0.03);
    const auto paper = [s](const RunResult& run) { return run.paper[s].error_um; };
    limit("% of runs better than the published law", name,
          100.0 * all.mean([&](const RunResult& run) { return error(run) < paper(run) ? 1.0 : 0.0; }), ">=", 85.0);
    if (s == 1) limit("published law / estimator, pooled", name, all.pooled(paper) / all.pooled(error), ">=", 3.0);
    const auto corrected = [s](const RunResult& run) { return run.paper_corrected[s].error_um; };
    std::printf("  %-44s %-14s %8.3f, better in %.0f %% of the runs\n",
                "beside: law with our state correction / estimator", name, all.pooled(corrected) / all.pooled(error),
                100.0 * all.mean([&](const RunResult& run) { return error(run) < corrected(run) ? 1.0 : 0.0; }));
  }
  return missed;
}

Truth cached_truth(const std::string& cache, const fem_offline::AffineModel& model,
                   const correction::ParameterModel& parameters, std::uint64_t seed, HeatErrors heats,
                   double speed_exponent) {
  Conditions conditions;
  conditions.speed_exponent = speed_exponent;
  if (cache.empty()) return make_truth(model, parameters, seed, heats, conditions);
  std::filesystem::create_directories(cache);
  const std::string path = cache + "/truth_" + std::to_string(model.places.size()) + "_" + std::to_string(seed) +
                           (heats == HeatErrors::independent ? "_A_" : "_B_") +
                           std::to_string(std::lround(1000.0 * speed_exponent));
  // Raw numbers for this program on this computer.
  const auto each = [](Truth& truth, const auto& number) {
    for (double& value : truth.theta) number(value);
    for (rom::OperatingState& state : truth.read) {
      number(state.speed_rpm);
      number(state.load);
      for (double& value : state.environment_K) number(value);
    }
    for (double& value : truth.key_points_K.reshaped()) number(value);
    for (double& value : truth.measured_K.reshaped()) number(value);
    for (double& value : truth.nose_m) number(value);
    for (double& value : truth.touch_off_m) number(value);
    for (double& value : truth.rotor_K) number(value);
  };
  if (std::ifstream file(path, std::ios::binary); file) {
    const auto samples = static_cast<Eigen::Index>(std::lround(run_s / sample_s)) + 1;
    const auto key_points = static_cast<Eigen::Index>(model.key_points.size());
    Truth truth{seed, heats, conditions, Eigen::VectorXd::Zero(parameters.count()), {}, {}, {}, {}, {}, {}};
    truth.read.assign(static_cast<std::size_t>(samples), model.boundaries.operating);
    truth.key_points_K = truth.measured_K = Eigen::MatrixXd::Zero(samples, key_points);
    truth.nose_m = truth.touch_off_m = truth.rotor_K = Eigen::VectorXd::Zero(samples);
    each(truth, [&](double& value) { file.read(reinterpret_cast<char*>(&value), sizeof value); });
    if (file) return truth;
  }
  Truth truth = make_truth(model, parameters, seed, heats, conditions);
  std::ofstream file(path + ".part", std::ios::binary);
  each(truth, [&](double& value) { file.write(reinterpret_cast<const char*>(&value), sizeof value); });
  file.close();
  if (file) std::filesystem::rename(path + ".part", path);
  return truth;
}

}  // namespace spindle_twin::bench
