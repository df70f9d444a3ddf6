#pragma once

#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/model/surface_rules.hpp"

namespace spindle_twin::fem_offline {

/// The exchange matrices for 1 W/m²K with their records, in the order of description/model_places; n = places with the
/// air volumes last. Between bodies (contact, gap, air film) ∫ (u_A − u_B)(v_A − v_B) dA, rows sum to zero; to an
/// environment ∫ u v dA.
struct ExchangeTerms {
  std::vector<SparseMatrix> matrices_m2;
  std::vector<rom::Conductance> conductances;
  std::vector<int> held;  ///< those that prescribe a temperature
};

/// `air_unknown`: of each surrounding its unknown, -1 if it is an environment.
ExchangeTerms exchange_terms(const Spindle& spindle, const Section& section, const SurfaceRules& rules, int unknowns,
                             const std::vector<int>& air_unknown);

/// Lamé, thick-walled rings (plane stress): pressure per radial interference
///   p' = 1 / (b [ ((c²+b²)/(c²−b²) + ν_o)/E_o + ((b²+a²)/(b²−a²) − ν_i)/E_i ])   [Pa/m]
/// and from it pressure at assembly and per kelvin of each body, p' b α.
rom::JointFit joint_fit(const InterferenceFit& fit, const Material& inner, const Material& outer);

}  // namespace spindle_twin::fem_offline
