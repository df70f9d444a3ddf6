#include "correction/boundaries/schedule.hpp"

#include <algorithm>
#include <cmath>

#include "rom/read/csv_table.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double kelvin_at_0_degC = 273.15;

std::vector<std::string> allowed_columns(const rom::Boundaries& boundaries) {
  std::vector<std::string> columns = {"time_s", "speed_rpm", "load"};
  for (const rom::Environment& environment : boundaries.environments) columns.push_back(environment.name + "_degC");
  for (const rom::CoolantCircuit& circuit : boundaries.circuits) columns.push_back(circuit.name + "_kg_per_s");
  return columns;
}

/// For every column of the file, its index among the allowed ones.
std::vector<std::size_t> read_header(const std::vector<std::string>& header, const std::vector<std::string>& allowed,
                                     const rom::SourceLine& where) {
  std::vector<std::size_t> meaning;
  for (const std::string& column : header) {
    const auto found = std::find(allowed.begin(), allowed.end(), column);
    if (found == allowed.end()) {
      std::string names;
      for (const std::string& name : allowed) names += (names.empty() ? "" : ", ") + name;
      throw rom::InputError(where, column, "unknown column; allowed: " + names);
    }
    meaning.push_back(static_cast<std::size_t>(found - allowed.begin()));
  }
  for (std::size_t required = 0; required < 3; ++required) {
    if (std::find(meaning.begin(), meaning.end(), required) == meaning.end()) {
      throw rom::InputError(where, allowed[required], "missing column; the header needs time_s, speed_rpm and load");
    }
  }
  return meaning;
}

ScheduleRow read_row(const rom::CsvTable& table, std::size_t index, const std::vector<std::size_t>& meaning,
                     const rom::OperatingState& standard) {
  const rom::SourceLine where = table.where(index);
  ScheduleRow row{0.0, standard};
  const std::size_t first_flow = 3 + static_cast<std::size_t>(standard.environment_K.size());
  for (std::size_t c = 0; c < meaning.size(); ++c) {
    const std::string& column = table.names[c];
    const double value = table.columns[c][index];
    if (std::isnan(value)) throw rom::InputError(where, column, "'' is not a finite number with a decimal point");
    switch (meaning[c]) {
      case 0:
        row.time_s = value;
        break;
      case 1:
        row.state.speed_rpm = value;
        break;
      case 2:
        row.state.load = value;
        break;
      default:
        if (meaning[c] >= first_flow) {
          row.state.flow_kg_per_s[static_cast<Eigen::Index>(meaning[c] - first_flow)] = value;
          break;
        }
        if (value <= -kelvin_at_0_degC)
          throw rom::InputError(where, column, "is not above absolute zero, -273.15 degC");
        row.state.environment_K[static_cast<Eigen::Index>(meaning[c] - 3)] = value + kelvin_at_0_degC;
    }
  }
  return row;
}

}  // namespace

Schedule read_schedule(const std::string& path, const rom::Boundaries& boundaries) {
  const rom::CsvTable table = rom::read_csv_table(path, rom::LastLine::whole);
  const std::vector<std::size_t> meaning = read_header(table.names, allowed_columns(boundaries), table.header());
  Schedule schedule;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    ScheduleRow row = read_row(table, i, meaning, boundaries.operating);
    if (schedule.rows.empty() && row.time_s != 0.0) {
      throw rom::InputError(table.where(i), "time_s", "the first row must be at time 0");
    }
    if (!schedule.rows.empty() && row.time_s <= schedule.rows.back().time_s) {
      throw rom::InputError(table.where(i), "time_s", "times must rise from row to row");
    }
    schedule.rows.push_back(std::move(row));
  }
  if (schedule.rows.size() < 2) {
    throw rom::InputError(table.where(0), "", "a schedule needs at least two rows; the last one's time is the end");
  }
  schedule.end_s = schedule.rows.back().time_s;
  return schedule;
}

void state_at(const Schedule& schedule, double time_s, rom::OperatingState& state) {
  const auto& rows = schedule.rows;
  const auto next = std::upper_bound(rows.begin(), rows.end(), time_s,
                                     [](double time, const ScheduleRow& row) { return time < row.time_s; });
  const ScheduleRow& row = next == rows.begin() ? rows.front() : *(next - 1);
  state.speed_rpm = row.state.speed_rpm;
  state.load = row.state.load;
  state.environment_K = row.state.environment_K;
  state.flow_kg_per_s = row.state.flow_kg_per_s;
  if (next != rows.begin() && next != rows.end()) {
    const double share = (time_s - row.time_s) / (next->time_s - row.time_s);
    state.environment_K += share * (next->state.environment_K - row.state.environment_K);
  }
}

Schedule constant_schedule(const rom::Boundaries& boundaries, double duration_s) {
  Schedule schedule;
  schedule.rows = {{0.0, boundaries.operating}, {duration_s, boundaries.operating}};
  schedule.end_s = duration_s;
  return schedule;
}

double rest_temperature_K(const rom::Boundaries& boundaries, const rom::OperatingState& state) {
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    if (boundaries.environments[i].kind == rom::EnvironmentKind::ambient) {
      return state.environment_K[static_cast<Eigen::Index>(i)];
    }
  }
  return state.environment_K.size() > 0 ? state.environment_K[0] : boundaries.reference_temperature_K;
}

}  // namespace spindle_twin::correction
