#include "fem_offline/reduce/choose_size.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>

#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

Tolerance worst_of(const Eigen::MatrixXd& errors, const OutputLayout& layout) {
  const auto worst = [&](Eigen::Index first, Eigen::Index count) {
    return count > 0 ? errors.middleRows(first, count).maxCoeff() : 0.0;
  };
  return {worst(0, layout.key_points), worst(layout.deformations_at(), layout.deformations) * rom::um_per_m,
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

/// Errors fall about exponentially with the size, so the first enough one is sought at the usual rate from the last
/// that was too small. Between the two they go up and down by the luck of single cases, where secants would creep:
/// halves.
int next_step(const std::optional<TriedStep>& last, int too_small, int enough, bool enough_tried) {
  constexpr double usual_rate = -0.02 * size_step;
  if (!last || (enough_tried && too_small > 0)) return (too_small + enough) / 2;
  const double wanted = std::ceil(last->step - last->logarithm / usual_rate);
  return static_cast<int>(std::clamp(wanted, too_small + 1.0, enough - 1.0));
}

}  // namespace

SizeChoice choose_size(const AffineModel& model, const Reduction& reduction, const SizeSearch& search,
                       const ReduceOptions& options, const Progress& progress, ReduceReport* report) {
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
  drives.cases = search.cases;
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
  std::optional<TriedStep> last;
  while (enough - too_small > 1) {
    const int step = next_step(last, too_small, enough, enough <= last_step);
    const int nodes = nodes_of(step);
    const std::string stage = "size: " + std::to_string(nodes) + " nodes";
    show(stage, 0.0);
    const rom::Network network = reduction.network(nodes, nullptr, {}, &extremes);
    show(stage, 0.5);
    const Tolerance reached = worst_of(case_errors(network, trajectories, options.threads), layout);
    show(stage, 1.0);
    choice.tried.push_back({nodes, reached});
    last = TriedStep{step, std::log(excess(reached, search.tolerance))};
    (last->logarithm <= 0.0 ? enough : too_small) = step;
  }
  choice.reached = enough <= last_step;
  finish("size: " + std::to_string(choice.tried.size()) + " tried");
  choice.network = reduction.network(nodes_of(std::min(enough, last_step)), report, progress);
  return choice;
}

}  // namespace spindle_twin::fem_offline
