#include "firmware/keep/history_row.hpp"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <utility>
#include <vector>

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

/// A row as text. What the cycle was given has as many digits as bring the same number back, and of a temperature in
/// degC the same in K (from -136 to 273 degC the difference is exact), so that a history can be replayed to the bit;
/// what it made of that has nine.
class TextRow {
 public:
  void whole(std::int64_t value) { fmt::format_to(next(), "{}", value); }
  void exact(double value) {
    const auto to = next();
    if (std::isfinite(value)) fmt::format_to(to, "{}", value);
  }
  void rounded(double value) {
    const auto to = next();
    if (std::isfinite(value)) fmt::format_to(to, "{:.9g}", value);
  }
  std::string text;

 private:
  std::back_insert_iterator<std::string> next() {
    if (!first_) text += ',';
    first_ = false;
    return std::back_inserter(text);
  }
  bool first_ = true;
};

/// The same row as numbers.
class NumberRow {
 public:
  explicit NumberRow(std::vector<double>& numbers) : numbers_(numbers) { numbers_.clear(); }
  void whole(std::int64_t value) { numbers_.push_back(static_cast<double>(value)); }
  void exact(double value) { numbers_.push_back(value); }
  void rounded(double value) { numbers_.push_back(value); }

 private:
  std::vector<double>& numbers_;
};

template <class Row, std::size_t room>
void add_values(Row& row, const std::array<double, room>& values, std::size_t count, double shift, double scale) {
  for (std::size_t i = 0; i < count; ++i) row.rounded((values[i] + shift) * scale);
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

template <class Row>
void add_update(Row& row, const ChannelUpdate& update) {
  row.rounded(update.observation - zero_degC_K);
  row.rounded(update.innovation);
  row.rounded(std::sqrt(update.variance));
  row.rounded(update.test_ratio);
  row.rounded(update.flags);
  row.rounded(update.offset);
  row.rounded(update.offset_deviation);
}

template <class Row>
void add_cycle(const Snapshot& snapshot, Row& row) {
  using rom::um_per_m;
  row.rounded(snapshot.model_time_s);
  row.whole(static_cast<std::int64_t>(snapshot.sequence));
  row.whole(bits(snapshot.state));
  row.whole(snapshot.quality);
  row.whole(snapshot.fault);
  row.whole(snapshot.overruns);
  row.whole(snapshot.correction_enabled ? 1 : 0);
  row.whole(snapshot.correction_count);
  row.whole(snapshot.correction_freeze);
  row.rounded(snapshot.data_age_s);
  row.exact(snapshot.signals[0]);
  row.exact(snapshot.signals[1]);
  row.exact(snapshot.signals[2] - zero_degC_K);
  row.exact(snapshot.signals[3] - zero_degC_K);
  row.rounded(um_per_m * snapshot.nose_m);
  row.rounded(um_per_m * snapshot.nose_uncorrected_m);
  row.rounded(um_per_m * snapshot.tare_m);
  for (std::size_t c = 0; c < snapshot.circuits; ++c) row.exact(snapshot.signals[first_flow_signal + c]);
  for (std::size_t k = 0; k < snapshot.key_points; ++k) row.exact(snapshot.measured_K[k] - zero_degC_K);
  for (std::size_t k = 0; k < snapshot.key_points; ++k) row.exact(snapshot.measured_age_s[k]);
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
}

/// What the estimator made of the readings, and what it was given.
template <class Row>
void add_readings(const Snapshot& snapshot, Row& row) {
  using rom::um_per_m;
  row.rounded(snapshot.updates);
  row.rounded(snapshot.parameters_determined);
  for (std::size_t k = 0; k < snapshot.key_points; ++k) add_update(row, snapshot.sensor_update[k]);
  row.rounded(snapshot.displacement_count);
  const ChannelUpdate& length = snapshot.displacement_update;
  row.rounded(um_per_m * length.observation);
  row.rounded(um_per_m * length.innovation);
  row.rounded(um_per_m * std::sqrt(length.variance));
  row.rounded(length.test_ratio);
  row.rounded(length.flags);
  row.whole(snapshot.clock_ns);
  row.whole(snapshot.tare_count);
  row.whole(snapshot.displacement_orders);
  row.whole(static_cast<std::int64_t>(snapshot.displacement.output));
  row.exact(snapshot.displacement.value_m);
  row.exact(snapshot.displacement.deviation_m);
  const auto each = [&](const auto& value) {
    for (std::size_t k = 0; k < snapshot.key_points; ++k) row.rounded(value(k));
  };
  each([&](std::size_t k) { return bits(snapshot.sensor_quality[k]); });
  each([&](std::size_t k) { return bits(snapshot.sensor_health[k].state); });
  each([&](std::size_t k) { return bits(snapshot.sensor_health[k].fault); });
  each([&](std::size_t k) { return snapshot.sensor_health[k].misfit_ratio; });
  row.rounded(snapshot.sensor_orders);
  row.rounded(bits(snapshot.sensor_order));
  for (std::size_t k = 0; k < snapshot.key_points; ++k) row.exact(snapshot.raw_K[k] - zero_degC_K);
  for (std::size_t d = 0; d < snapshot.deformations; ++d) row.exact(snapshot.probe_m[d]);
  for (std::size_t d = 0; d < snapshot.deformations; ++d) row.exact(snapshot.probe_age_s[d]);
  row.exact(snapshot.signals[static_cast<std::size_t>(Signal::current)]);
  row.exact(snapshot.signals[static_cast<std::size_t>(Signal::power)]);
  for (std::size_t h = 0; h < snapshot.heats; ++h) row.exact(snapshot.signals[first_heat_signal + h]);
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
  TextRow row;
  add_cycle(snapshot, row);
  add_readings(snapshot, row);
  return row.text;
}

void history_numbers(const Snapshot& snapshot, std::vector<double>& numbers) {
  NumberRow row(numbers);
  add_cycle(snapshot, row);
  add_readings(snapshot, row);
}

}  // namespace spindle_twin::firmware
