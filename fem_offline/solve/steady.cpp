#include "fem_offline/solve/cholesky.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/thermal_system.hpp"

namespace spindle_twin::fem_offline {

Eigen::VectorXd solve_steady(const AffineModel& model, const rom::BoundaryValues& values) {
  ThermalSystem system(model);
  system.set_conductances(values.conductance_W_per_m2K);
  // Counted from an environment's temperature: the rise is some ten kelvin, the absolute temperature three hundred.
  const double datum_K = values.environment_K.size() > 0 ? values.environment_K[0] : 0.0;
  CholeskyFactor factor(system.conduction_lower());
  const Eigen::VectorXd load_W = system.load_W(values, datum_K);
  Eigen::VectorXd rise_K, correction_K;
  factor.solve(load_W, rise_K);
  // One step of refinement brings the heat balance from 1e-10 to rounding.
  factor.solve(load_W - system.conduction_lower().selfadjointView<Eigen::Lower>() * rise_K, correction_K);
  return (rise_K + correction_K).array() + datum_K;
}

HeatBalance heat_balance(const AffineModel& model, const rom::BoundaryValues& values,
                         const Eigen::VectorXd& temperatures_K) {
  HeatBalance balance;
  balance.heat_in_W = values.heat_W.sum();
  for (std::size_t j = 0; j < model.conductance_terms_m2.size(); ++j) {
    const int environment = model.boundaries.conductances[j].environment;
    if (environment < 0) continue;
    const Eigen::VectorXd above_K = temperatures_K.array() - values.environment_K[environment];
    balance.heat_out_W +=
        values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * (model.conductance_terms_m2[j] * above_K).sum();
  }
  return balance;
}

}  // namespace spindle_twin::fem_offline
