#include "fem_offline/reduce/choose_size.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "fem_offline/reduce/error_limit.hpp"
#include "fem_offline/reduce/history_errors.hpp"
#include "fem_offline/reduce/stage_clock.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// What at most 1 − size_choice_content of all histories exceed, by those that gave `errors`; the largest where they
/// are too few to say.
double limit_of_histories(const Eigen::RowVectorXd& errors) {
  const int rank = limiting_rank(static_cast<int>(errors.size()), size_choice_content);
  return error_of_rank({errors.begin(), errors.end()}, std::max(rank, 1));
}

struct HistoryLimits {
  Tolerance of_kinds{};        ///< of the largest error of each kind of output in a history
  Eigen::VectorXd of_outputs;  ///< of each output, SI; of those of one kind the largest is that of the kind
};

HistoryLimits limits_of(const Eigen::MatrixXd& errors, const OutputLayout& layout) {
  HistoryLimits limits;
  limits.of_outputs.resize(errors.rows());
  for (Eigen::Index i = 0; i < errors.rows(); ++i) limits.of_outputs[i] = limit_of_histories(errors.row(i));
  const auto of_kind = [&](Eigen::Index first, Eigen::Index count) {
    if (count == 0) return 0.0;
    Eigen::Index most = 0;
    limits.of_outputs.segment(first, count).maxCoeff(&most);
    return limits.of_outputs[first + most] = limit_of_histories(errors.middleRows(first, count).colwise().maxCoeff());
  };
  limits.of_kinds.key_points_K = of_kind(0, layout.key_points);
  limits.of_kinds.deformations_um = of_kind(layout.deformations_at(), layout.deformations) * rom::um_per_m;
  limits.of_kinds.part_max_K = of_kind(layout.maxima_at(), layout.parts);
  return limits;
}

/// How many times what is wanted; at most 1 keeps it.
double excess(const Tolerance& reached, const Tolerance& wanted) {
  return std::max({reached.key_points_K / wanted.key_points_K, reached.deformations_um / wanted.deformations_um,
                   reached.part_max_K / wanted.part_max_K});
}

/// What the search asks for of the tolerance.
Tolerance with_margin(const Tolerance& tolerance) {
  return {share_of_tolerance * tolerance.key_points_K, share_of_tolerance * tolerance.deformations_um,
          share_of_tolerance * tolerance.part_max_K};
}

constexpr double usual_rate_per_node = -0.02;  ///< of the logarithm of the errors
constexpr int first_step = 20;                 ///< most spindles need about as many nodes for the usual tolerance

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
  if (!last) return std::min(first_step, (too_small + enough) / 2);
  if (enough_tried && too_small > 0) return (too_small + enough) / 2;
  const double expected = std::ceil(last->step - last->logarithm / usual_rate);
  return static_cast<int>(std::clamp(expected, too_small + 1.0, enough - 1.0));
}

/// Basis models of the sizes that are tried. A smaller one is part of a larger, so the FE model is projected on more
/// columns than are asked for, and anew where that was not enough.
class BasisModels {
 public:
  explicit BasisModels(const Reduction& reduction) : reduction_(reduction) {}

  BasisModel of(int nodes) {
    constexpr double headroom = 1.25;
    if (widest_.capacity.rows() < nodes) {
      const int columns = std::min(static_cast<int>(headroom * nodes), reduction_.most_nodes());
      widest_ = {};  // before the next takes its memory
      widest_ = reduction_.dense_model(columns);
    }
    BasisModel model{first_states(widest_, nodes), {}};
    if (extremes_.empty()) extremes_ = reduction_.part_extremes(model.dense);
    model.outputs = reduction_.output_rows(nodes, extremes_);
    return model;
  }

  /// Points of part extremes of the first size, which all sizes have.
  PartExtremes& extremes() { return extremes_; }

 private:
  const Reduction& reduction_;
  DenseModel widest_;
  PartExtremes extremes_;
};

}  // namespace

int nodes_likely_enough(int nodes, const std::vector<MissedOutput>& missed) {
  return nodes + static_cast<int>(std::ceil(std::log(missed.front().ratio()) / -usual_rate_per_node));
}

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
  const Tolerance wanted = with_margin(search.tolerance);
  const int most = std::min(largest_size, reduction.most_nodes());
  const auto nodes_of = [&](int step) { return std::max(2, std::min(size_step * step, most)); };
  // The largest is not tried before all others have failed: it costs most.
  int too_small = 0, enough = (most + size_step - 1) / size_step + 1;
  const int last_step = enough - 1;
  SizeChoice choice;
  BasisModels models(reduction);
  std::optional<TriedStep> last;
  Nearest nearest;
  while (enough - too_small > 1) {
    const int step = next_step(last, too_small, enough, enough <= last_step);
    const int nodes = nodes_of(step);
    const std::string stage = "size: " + std::to_string(nodes) + " nodes";
    show(stage, 0.0);
    const BasisModel reduced = models.of(nodes);
    show(stage, 0.5);
    const Eigen::MatrixXd errors = history_errors(model, reduced, histories, options.threads);
    const HistoryLimits reached = limits_of(errors, layout);
    show(stage, 1.0);
    choice.tried.push_back({nodes, reached.of_kinds});
    last = TriedStep{step, std::log(excess(reached.of_kinds, wanted))};
    (last->logarithm <= 0.0 ? enough : too_small) = step;
    if (last->logarithm < nearest.tried.logarithm) {
      nearest = {*last, missed_outputs(model, reached.of_outputs, wanted)};
    }
  }
  choice.reached = enough <= last_step;
  clock.finish("size: " + std::to_string(choice.tried.size()) + " tried");
  const int chosen = nodes_of(choice.reached ? enough : nearest.tried.step);
  if (!choice.reached) choice.missed = std::move(nearest.missed);
  choice.larger_possible = most == largest_size;
  choice.network = reduction.network(chosen, report, progress, &models.extremes());
  return choice;
}

rom::Network grow_until_kept(rom::Network first, std::vector<MissedOutput> missed, int largest,
                             const GrowSteps& steps) {
  rom::Network best = std::move(first);
  int nodes = static_cast<int>(best.nodes.size());
  double least = missed.empty() ? 0.0 : missed.front().ratio();
  for (int round = 1; !missed.empty() && nodes < largest; ++round) {
    const int wanted = nodes_likely_enough(nodes, missed) + size_step;
    rom::Network larger = steps.network(std::min((wanted + size_step - 1) / size_step * size_step, largest));
    if (static_cast<int>(larger.nodes.size()) <= nodes) break;  // as many as the basis has
    nodes = static_cast<int>(larger.nodes.size());
    missed = steps.certify(larger, round);
    const double ratio = missed.empty() ? 0.0 : missed.front().ratio();
    if (ratio >= least) continue;
    least = ratio;
    best = std::move(larger);
  }
  return best;
}

}  // namespace spindle_twin::fem_offline
