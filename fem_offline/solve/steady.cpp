#include <set>

#include "fem_offline/solve/coolant_coupling.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "fem_offline/solve/held_system.hpp"

namespace spindle_twin::fem_offline {

Eigen::VectorXd solve_steady(const AffineModel& model, const rom::BoundaryValues& values) {
  if (model.imposed_rises_K) return model.imposed_rises_K->array() + model.boundaries.reference_temperature_K;
  // Counted from an environment's temperature: the rise is some ten kelvin, the absolute temperature three hundred.
  const double datum_K = values.environment_K.size() > 0 ? values.environment_K[0] : 0.0;
  HeldSystem system(model);
  system.hold(values, datum_K);
  CoupledFactor factor = system.factor(nullptr);
  Eigen::VectorXd rise_K, correction_K, residual_W;
  factor.solve(system.load_W(), system.circuits(), rise_K);
  // One step of refinement brings the heat balance from 1e-10 to rounding.
  system.net_heat_W(rise_K, residual_W);
  factor.solve(residual_W, system.circuits(), correction_K);
  return (rise_K + correction_K).array() + datum_K;
}

HeatBalance heat_balance(const AffineModel& model, const rom::BoundaryValues& values,
                         const Eigen::VectorXd& temperatures_K) {
  HeatBalance balance;
  balance.heat_in_W = values.heat_W.sum();
  const std::vector<int> segments = rom::coolant_segments(model.boundaries).conductance;
  const std::set<int> of_a_circuit(segments.begin(), segments.end());
  for (std::size_t j = 0; j < model.conductance_terms_m2.size(); ++j) {
    const int environment = model.boundaries.conductances[j].environment;
    if (environment < 0 || of_a_circuit.contains(static_cast<int>(j))) continue;
    const Eigen::VectorXd above_K = temperatures_K.array() - values.environment_K[environment];
    balance.heat_out_W +=
        values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * (model.conductance_terms_m2[j] * above_K).sum();
  }
  balance.heat_out_W += coolant_outlets(model, values, temperatures_K).heat_W.sum();
  return balance;
}

rom::CoolantOutlets coolant_outlets(const AffineModel& model, const rom::BoundaryValues& values,
                                    const Eigen::VectorXd& temperatures_K) {
  const CoolantCoupling coupling(model);
  rom::CoolantOutlets outlets;
  outlets.outlet_K = outlets.heat_W =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.boundaries.circuits.size()));
  if (!coupling.empty()) rom::march_coolant(coupling.segments(), values, coupling.walls_K(temperatures_K), outlets);
  return outlets;
}

}  // namespace spindle_twin::fem_offline
