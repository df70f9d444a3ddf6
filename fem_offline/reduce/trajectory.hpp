#pragma once

#include <Eigen/Core>
#include <memory>

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/drive_case.hpp"
#include "fem_offline/reduce/output_rows.hpp"
#include "fem_offline/sparse/cholesky.hpp"
#include "rom/integrate/network_operator.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// Every output of a field of FE temperatures; maxima are over all nodes of a part.
Eigen::VectorXd fe_outputs(const AffineModel& model, const Eigen::VectorXd& temperatures_K);

/// Every output of the FE model in the steady state of the description's operating state.
Eigen::VectorXd steady_outputs(const AffineModel& model);
/// What rom::evaluate_outputs gave, in the same order.
Eigen::VectorXd network_outputs(const rom::NetworkOutputs& outputs);

/// A drive cycle and what the FE model gives at the end of every interval.
struct FeTrajectory {
  DriveCase drive;
  Eigen::MatrixXd outputs;  ///< one column per interval
};

/// By KrylovStepper with tolerance_in_time_K where conductances, heats and flows are held over
/// four intervals at least and in models of fewer than 3000 unknowns; elsewhere by steps as below, of 32 s at most.
/// `analysed`: of a matrix of this model, whose analysis serves here; several threads may share it.
FeTrajectory run_fe_model(const AffineModel& model, DriveCase drive, const CholeskyAnalysis& analysed);
/// The same by steps in time of order 4, no longer than `fe_step_s`; after a jump they are shorter, from 0.5 s on.
/// `analysed`: as FeStepper has it, several threads may share it.
FeTrajectory run_fe_model_by_steps(const AffineModel& model, DriveCase drive, double fe_step_s,
                                   const CholeskyAnalysis* analysed = nullptr);

/// Largest |network − FE model| of every output over the run; the network runs with the runtime's own integrator. Its
/// maxima are over its candidate points. std::runtime_error if the integrator fails.
Eigen::VectorXd largest_errors(const rom::Network& network,
                               const std::shared_ptr<const rom::NetworkOperator>& network_operator,
                               const FeTrajectory& trajectory);

}  // namespace spindle_twin::fem_offline
