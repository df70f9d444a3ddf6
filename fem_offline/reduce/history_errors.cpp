#include "fem_offline/reduce/history_errors.hpp"

#include <algorithm>
#include <atomic>
#include <utility>

#include "fem_offline/reduce/analysed_system.hpp"
#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/full_histories.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "rom/integrate/coolant.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// The reduced model along a history: rises above the reference temperature, a column per field.
Eigen::MatrixXd follow_history(const DenseModel& model, const rom::Boundaries& boundaries, const History& history) {
  const rom::CoolantSegments segments = rom::coolant_segments(boundaries);
  HeldModel held;
  const auto hold = [&](const rom::BoundaryValues& values) {
    hold_inputs(model, boundaries, segments, values, boundaries.reference_temperature_K, held);
  };
  std::size_t state = 0;
  hold(history.states[state]);
  Eigen::MatrixXd rises_K(model.capacity.rows(), history.fields());
  if (history.uniform_rise_K) {
    rises_K.col(0) = *history.uniform_rise_K * model.uniform;
  } else {
    rises_K.col(0) = ShiftedModel(model, held, 0.0).solve(held.drive);
  }
  Eigen::Index column = 1;
  for (const HistoryStep& step : history.steps) {
    if (step.state != state) hold(history.states[state = step.state]);
    const double rate_per_s = 1.0 / step.step_s;
    const Eigen::VectorXd heat_W = held.drive + rate_per_s * (model.capacity * rises_K.col(column - 1));
    rises_K.col(column++) = ShiftedModel(model, held, rate_per_s).solve(heat_W);
  }
  return rises_K;
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
  for_each_index(static_cast<int>(histories.size()), threads, [&](int index, int) {
    const FeHistory& item = histories[static_cast<std::size_t>(index)];
    const Eigen::MatrixXd rises_K = follow_history(reduced.dense, model.boundaries, item.history);
    errors.col(index) = (outputs_of(reduced.outputs, rises_K) - item.outputs).cwiseAbs().rowwise().maxCoeff();
  });
  return errors;
}

}  // namespace spindle_twin::fem_offline
