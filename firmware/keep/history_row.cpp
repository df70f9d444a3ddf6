#include "firmware/keep/history_row.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "rom/boundary_values/held_law.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

template <class Named>
void add_names(std::string& header, const char* prefix, const std::vector<Named>& things, const char* unit) {
  for (const Named& thing : things) {
    header += ',';
    header += prefix;
    header += thing.name;
    header += unit;
  }
}

/// What the cycle was given: as many digits as bring the same number back, and of a temperature in degC the same in K
/// (from -136 to 273 degC the difference is exact), so that a history can be replayed to the bit.
void add_exactly(std::string& row, double value) {
  row += ',';
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(row), "{}", value);
}

void add(std::string& row, double value) {
  row += ',';
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(row), "{:.9g}", value);
}

template <std::size_t room>
void add_values(std::string& row, const std::array<double, room>& values, std::size_t count, double shift,
                double scale) {
  for (std::size_t i = 0; i < count; ++i) add(row, (values[i] + shift) * scale);
}

using Columns = std::initializer_list<std::pair<const char*, const char*>>;
constexpr Columns update_columns = {{"observation.", "_degC"}, {"innovation.", "_K"}, {"innovation_sd.", "_K"},
                                    {"test_ratio.", ""},       {"update.", ""},       {"offset.", "_K"},
                                    {"offset_sd.", "_K"}};
constexpr Columns displacement_columns = {{"displacement", "_um"},
                                          {"displacement_innovation", "_um"},
                                          {"displacement_innovation_sd", "_um"},
                                          {"displacement_test_ratio", ""},
                                          {"displacement_update", ""}};

void add_update(std::string& row, const ChannelUpdate& update) {
  add(row, update.observation - zero_degC_K);
  add(row, update.innovation);
  add(row, std::sqrt(update.variance));
  add(row, update.test_ratio);
  add(row, update.flags);
  add(row, update.offset);
  add(row, update.offset_deviation);
}

}  // namespace

std::string history_header(const rom::Network& network) {
  std::string header =
      "time_s,sequence,state,quality,fault,overruns,correction_enabled,correction_count,correction_freeze,data_age_s,"
      "speed_rpm,load,coolant_degC,ambient_degC,nose_um,nose_uncorrected_um,tare_um";
  add_names(header, "flow.", network.boundaries.circuits, "_kg_per_s");
  add_names(header, "measured.", network.key_points, "_degC");
  add_names(header, "age.", network.key_points, "_s");
  add_names(header, "predicted.", network.key_points, "_degC");
  add_names(header, "uncorrected.", network.key_points, "_degC");
  add_names(header, "part_maximum.", network.parts, "_degC");
  add_names(header, "deformation.", network.deformations, "_um");
  add_names(header, "heat_factor.", network.boundaries.sources, "");
  add_names(header, "conductance_factor.", network.boundaries.conductances, "");
  add_names(header, "predicted_sd.", network.key_points, "_K");
  add_names(header, "part_maximum_sd.", network.parts, "_K");
  add_names(header, "deformation_raw.", network.deformations, "_um");
  add_names(header, "deformation_sd.", network.deformations, "_um");
  header += ",updates,parameters_determined";
  for (const rom::KeyPoint& point : network.key_points) {
    for (const auto& [column, unit] : update_columns) header.append(",").append(column).append(point.name).append(unit);
  }
  header += ",displacement_count";
  for (const auto& [column, unit] : displacement_columns) header.append(",").append(column).append(unit);
  header += ",clock_ns,tare_count,length_orders,length_output,length_m,length_sd_m";
  add_names(header, "sensor_quality.", network.key_points, "");
  add_names(header, "sensor_state.", network.key_points, "");
  add_names(header, "sensor_fault.", network.key_points, "");
  add_names(header, "sensor_misfit.", network.key_points, "");
  header += ",sensor_orders,sensor_order";
  add_names(header, "raw.", network.key_points, "_degC");
  add_names(header, "probe.", network.deformations, "_m");
  add_names(header, "probe_age.", network.deformations, "_s");
  header += ",current_A,power_W";
  for (const std::size_t heat : rom::measured_heats(network.boundaries)) {
    header.append(",heat.").append(network.boundaries.sources[heat].name).append("_W");
  }
  return header;
}

