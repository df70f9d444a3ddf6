#include "fem_offline/reduce/full_histories.hpp"

#include "fem_offline/solve/coolant_coupling.hpp"

namespace spindle_twin::fem_offline {

Eigen::MatrixXd full_history(const AffineModel& model, AnalysedSystem& matrices, const History& history) {
  ThermalSystem& system = matrices.system;
  const CholeskyAnalysis& analysed = matrices.analysed;
  const double datum_K = model.boundaries.reference_temperature_K;
  CoolantCoupling coupling(model);
  Eigen::VectorXd load_W;
  const auto hold = [&](const rom::BoundaryValues& values) {
    system.set_conductances(values.conductance_W_per_m2K);
    coupling.hold(values);
    load_W = system.load_W(values, datum_K);
    coupling.add_load(datum_K, load_W);
  };

  Eigen::MatrixXd fields(model.capacity_J_per_K.rows(), history.fields());
  Eigen::VectorXd rise_K;
  std::size_t held = 0;
  hold(history.states[held]);
  if (history.uniform_rise_K) {
    rise_K.setConstant(fields.rows(), *history.uniform_rise_K);
  } else {
    CoupledFactor(CholeskyFactor(analysed, system.conduction_lower()), coupling, 1.0).solve(load_W, coupling, rise_K);
  }
  Eigen::Index column = 0;
  fields.col(column++) = rise_K;
  const auto capacity = system.capacity_lower().selfadjointView<Eigen::Lower>();
  for (const HistoryStep& step : history.steps) {
    if (step.state != held) hold(history.states[held = step.state]);
    CoupledFactor factor(CholeskyFactor(analysed, system.combined_lower(step.step_s)), coupling, step.step_s);
    const Eigen::VectorXd heat_J = step.step_s * load_W + capacity * rise_K;
    factor.solve(heat_J, coupling, rise_K);
    fields.col(column++) = rise_K;
  }
  return fields;
}

}  // namespace spindle_twin::fem_offline
