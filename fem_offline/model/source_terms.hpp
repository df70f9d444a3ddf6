#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/mesh/section.hpp"
#include "fem_offline/model/surface_rules.hpp"
#include "rom/boundaries.hpp"

namespace spindle_twin::fem_offline {

/// Heat sources with their distributions over the unknowns; every column sums to 1.
struct SourceTerms {
  std::vector<rom::HeatSource> sources;
  Eigen::MatrixXd distribution;  ///< unknowns x sources
};

/// `function_volume_m3`: per part ∫ N_i dV over the FE unknowns. Throws rom::InputError for a share on no face.
SourceTerms source_terms(const Spindle& spindle, const Section& section, const SurfaceRules& rules, int unknowns,
                         const std::vector<Eigen::VectorXd>& function_volume_m3);

}  // namespace spindle_twin::fem_offline
