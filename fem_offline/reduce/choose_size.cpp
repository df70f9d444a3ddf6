#include "fem_offline/reduce/choose_size.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "fem_offline/reduce/history_errors.hpp"
#include "fem_offline/reduce/stage_clock.hpp"
#include "fem_offline/reduce/trajectory.hpp"
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

/// Outputs of one kind that err more than is wanted of them.
template <typename Items>
void add_missed(std::vector<MissedOutput>& missed, MissedOutput::Kind kind, const Items& items,
                const Eigen::VectorXd& worst, double tolerance) {
  const double wanted = share_of_tolerance * tolerance;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const double error = worst[static_cast<Eigen::Index>(i)];
    if (error > wanted) missed.push_back({kind, items[i].name, error, wanted});
  }
}

std::vector<MissedOutput> missed_outputs(const AffineModel& model, const Eigen::MatrixXd& errors,
                                         const Tolerance& tolerance) {
  using Kind = MissedOutput::Kind;
  const OutputLayout layout = output_layout(model);
  const Eigen::VectorXd worst = errors.rowwise().maxCoeff();
  std::vector<MissedOutput> missed;
  add_missed(missed, Kind::key_point, model.key_points, worst.head(layout.key_points), tolerance.key_points_K);
  add_missed(missed, Kind::deformation, model.deformations,
             rom::um_per_m * worst.segment(layout.deformations_at(), layout.deformations), tolerance.deformations_um);
  add_missed(missed, Kind::part_maximum, model.parts, worst.segment(layout.maxima_at(), layout.parts),
             tolerance.part_max_K);
  std::sort(missed.begin(), missed.end(), [](const MissedOutput& one, const MissedOutput& other) {
    return one.worst / one.wanted > other.worst / other.wanted;
  });
  return missed;
}

constexpr double usual_rate_per_node = -0.02;  ///< of the logarithm of the errors

struct TriedStep {
  int step;
  double logarithm;  ///< of the excess
};

/// Of the sizes that miss the tolerance the one that comes nearest to it.
struct Nearest {
  TriedStep tried{0, std::numeric_limits<double>::infinity()};
  std::vector<MissedOutput> missed;
};

/// Errors fall about exponentially with the size, so the first enough one is sought at the usual rate from the last
/// that was too small. Between the two they go up and down by the luck of single cases, where secants would creep:
/// halves.
int next_step(const std::optional<TriedStep>& last, int too_small, int enough, bool enough_tried) {
  constexpr double usual_rate = usual_rate_per_node * size_step;
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
  StageClock clock(report);
  const std::vector<FeHistory> histories =
      run_fe_histories(model, options, search.histories,
                       [&](const std::string&, double fraction) { show("size: FE histories", fraction); });
  clock.finish("size: FE histories");

  const OutputLayout layout = output_layout(model);
  const int most = std::min(largest_size, reduction.most_nodes());
  const auto nodes_of = [&](int step) { return std::max(2, std::min(size_step * step, most)); };
  // The largest is not tried before all others have failed: it costs most.
  int too_small = 0, enough = (most + size_step - 1) / size_step + 1;
  const int last_step = enough - 1;
  SizeChoice choice;
  PartExtremes extremes;
  std::optional<TriedStep> last;
  Nearest nearest;
  while (enough - too_small > 1) {
    const int step = next_step(last, too_small, enough, enough <= last_step);
    const int nodes = nodes_of(step);
    const std::string stage = "size: " + std::to_string(nodes) + " nodes";
    show(stage, 0.0);
    const rom::Network network = reduction.network(nodes, nullptr, {}, &extremes);
    show(stage, 0.5);
    const Eigen::MatrixXd errors = history_errors(network, histories, options.threads);
    const Tolerance reached = worst_of(errors, layout);
    show(stage, 1.0);
    choice.tried.push_back({nodes, reached});
    last = TriedStep{step, std::log(excess(reached, search.tolerance))};
    (last->logarithm <= 0.0 ? enough : too_small) = step;
    if (last->logarithm < nearest.tried.logarithm) nearest = {*last, missed_outputs(model, errors, search.tolerance)};
  }
  choice.reached = enough <= last_step;
  clock.finish("size: " + std::to_string(choice.tried.size()) + " tried");
  const int chosen = nodes_of(choice.reached ? enough : nearest.tried.step);
  if (!choice.reached) {
    choice.missed = std::move(nearest.missed);
    if (most == largest_size) {
      choice.nodes_likely_enough = chosen + static_cast<int>(std::ceil(nearest.tried.logarithm / -usual_rate_per_node));
    }
  }
  choice.network = reduction.network(chosen, report, progress);
  return choice;
}

}  // namespace spindle_twin::fem_offline
