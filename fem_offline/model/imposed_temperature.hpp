#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/model/affine_model.hpp"

namespace spindle_twin::fem_offline {

/// The formula's value at every place, 0 for air volumes. Variables r, z in m, r_mm, z_mm in mm; operators and
/// functions are muParser's. Throws rom::InputError for a formula that cannot be read or is not finite somewhere. [K]
Eigen::VectorXd imposed_rises_K(const ImposedTemperature& imposed, const std::vector<DofPlace>& places);

}  // namespace spindle_twin::fem_offline
