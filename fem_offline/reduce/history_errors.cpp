#include "fem_offline/reduce/history_errors.hpp"

#include <algorithm>
#include <atomic>
#include <span>
#include <utility>

#include "fem_offline/reduce/analysed_system.hpp"
#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/full_histories.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "rom/integrate/coolant.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr int histories_at_once = 8;  ///< whose conductances are summed in one pass

/// The reduced model along a history: rises above the reference temperature, a column per field. `held_by(state)`: a
/// model that holds the conductances of this state of the history.
template <typename HeldBy>
Eigen::MatrixXd follow_history(const DenseModel& model, const rom::Boundaries& boundaries,
                               const rom::CoolantSegments& segments, const History& history, const HeldBy& held_by) {
  HeldModel held;
  const auto hold = [&](std::size_t state) {
    held = held_by(state);
    hold_inputs(model, boundaries, segments, history.states[state], boundaries.reference_temperature_K, held);
  };
  std::size_t state = 0;
  hold(state);
  Eigen::MatrixXd rises_K(model.capacity.rows(), history.fields());
  if (history.uniform_rise_K) {
    rises_K.col(0) = *history.uniform_rise_K * model.uniform;
  } else {
    rises_K.col(0) = ShiftedModel(model, held, 0.0).solve(held.drive);
  }
  Eigen::Index column = 1;
  for (const HistoryStep& step : history.steps) {
    if (step.state != state) hold(state = step.state);
    const double rate_per_s = 1.0 / step.step_s;
    const Eigen::VectorXd heat_W = held.drive + rate_per_s * (model.capacity * rises_K.col(column - 1));
    rises_K.col(column++) = ShiftedModel(model, held, rate_per_s).solve(heat_W);
  }
  return rises_K;
}

/// Conductances of every state of some histories in turn, a column each.
Eigen::MatrixXd conductances_of(std::span<const FeHistory> histories, Eigen::Index conductances) {
  Eigen::Index states = 0;
  for (const FeHistory& item : histories) states += static_cast<Eigen::Index>(item.history.states.size());
  Eigen::MatrixXd columns(conductances, states);
  Eigen::Index next = 0;
  for (const FeHistory& item : histories) {
    for (const rom::BoundaryValues& values : item.history.states) columns.col(next++) = values.conductance_W_per_m2K;
  }
  return columns;
}

}  // namespace

std::vector<FeHistory> run_fe_histories(const AffineModel& model, const ReduceOptions& options, int count,
                                        const Progress& progress) {
  const double datum_K = model.boundaries.reference_temperature_K;
  std::vector<AnalysedSystem> workers(static_cast<std::size_t>(std::clamp(options.threads, 1, std::max(count, 1))),
                                      AnalysedSystem(model));
  std::vector<FeHistory> histories(static_cast<std::size_t>(count));
  std::atomic<int> finished{0};
  for_each_index(count, options.threads, [&](int index, int worker) {
    FeHistory& item = histories[static_cast<std::size_t>(index)];
    item.history =
        random_history(model.boundaries, options, StreamPurpose::size_choice, static_cast<std::uint32_t>(index));
    const Eigen::MatrixXd fields = full_history(model, workers[static_cast<std::size_t>(worker)], item.history);
    item.outputs.resize(output_layout(model).total(), fields.cols());
    for (Eigen::Index i = 0; i < fields.cols(); ++i) {
      item.outputs.col(i) = fe_outputs(model, fields.col(i).array() + datum_K);
    }
    const int done = ++finished;
    if (worker == 0 && progress) progress("FE histories", static_cast<double>(done) / count);
  });
  return histories;
}

Eigen::MatrixXd history_errors(const AffineModel& model, const BasisModel& reduced,
                               const std::vector<FeHistory>& histories, int threads) {
  Eigen::MatrixXd errors(reduced.outputs.layout.total(), static_cast<Eigen::Index>(histories.size()));
  const DenseModel& dense = reduced.dense;
  const rom::CoolantSegments segments = rom::coolant_segments(model.boundaries);
  const std::span<const FeHistory> all = histories;
  const int count = static_cast<int>(histories.size());
  for_each_index((count + histories_at_once - 1) / histories_at_once, threads, [&](int group, int) {
    const int first = group * histories_at_once, width = std::min(histories_at_once, count - first);
    const auto own = all.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(width));
    const Eigen::MatrixXd conductances = conductances_of(own, dense.conductance_terms.count());
    const PackedTerms sums = dense.conductance_terms.sums(conductances);
    Eigen::Index first_state = 0;
    for (int i = 0; i < width; ++i) {
      const FeHistory& item = own[static_cast<std::size_t>(i)];
      const auto held_by = [&](std::size_t state) {
        const Eigen::Index sum = first_state + static_cast<Eigen::Index>(state);
        return hold_conductances(dense, sums, sum, conductances.col(sum));
      };
      const Eigen::MatrixXd rises_K = follow_history(dense, model.boundaries, segments, item.history, held_by);
      errors.col(first + i) = (outputs_of(reduced.outputs, rises_K) - item.outputs).cwiseAbs().rowwise().maxCoeff();
      first_state += static_cast<Eigen::Index>(item.history.states.size());
    }
  });
  return errors;
}

}  // namespace spindle_twin::fem_offline
