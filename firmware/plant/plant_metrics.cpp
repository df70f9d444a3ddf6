#include "firmware/plant/plant_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "firmware/cycle/states.hpp"

namespace spindle_twin::firmware {
namespace {

DataType type_of(const RegisterEntry& entry) {
  if (entry.codes_are_bits) return DataType::boolean;
  if (entry.resolution != 1.0) return DataType::float32;
  switch (entry.type) {
    case RegisterType::uint16:
      return DataType::uint16;
    case RegisterType::uint32:
      return DataType::int64;
    case RegisterType::float32:
    case RegisterType::float32_cdab:
      return DataType::float32;
    default:
      return DataType::int32;
  }
}

PlantMetric metric_of(const RegisterEntry& entry, const ShownValue& shown) {
  std::string name = shown_name(entry);
  if (entry.slots > 1) name += "/" + (shown.slot_name != nullptr ? *shown.slot_name : std::to_string(shown.slot));
  if (shown.bit != nullptr) name += std::string("/") + shown.bit->name;
  return {name, entry.unit, type_of(entry), shown};
}

MetricQuality quality_of_reading(const RegisterImage& image, int key_point) {
  const double judged = shown_value(image, Register::sensor_quality, key_point);
  if (judged == static_cast<double>(SensorQuality::good)) return MetricQuality::good;
  return judged == static_cast<double>(SensorQuality::stale) ? MetricQuality::stale : MetricQuality::bad;
}

MetricQuality quality_of(const PlantMetric& metric, double value, const RegisterImage& image) {
  if (std::isnan(value)) return MetricQuality::bad;
  if (metric.shown.which == Register::key_point_measured_float32) return quality_of_reading(image, metric.shown.slot);
  const double state = shown_value(image, Register::state, 0);
  const bool usable = state == static_cast<double>(State::running) || state == static_cast<double>(State::degraded);
  return metric.unit.empty() || usable ? MetricQuality::good : MetricQuality::bad;
}

}  // namespace

PlantMetrics::PlantMetrics(ShownNames names, const std::vector<std::string>& registers) : names_(std::move(names)) {
  for (std::size_t r = 0; r < register_entries.size(); ++r) {
    const auto which = static_cast<Register>(r);
    const RegisterEntry& entry = entry_of(which);
    const bool wanted =
        registers.empty() || std::find(registers.begin(), registers.end(), shown_name(entry)) != registers.end();
    if (!is_shown(entry) || !wanted) continue;
    for (const ShownValue& shown : shown_values(which, names_)) all_.push_back(metric_of(entry, shown));
  }
}

PlantValues PlantMetrics::values(const RegisterImage& image) const {
  PlantValues values;
  for (const PlantMetric& metric : all_) {
    values.numbers.push_back(shown_value(image, metric.shown));
    values.qualities.push_back(quality_of(metric, values.numbers.back(), image));
  }
  return values;
}

bool is_published(const std::string& name) {
  return std::any_of(register_entries.begin(), register_entries.end(),
                     [&](const RegisterEntry& entry) { return is_shown(entry) && shown_name(entry) == name; });
}

}  // namespace spindle_twin::firmware
