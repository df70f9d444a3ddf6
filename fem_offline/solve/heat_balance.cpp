#include <algorithm>

#include "fem_offline/solve/coolant_coupling.hpp"
#include "fem_offline/solve/fe_solver.hpp"

namespace spindle_twin::fem_offline {

HeatBalance steady_heat_balance(const AffineModel& model, const rom::BoundaryValues& values,
                                const Eigen::VectorXd& temperatures_K) {
  const double datum_K = values.environment_K.size() > 0 ? values.environment_K[0] : 0.0;
  const Eigen::VectorXd rise_K = temperatures_K.array() - datum_K;
  CoolantCoupling coupling(model);
  coupling.hold(values);
  // What every unknown still has to give away: at the held ones that is their reaction, at all others nothing.
  Eigen::VectorXd left_W = model.source_distribution * values.heat_W - model.conduction_W_per_K * rise_K;
  coupling.add_load(datum_K, left_W);
  coupling.add_heat(rise_K, left_W);
  HeatBalance balance;
  balance.heat_in_W = balance.heat_through_W = values.heat_W.sum();
  Eigen::VectorXd held_m2 = Eigen::VectorXd::Zero(rise_K.size());
  for (const int j : model.held) held_m2 += model.conductance_terms_m2[j] * Eigen::VectorXd::Ones(rise_K.size());
  const std::vector<int> segments = rom::coolant_segments(model.boundaries).conductance;
  for (int j = 0; j < static_cast<int>(model.conductance_terms_m2.size()); ++j) {
    if (std::find(model.held.begin(), model.held.end(), j) != model.held.end()) continue;
    const int environment = model.boundaries.conductances[j].environment;
    Eigen::VectorXd above_K = rise_K;
    if (environment >= 0) above_K.array() -= values.environment_K[environment] - datum_K;
    const Eigen::VectorXd leaving_W = values.conductance_W_per_m2K[j] * (model.conductance_terms_m2[j] * above_K);
    left_W -= leaving_W;
    if (environment < 0 || std::find(segments.begin(), segments.end(), j) != segments.end()) continue;
    const double out_W = leaving_W.sum();
    balance.heat_out_W += out_W;
    balance.heat_through_W += std::max(0.0, -out_W);
  }
  for (Eigen::Index i = 0; i < held_m2.size(); ++i) {
    if (held_m2[i] == 0.0) continue;
    balance.heat_out_W += left_W[i];
    balance.heat_through_W += std::max(0.0, -left_W[i]);
  }
  const Eigen::VectorXd by_coolant_W = coolant_outlets(model, values, temperatures_K).heat_W;
  balance.heat_out_W += by_coolant_W.sum();
  balance.heat_through_W += (-by_coolant_W).cwiseMax(0.0).sum();
  return balance;
}

}  // namespace spindle_twin::fem_offline
