#pragma once

#include <Eigen/Core>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/analysed_system.hpp"
#include "fem_offline/reduce/random_history.hpp"

namespace spindle_twin::fem_offline {

/// FE fields of a history, a column each, as rises above the reference temperature [K]. A wall that warmed up without
/// coolant and then meets it is cooled as no steady load cools it.
/// `matrices` are the model's; their conductances change.
Eigen::MatrixXd full_history(const AffineModel& model, AnalysedSystem& matrices, const History& history);

}  // namespace spindle_twin::fem_offline
