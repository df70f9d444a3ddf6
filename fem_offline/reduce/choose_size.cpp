#include "fem_offline/reduce/choose_size.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

namespace spindle_twin::fem_offline {
namespace {

Tolerance worst_of(const Eigen::MatrixXd& errors, const OutputLayout& layout) {
  const auto worst = [&](Eigen::Index first, Eigen::Index count) {
    return count > 0 ? errors.middleRows(first, count).maxCoeff() : 0.0;
  };
  return {worst(0, layout.key_points), worst(layout.deformations_at(), layout.deformations) * 1e6,
          worst(layout.maxima_at(), layout.parts)};
}

bool keeps(const Tolerance& reached, const Tolerance& tolerance) {
  return reached.key_points_K <= share_of_tolerance * tolerance.key_points_K &&
         reached.deformations_um <= share_of_tolerance * tolerance.deformations_um &&
         reached.part_max_K <= share_of_tolerance * tolerance.part_max_K;
}

}  // namespace

SizeChoice choose_size(const AffineModel& model, const Reduction& reduction, const Tolerance& tolerance,
                       const ReduceOptions& options, const Progress& progress, ReduceReport* report,
                       std::uint32_t cases) {
  using Clock = std::chrono::steady_clock;
  const auto started = Clock::now();
  VerifyOptions drives;
  drives.cases = cases;
  drives.seed = options.seed;
  drives.threads = options.threads;
  drives.drive.box = options.box;
  drives.drive.purpose = StreamPurpose::size_choice;
  const std::vector<FeTrajectory> trajectories = run_fe_cases(model, drives, [&](const std::string&, double fraction) {
    if (progress) progress("size of the network", 0.5 * fraction);
  });

  const OutputLayout layout = output_layout(model);
  const int most = std::min(largest_size, reduction.most_nodes());
  // Sizes are size_step · k, the last one `most`.
  int too_small = 0, enough = (most + size_step - 1) / size_step;
  const int sizes = enough;
  SizeChoice choice;
  std::optional<rom::Network> best;
  while (enough - too_small > 1 || !best) {
    // Large networks cost most: start below the middle, and try the largest only if all others fail.
    const int at = enough - too_small > 1 ? too_small + std::max(1, 2 * (enough - too_small) / 5) : sizes;
    const int nodes = std::max(2, std::min(size_step * at, most));
    ReduceReport trial;
    rom::Network network = reduction.network(nodes, &trial);
    const Tolerance reached = worst_of(case_errors(network, trajectories, options.threads), layout);
    choice.tried.push_back({nodes, reached});
    choice.reached = keeps(reached, tolerance) || choice.reached;
    if (keeps(reached, tolerance) || at == sizes) {
      best = std::move(network);
      if (report) report->condition = trial.condition;
      enough = at;
      if (at == sizes) break;
    } else {
      too_small = at;
    }
    if (progress)
      progress("size of the network", std::min(0.99, 0.5 + 0.08 * static_cast<double>(choice.tried.size())));
  }
  choice.network = std::move(*best);
  if (report) {
    report->stages.push_back({"size of the network", std::chrono::duration<double>(Clock::now() - started).count()});
  }
  if (progress) progress("size of the network", 1.0);
  return choice;
}

}  // namespace spindle_twin::fem_offline
