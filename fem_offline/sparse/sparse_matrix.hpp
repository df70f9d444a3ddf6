#pragma once

#include <Eigen/SparseCore>

namespace spindle_twin::fem_offline {

using SparseMatrix = Eigen::SparseMatrix<double>;  // column-major, both triangles stored

}  // namespace spindle_twin::fem_offline
