#pragma once

#include <Eigen/Core>
#include <string>

namespace spindle_twin::fem_offline {

class FeModel;

/// Writes a VTU file with temperature (degC), rise (K), heat flux (W/m²; r, z), part index and displacement (m; r, z)
/// of a model in a field of temperatures (of all its unknowns). If its description asks for mechanics, with stresses
/// (rr, zz, tt, rz) and the von Mises stress too. Throws rom::InputError if the file cannot be written.
void write_field_file(const std::string& path, const FeModel& model, const Eigen::VectorXd& temperatures_K);

}  // namespace spindle_twin::fem_offline
