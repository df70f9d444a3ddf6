#pragma once

#include <Eigen/Core>
#include <string>

#include "fem_offline/model/discretisation.hpp"

namespace spindle_twin::fem_offline {

/// Writes a VTU file with temperature (degC), rise (K), heat flux (W/m²; r, z), part index and displacement (m; r, z).
/// `displacements_m` is 2·unknowns long; `stresses_Pa` (unknowns x 4: rr, zz, tt, rz) adds these and the von Mises
/// stress unless it is empty. Throws rom::InputError if the file cannot be written.
void write_field_file(const std::string& path, const Spindle& spindle, const Discretisation<2>& discretisation,
                      const Eigen::VectorXd& temperatures_K, const Eigen::VectorXd& rises_K,
                      const Eigen::VectorXd& displacements_m, const Eigen::MatrixXd& stresses_Pa);

}  // namespace spindle_twin::fem_offline
