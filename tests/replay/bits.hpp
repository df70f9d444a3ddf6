#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::host_tools {

/// The bits of everything that a cycle says, but for `quality`: a history does not tell a value that was held from one
/// that was read.
inline std::vector<std::uint64_t> bits_of(const firmware::Snapshot& snapshot) {
  std::vector<std::uint64_t> bits;
  const auto add = [&](const auto&... values) { (bits.push_back(static_cast<std::uint64_t>(values)), ...); };
  const auto add_number = [&](const auto&... values) { (bits.push_back(std::bit_cast<std::uint64_t>(values)), ...); };
  const auto add_all = [&](const auto&... arrays) {
    const auto one = [&](const auto& values) {
      for (const double value : values) add_number(value);
    };
    (one(arrays), ...);
  };
  const auto add_update = [&](const firmware::ChannelUpdate& update) {
    add_number(update.observation, update.innovation, update.variance, update.test_ratio, update.offset,
               update.offset_deviation);
    add(update.flags, update.rejected_in_a_row);
  };
  add_number(snapshot.model_time_s, snapshot.nose_m, snapshot.nose_uncorrected_m, snapshot.tare_m, snapshot.data_age_s);
  add(snapshot.clock_ns, snapshot.sequence, snapshot.overruns, snapshot.fault, snapshot.correction_count,
      snapshot.correction_freeze, snapshot.correction_enabled, snapshot.updates, snapshot.parameters_determined,
      snapshot.tare_count, snapshot.displacement_count, snapshot.displacement_orders, snapshot.sensor_orders,
      snapshot.sensor_order, snapshot.sensor_tare_count, snapshot.sensors_failed, snapshot.model_in_doubt);
  add_all(snapshot.signals, snapshot.measured_K, snapshot.raw_K, snapshot.predicted_K, snapshot.uncorrected_K,
          snapshot.part_maximum_K, snapshot.deformation_m, snapshot.deformation_raw_m, snapshot.predicted_deviation_K,
          snapshot.part_maximum_deviation_K, snapshot.deformation_deviation_m, snapshot.heat_factor,
          snapshot.conductance_factor, snapshot.sensor_tare_K);
  for (const firmware::SensorQuality quality : snapshot.sensor_quality) add(quality);
  for (const firmware::ChannelUpdate& update : snapshot.sensor_update) add_update(update);
  add_update(snapshot.displacement_update);
  for (const firmware::SensorHealthState& health : snapshot.sensor_health) {
    add(health.state, health.fault, health.partner, health.spikes);
    add_number(health.misfit_ratio);
  }
  return bits;
}

}  // namespace spindle_twin::host_tools
