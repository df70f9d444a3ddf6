#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "fem_offline/reduce/reduce.hpp"
#include "fem_offline/solve/thermal_system.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {

/// FE fields, a column each, as rises above the reference temperature [K]: a steady state or a uniform temperature, and
/// implicit steps (C + hK) T = h f + C T_before behind two jumps of speed, load, surroundings and coolant flow, which
/// may stop. A wall that warmed up without coolant and then meets it is cooled as no steady load cools it.
/// `system` and `analysed` are the caller's own, for one thread; the system's conductances change.
Eigen::MatrixXd full_history(const AffineModel& model, ThermalSystem& system, const CholeskyFactor& analysed,
                             const ReduceOptions& options, std::uint32_t set);

}  // namespace spindle_twin::fem_offline
