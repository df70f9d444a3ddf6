#pragma once

#include <cstddef>
#include <optional>

#include "correction/growth/growth_reading.hpp"

namespace spindle_twin::correction {

/// What a cycle tells of one output's growth: what was published, and what had been handed over until then.
struct GrowthRow {
  double unix_s = 0.0;
  double published_m = 0.0;  ///< of the nose minus its tare; NaN: no prediction
  double tares = 0.0;        ///< of the nose, since the start
  double orders = 0.0;       ///< lengths that were handed over since the start, of all outputs
  double of_output = 0.0;    ///< the last of them: number of its output
  double length_m = 0.0;     ///< what was measured
  double deviation_m = 0.0;  ///< and its standard deviation
};

/// Finds the touch-offs of one output in the cycles of a history, in their order. Rows between two of the same `tares`
/// and `orders` may be left out. Allocates nothing.
class TouchOffs {
 public:
  /// output: its number among the deformations.
  explicit TouchOffs(std::size_t output) : output_(output) {}

  /// The next row is the first after a start or a gap.
  void begin_run() { before_.reset(); }

  /// The reading that this cycle brought, beside what the row before had published; none where no length of this output
  /// was handed over or none that can be (`is_growth`), the prediction was missing, or a tare came with it.
  std::optional<GrowthReading> row(const GrowthRow& row);

  /// The last row; empty at the beginning of a run.
  const std::optional<GrowthRow>& before() const { return before_; }
  /// How many there were until now; that of the last row has the number stretches() − 1.
  std::size_t stretches() const { return stretches_; }

 private:
  std::size_t output_;
  std::size_t stretches_ = 0;
  std::optional<GrowthRow> before_;
};

}  // namespace spindle_twin::correction
