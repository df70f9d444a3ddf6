#include "fem_offline/reduce/choose_size.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

namespace spindle_twin::fem_offline {
namespace {

Tolerance worst_of(const Eigen::MatrixXd& errors, const OutputLayout& layout) {
  const auto worst = [&](Eigen::Index first, Eigen::Index count) {
    return count > 0 ? errors.middleRows(first, count).maxCoeff() : 0.0;
  };
  return {worst(0, layout.key_points), worst(layout.deformations_at(), layout.deformations) * 1e6,
          worst(layout.maxima_at(), layout.parts)};
}

/// How many times the share of the tolerance that the search asks for; at most 1 keeps it.
double excess(const Tolerance& reached, const Tolerance& tolerance) {
  return std::max({reached.key_points_K / tolerance.key_points_K, reached.deformations_um / tolerance.deformations_um,
                   reached.part_max_K / tolerance.part_max_K}) /
         share_of_tolerance;
}

struct TriedStep {
  int step;
  double logarithm;  ///< of the excess
};

/// Errors fall about exponentially with the size, so the next step to try is where the line through the logarithms
/// comes to zero: between the two that bracket it, else from the last one at the usual rate.
int next_step(const std::vector<TriedStep>& tried, int too_small, int enough) {
  constexpr double usual_rate = -0.02 * size_step;
  if (tried.empty()) return (too_small + enough) / 2;
  const auto at = [&](int step) {
    return std::find_if(tried.begin(), tried.end(), [&](const TriedStep& item) { return item.step == step; });
  };
  const auto low = at(too_small), high = at(enough);
  const bool bracketed = low != tried.end() && high != tried.end();
  const TriedStep& from = tried.back();
  const double rate = bracketed ? (high->logarithm - low->logarithm) / (high->step - low->step) : usual_rate;
  const double wanted = std::ceil(from.step - from.logarithm / rate);
  return static_cast<int>(std::clamp(wanted, too_small + 1.0, enough - 1.0));
}

}  // namespace

SizeChoice choose_size(const AffineModel& model, const Reduction& reduction, const Tolerance& tolerance,
                       const ReduceOptions& options, const Progress& progress, ReduceReport* report,
                       std::uint32_t cases) {
  const auto show = [&](const std::string& stage, double fraction) {
    if (progress) progress(stage, fraction);
  };
  using Clock = std::chrono::steady_clock;
  auto started = Clock::now();
  const auto finish = [&](const std::string& stage) {
    const auto now = Clock::now();
    if (report) report->stages.push_back({stage, std::chrono::duration<double>(now - started).count()});
    started = now;
  };
  VerifyOptions drives;
  drives.cases = cases;
  drives.seed = options.seed;
  drives.threads = options.threads;
  drives.drive.box = options.box;
  drives.drive.purpose = StreamPurpose::size_choice;
  const std::vector<FeTrajectory> trajectories =
      run_fe_cases(model, drives, [&](const std::string&, double fraction) { show("size: FE cases", fraction); });
  finish("size: FE cases");

  const OutputLayout layout = output_layout(model);
  const int most = std::min(largest_size, reduction.most_nodes());
  const auto nodes_of = [&](int step) { return std::max(2, std::min(size_step * step, most)); };
  // The largest is not tried before all others have failed: it costs most.
  int too_small = 0, enough = (most + size_step - 1) / size_step + 1;
  const int last_step = enough - 1;
  SizeChoice choice;
  PartExtremes extremes;
  std::vector<TriedStep> tried;
  while (enough - too_small > 1) {
    const int step = next_step(tried, too_small, enough);
    const int nodes = nodes_of(step);
    const std::string stage = "size: " + std::to_string(nodes) + " nodes";
    show(stage, 0.0);
    const rom::Network network = reduction.network(nodes, nullptr, {}, &extremes);
    show(stage, 0.5);
    const Tolerance reached = worst_of(case_errors(network, trajectories, options.threads), layout);
    show(stage, 1.0);
    choice.tried.push_back({nodes, reached});
    tried.push_back({step, std::log(excess(reached, tolerance))});
    (tried.back().logarithm <= 0.0 ? enough : too_small) = step;
  }
  choice.reached = enough <= last_step;
  finish("size: " + std::to_string(tried.size()) + " tried");
  choice.network = reduction.network(nodes_of(std::min(enough, last_step)), report, progress);
  return choice;
}

}  // namespace spindle_twin::fem_offline
