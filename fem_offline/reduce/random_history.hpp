#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fem_offline/reduce/reduce.hpp"
#include "rom/boundaries.hpp"

namespace spindle_twin::fem_offline {

/// A field to take: behind an implicit step (C + hK) T = h f + C T_before of this length, from the field before it.
struct HistoryStep {
  std::size_t state = 0;  ///< index into History::states
  double step_s = 0.0;
};

/// The steady state of the first of some states of the machine, or a uniform temperature; then two jumps to others, and
/// steps of 0.7 to 200 s, up to 2.5 times longer or shorter, behind each. After a jump coolant may stand.
struct History {
  std::optional<double> uniform_rise_K;  ///< above the reference temperature; none: the steady state
  std::vector<rom::BoundaryValues> states;
  std::vector<HistoryStep> steps;

  Eigen::Index fields() const { return 1 + static_cast<Eigen::Index>(steps.size()); }
};

/// A function of options.seed, `purpose` and `set`; of the options only the box counts besides.
History random_history(const rom::Boundaries& boundaries, const ReduceOptions& options, StreamPurpose purpose,
                       std::uint32_t set);

}  // namespace spindle_twin::fem_offline
