#include "rom/boundary_values/schedule.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "rom/boundary_values/held_law.hpp"
#include "rom/read/csv_table.hpp"
#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

using Setter = std::function<void(double, OperatingState&)>;

struct Column {
  std::string name;
  Setter set;  ///< of the state; none of time_s
  bool is_degC = false;
};

/// What a schedule of these boundaries may have.
std::vector<Column> allowed_columns(const Boundaries& boundaries) {
  std::vector<Column> columns = {{"time_s", {}},
                                 {"speed_rpm", [](double value, OperatingState& state) { state.speed_rpm = value; }},
                                 {"load", [](double value, OperatingState& state) { state.load = value; }}};
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    const auto index = static_cast<Eigen::Index>(e);
    const auto set = [index](double value, OperatingState& state) { state.environment_K[index] = value + zero_degC_K; };
    columns.push_back({boundaries.environments[e].name + "_degC", set, true});
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    const auto set = [index](double value, OperatingState& state) { state.flow_kg_per_s[index] = value; };
    columns.push_back({boundaries.circuits[c].name + "_kg_per_s", set});
  }
  const std::vector<std::size_t> heats = measured_heats(boundaries);
  for (std::size_t h = 0; h < heats.size(); ++h) {
    const auto index = static_cast<Eigen::Index>(h);
    const auto set = [index](double value, OperatingState& state) { state.heat_W[index] = value; };
    columns.push_back({"heat." + boundaries.sources[heats[h]].name + "_W", set});
  }
  if (follows_current(boundaries)) {
    columns.push_back({"current_A", [](double value, OperatingState& state) { state.current_A = value; }});
  }
  if (follows_power(boundaries)) {
    columns.push_back({"power_W", [](double value, OperatingState& state) { state.power_W = value; }});
  }
  return columns;
}

/// For every column of the file its meaning.
std::vector<Column> read_header(const std::vector<std::string>& header, const std::vector<Column>& allowed,
                                const SourceLine& where) {
  std::vector<Column> columns;
  for (const std::string& name : header) {
    const auto is_it = [&](const Column& column) { return column.name == name; };
    const auto found = std::find_if(allowed.begin(), allowed.end(), is_it);
    if (found == allowed.end()) {
      std::string names;
      for (const Column& column : allowed) names += (names.empty() ? "" : ", ") + column.name;
      throw InputError(where, name, "unknown column; allowed: " + names);
    }
    columns.push_back(*found);
  }
  for (const char* required : {"time_s", "speed_rpm", "load"}) {
    if (std::find(header.begin(), header.end(), required) == header.end()) {
      throw InputError(where, required, "missing column; the header needs time_s, speed_rpm and load");
    }
  }
  return columns;
}

ScheduleRow read_row(const CsvTable& table, std::size_t index, const std::vector<Column>& columns,
                     const OperatingState& standard) {
  const SourceLine where = table.where(index);
  ScheduleRow row{0.0, standard, where.line};
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const Column& column = columns[c];
    const double value = table.columns[c][index];
    if (std::isnan(value)) throw InputError(where, column.name, "'' is not a finite number with a decimal point");
    if (column.is_degC && value <= -zero_degC_K) {
      throw InputError(where, column.name, "is not above absolute zero, -273.15 degC");
    }
    column.set ? column.set(value, row.state) : void(row.time_s = value);
  }
  return row;
}

}  // namespace

Schedule read_schedule(const std::string& path, const Boundaries& boundaries) {
  const CsvTable table = read_csv_table(path, LastLine::whole);
  const std::vector<Column> columns = read_header(table.names, allowed_columns(boundaries), table.header());
  Schedule schedule;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    ScheduleRow row = read_row(table, i, columns, boundaries.operating);
    if (schedule.rows.empty() && row.time_s != 0.0) {
      throw InputError(table.where(i), "time_s", "the first row must be at time 0");
    }
    if (!schedule.rows.empty() && row.time_s <= schedule.rows.back().time_s) {
      throw InputError(table.where(i), "time_s", "times must rise from row to row");
    }
    schedule.rows.push_back(std::move(row));
  }
  if (schedule.rows.size() < 2) {
    throw InputError(table.where(0), "", "a schedule needs at least two rows; the last one's time is the end");
  }
  schedule.end_s = schedule.rows.back().time_s;
  return schedule;
}

void state_at(const Schedule& schedule, double time_s, OperatingState& state) {
  const auto& rows = schedule.rows;
  const auto next = std::upper_bound(rows.begin(), rows.end(), time_s,
                                     [](double time, const ScheduleRow& row) { return time < row.time_s; });
  const ScheduleRow& row = next == rows.begin() ? rows.front() : *(next - 1);
  state.speed_rpm = row.state.speed_rpm;
  state.load = row.state.load;
  state.current_A = row.state.current_A;
  state.power_W = row.state.power_W;
  state.environment_K = row.state.environment_K;
  state.flow_kg_per_s = row.state.flow_kg_per_s;
  state.heat_W = row.state.heat_W;
  if (next != rows.begin() && next != rows.end()) {
    const double share = (time_s - row.time_s) / (next->time_s - row.time_s);
    state.environment_K += share * (next->state.environment_K - row.state.environment_K);
  }
}

Schedule constant_schedule(const Boundaries& boundaries, double duration_s) {
  Schedule schedule;
  schedule.rows = {{0.0, boundaries.operating}, {duration_s, boundaries.operating}};
  schedule.end_s = duration_s;
  return schedule;
}

}  // namespace spindle_twin::rom
