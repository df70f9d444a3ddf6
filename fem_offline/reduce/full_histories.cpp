#include "fem_offline/reduce/full_histories.hpp"

namespace spindle_twin::fem_offline {

Eigen::MatrixXd full_history(const AffineModel& model, AnalysedSystem& matrices, const History& history) {
  HeldSystem& system = matrices.system;
  const double datum_K = model.boundaries.reference_temperature_K;
  Eigen::MatrixXd fields(model.capacity_J_per_K.rows(), history.fields());
  Eigen::VectorXd rise_K;
  std::size_t held = 0;
  system.hold(history.states[held], datum_K);
  if (history.uniform_rise_K) {
    rise_K.setConstant(fields.rows(), *history.uniform_rise_K);
  } else {
    system.factor(&matrices.analysed).solve(system.load_W(), system.circuits(), rise_K);
  }
  Eigen::Index column = 0;
  fields.col(column++) = rise_K;
  for (const HistoryStep& step : history.steps) {
    if (step.state != held) system.hold(history.states[held = step.state], datum_K);
    const Eigen::VectorXd heat_J = step.step_s * system.load_W() + system.stored_J(rise_K);
    system.factor(step.step_s, &matrices.analysed).solve(heat_J, system.circuits(), rise_K);
    fields.col(column++) = rise_K;
  }
  return fields;
}

}  // namespace spindle_twin::fem_offline