std::string history_row(const Snapshot& snapshot) {
  using rom::um_per_m;
  std::string row =
      fmt::format("{:.9g},{},{},{},{},{},{},{},{}", snapshot.model_time_s, snapshot.sequence, bits(snapshot.state),
                  snapshot.quality, snapshot.fault, snapshot.overruns, snapshot.correction_enabled ? 1 : 0,
                  snapshot.correction_count, snapshot.correction_freeze);
  add(row, snapshot.data_age_s);
  add_exactly(row, snapshot.signals[0]);
  add_exactly(row, snapshot.signals[1]);
  add_exactly(row, snapshot.signals[2] - zero_degC_K);
  add_exactly(row, snapshot.signals[3] - zero_degC_K);
  add(row, um_per_m * snapshot.nose_m);
  add(row, um_per_m * snapshot.nose_uncorrected_m);
  add(row, um_per_m * snapshot.tare_m);
  for (std::size_t c = 0; c < snapshot.circuits; ++c) add_exactly(row, snapshot.signals[first_flow_signal + c]);
  for (std::size_t k = 0; k < snapshot.key_points; ++k) add_exactly(row, snapshot.measured_K[k] - zero_degC_K);
  for (std::size_t k = 0; k < snapshot.key_points; ++k) add_exactly(row, snapshot.measured_age_s[k]);
  add_values(row, snapshot.predicted_K, snapshot.key_points, -zero_degC_K, 1.0);
  add_values(row, snapshot.uncorrected_K, snapshot.key_points, -zero_degC_K, 1.0);
  add_values(row, snapshot.part_maximum_K, snapshot.parts, -zero_degC_K, 1.0);
  add_values(row, snapshot.deformation_m, snapshot.deformations, 0.0, um_per_m);
  add_values(row, snapshot.heat_factor, snapshot.sources, 0.0, 1.0);
  add_values(row, snapshot.conductance_factor, snapshot.conductances, 0.0, 1.0);
  add_values(row, snapshot.predicted_deviation_K, snapshot.key_points, 0.0, 1.0);
  add_values(row, snapshot.part_maximum_deviation_K, snapshot.parts, 0.0, 1.0);
  add_values(row, snapshot.deformation_raw_m, snapshot.deformations, 0.0, um_per_m);
  add_values(row, snapshot.deformation_deviation_m, snapshot.deformations, 0.0, um_per_m);
  add(row, snapshot.updates);
  add(row, snapshot.parameters_determined);
  for (std::size_t k = 0; k < snapshot.key_points; ++k) add_update(row, snapshot.sensor_update[k]);
  add(row, snapshot.displacement_count);
  const ChannelUpdate& length = snapshot.displacement_update;
  add(row, um_per_m * length.observation);
  add(row, um_per_m * length.innovation);
  add(row, um_per_m * std::sqrt(length.variance));
  add(row, length.test_ratio);
  add(row, length.flags);
  fmt::format_to(std::back_inserter(row), ",{},{},{},{}", snapshot.clock_ns, snapshot.tare_count,
                 snapshot.displacement_orders, snapshot.displacement.output);
  add_exactly(row, snapshot.displacement.value_m);
  add_exactly(row, snapshot.displacement.deviation_m);
  const auto each = [&](const auto& value) {
    for (std::size_t k = 0; k < snapshot.key_points; ++k) add(row, value(k));
  };
  each([&](std::size_t k) { return bits(snapshot.sensor_quality[k]); });
  each([&](std::size_t k) { return bits(snapshot.sensor_health[k].state); });
  each([&](std::size_t k) { return bits(snapshot.sensor_health[k].fault); });
  each([&](std::size_t k) { return snapshot.sensor_health[k].misfit_ratio; });
  add(row, snapshot.sensor_orders);
  add(row, bits(snapshot.sensor_order));
  for (std::size_t k = 0; k < snapshot.key_points; ++k) add_exactly(row, snapshot.raw_K[k] - zero_degC_K);
  for (std::size_t d = 0; d < snapshot.deformations; ++d) add_exactly(row, snapshot.probe_m[d]);
  for (std::size_t d = 0; d < snapshot.deformations; ++d) add_exactly(row, snapshot.probe_age_s[d]);
  add_exactly(row, snapshot.signals[static_cast<std::size_t>(Signal::current)]);
  add_exactly(row, snapshot.signals[static_cast<std::size_t>(Signal::power)]);
  for (std::size_t h = 0; h < snapshot.heats; ++h) add_exactly(row, snapshot.signals[first_heat_signal + h]);
  return row;
}

}  // namespace spindle_twin::firmware
