#include "fem_offline/model/source_terms.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// ∫ N_i over the share's volume or faces; sums to that volume or area.
Eigen::VectorXd function_extent(const HeatSource& heat, const HeatShare& share, const Spindle& spindle,
                                const Section& section, const SurfaceRules& rules,
                                const std::vector<Eigen::VectorXd>& function_volume_m3) {
  if (!share.on_contact_with && !share.on_face) {
    return function_volume_m3[share.part];
  }
  Eigen::VectorXd area_m2 = Eigen::VectorXd::Zero(function_volume_m3[share.part].size());
  for (std::size_t p = 0; p < section.pieces.size(); ++p) {
    if (!carries(spindle, section.pieces[p], share)) continue;
    for (const SurfacePoint& point : rules.pieces[p]) {
      for (std::size_t i = 0; i < point.trace.dofs.size(); ++i) {
        area_m2[point.trace.dofs[i]] += point.weight_m2 * point.trace.values[i];
      }
    }
  }
  if (!(area_m2.sum() > 0.0)) {
    throw rom::InputError(heat.where, heat.name,
                          "a share of this heat lies on no face of part '" + spindle.parts[share.part].name + "'");
  }
  return area_m2;
}

/// Heat of each share, whose volume or area is given. [W]
std::vector<double> shares_W(const HeatSource& heat, const std::vector<double>& extents,
                             const std::vector<Eigen::VectorXd>& function_volume_m3) {
  double total_W = heat.heat_W.value_or(0.0);
  for (const std::size_t part : heat.density_over) {
    total_W += heat.density_W_per_m3.value_or(0.0) * function_volume_m3[part].sum();
  }
  const bool by_extent = !heat.heat_W && heat.density_over.empty();
  const double per_extent = heat.flux_W_per_m2.value_or(heat.density_W_per_m3.value_or(0.0));
  std::vector<double> result;
  for (std::size_t i = 0; i < heat.shares.size(); ++i) {
    result.push_back(heat.shares[i].weight * (by_extent ? per_extent * extents[i] : total_W));
  }
  return result;
}

}  // namespace

SourceTerms source_terms(const Spindle& spindle, const Section& section, const SurfaceRules& rules, int unknowns,
                         const std::vector<Eigen::VectorXd>& function_volume_m3) {
  SourceTerms terms;
  terms.distribution = Eigen::MatrixXd::Zero(unknowns, static_cast<Eigen::Index>(spindle.heats.size()));
  for (std::size_t s = 0; s < spindle.heats.size(); ++s) {
    const HeatSource& heat = spindle.heats[s];
    std::vector<Eigen::VectorXd> spreads;
    std::vector<double> extents;
    for (const HeatShare& share : heat.shares) {
      spreads.push_back(function_extent(heat, share, spindle, section, rules, function_volume_m3));
      extents.push_back(spreads.back().sum());
    }
    const std::vector<double> heat_W = shares_W(heat, extents, function_volume_m3);
    double total_W = 0.0;
    for (const double share_W : heat_W) total_W += share_W;
    auto column = terms.distribution.col(static_cast<Eigen::Index>(s));
    for (std::size_t i = 0; i < heat.shares.size(); ++i) {
      // A source that is off at the reference state still needs a place to act.
      const double fraction = total_W > 0.0 ? heat_W[i] / total_W : 1.0 / static_cast<double>(heat.shares.size());
      column.head(spreads[i].size()) += fraction / extents[i] * spreads[i];
    }
    column /= column.sum();
    terms.sources.push_back({heat.name, total_W, heat.law, heat.physics, false, heat.friction});
  }
  return terms;
}

}  // namespace spindle_twin::fem_offline
