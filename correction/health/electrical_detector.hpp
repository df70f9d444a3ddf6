#pragma once

#include "correction/health/limits.hpp"
#include "correction/health/record.hpp"

namespace spindle_twin::correction {

/// Broken and shorted wires and readings out of range, by the value alone.
class ElectricalDetector {
 public:
  /// What the reading says of the wire: `open` from open_above_K on, `shorted` up to short_below_K, `out_of_range`
  /// outside [min_K, max_K], else `none`. Kelvin; any finite reading. Runs in the cycle.
  static HealthFault judge(double reading_K, double min_K, double max_K, const HealthLimits& limits) {
    if (reading_K >= limits.open_above_K) return HealthFault::open;
    if (reading_K <= limits.short_below_K) return HealthFault::shorted;
    if (reading_K < min_K || reading_K > max_K) return HealthFault::out_of_range;
    return HealthFault::none;
  }
  /// Counts one reading that judge() did not like. True from limits.electrical in a row on: the channel has failed.
  bool note_fault(const HealthLimits& limits) { return ++in_a_row_ >= limits.electrical; }
  /// Counts one that it did. True where the one before was a fault that had not lasted: a spike.
  bool note_right() {
    const bool was_wrong = in_a_row_ > 0;
    in_a_row_ = 0;
    return was_wrong;
  }
  /// Whether the last reading was electrically right.
  bool is_right() const { return in_a_row_ == 0; }

 private:
  int in_a_row_ = 0;
};

}  // namespace spindle_twin::correction
