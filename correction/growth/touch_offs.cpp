#include "correction/growth/touch_offs.hpp"

#include <cmath>
#include <utility>

namespace spindle_twin::correction {

std::optional<GrowthReading> TouchOffs::row(const GrowthRow& row) {
  const std::optional<GrowthRow> before = std::exchange(before_, row);
  if (!before || row.tares != before->tares) ++stretches_;
  if (!before || row.tares != before->tares || !(row.orders > before->orders)) return std::nullopt;
  if (row.of_output != static_cast<double>(output_)) return std::nullopt;
  if (!std::isfinite(before->published_m) || !is_growth(row.length_m, row.deviation_m)) return std::nullopt;
  return GrowthReading{row.unix_s, stretches_ - 1, ReadingOrigin::touch_off, row.length_m, before->published_m};
}

}  // namespace spindle_twin::correction
