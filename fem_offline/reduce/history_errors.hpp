#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/basis_model.hpp"
#include "fem_offline/reduce/random_history.hpp"
#include "fem_offline/reduce/reduce.hpp"

namespace spindle_twin::fem_offline {

/// A history and what the FE model gives along it.
struct FeHistory {
  History history;
  Eigen::MatrixXd outputs;  ///< rows as OutputLayout, a column per field, SI
};

/// Histories drawn for the search for a size alone (StreamPurpose::size_choice).
std::vector<FeHistory> run_fe_histories(const AffineModel& model, const ReduceOptions& options, int count,
                                        const Progress& progress = {});

/// Largest |reduced model - FE model| of every output along every history, one column each; both take the same implicit
/// steps, so that no rule in time comes in.
Eigen::MatrixXd history_errors(const AffineModel& model, const BasisModel& reduced,
                               const std::vector<FeHistory>& histories, int threads);

}  // namespace spindle_twin::fem_offline
