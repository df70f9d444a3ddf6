#pragma once

#include "fem_offline/reduce/drive_case.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// What a network must obey whatever it was built from.
struct NetworkChecks {
  double asymmetry = 0.0;            ///< of C and K₀, share of their largest entry
  bool capacity_definite = false;    ///< Cholesky of C
  bool conduction_definite = false;  ///< Cholesky of K at the operating state's conductances
  double row_sum = 0.0;              ///< largest row sum of K₀, share of its largest entry
  double exchange_sum = 0.0;         ///< largest column sum of an Fⱼ between bodies, share of its largest entry
  double source_sum = 0.0;           ///< largest |1 − column sum of B|
  Eigen::Index largest_rank = 0;     ///< of an Fⱼ
  double heat_balance = 0.0;  ///< largest |heat in − heat out − heat stored| of a drive cycle, share of heat in

  bool passed() const;
};

inline constexpr double most_heat_unbalanced = 1e-9;

/// |heat put in − heat given to environments and coolant − heat stored| over a drive cycle, as a share of the heat put
/// in (by the sources, and by the environments in steps in which they warm the spindle). Integrated with an L-stable
/// rule of order 2 (SDIRK2), the heat that passes the films by the same rule: its stages and weights. So what is left
/// is what the matrices create or lose, not the error of a time step; CVODE's own steps are bound to its tolerance
/// instead.
double heat_unbalanced(const rom::Network& network, const DriveCase& drive);

NetworkChecks check_laws(const rom::Network& network, const std::vector<DriveCase>& drives);

}  // namespace spindle_twin::fem_offline
