#include "host_tools/replay/log.hpp"

#include <spdlog/fmt/fmt.h>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware/cycle/judge.hpp"
#include "firmware/keep/read_sqlite_history.hpp"
#include "host_tools/replay/replay.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/read/csv_table.hpp"

namespace spindle_twin::host_tools {
namespace {

using firmware::zero_degC_K;

/// How a column's numbers become SI.
struct Unit {
  double factor = 1.0;
  double shift = 0.0;
};
constexpr Unit celsius{1.0, zero_degC_K};
constexpr Unit micrometre{1e-6, 0.0};
constexpr double most_count = 4294967295.0;  // 32 bits, as the daemon counts
constexpr double most_ns = 9e18;             // below 2^63

struct SignalColumn {
  std::string name;
  Unit unit;
  std::size_t signal;
};

/// Those of firmware::Signal, flows and measured heats.
std::vector<SignalColumn> signal_columns(const rom::Network& network) {
  std::vector<SignalColumn> columns = {{"speed_rpm", {}, 0},         {"load", {}, 1},      {"coolant_degC", celsius, 2},
                                       {"ambient_degC", celsius, 3}, {"current_A", {}, 4}, {"power_W", {}, 5}};
  std::size_t signal = firmware::first_flow_signal;
  for (const rom::CoolantCircuit& circuit : network.boundaries.circuits) {
    columns.push_back({"flow." + circuit.name + "_kg_per_s", {}, signal++});
  }
  signal = firmware::first_heat_signal;
  for (const std::size_t heat : rom::measured_heats(network.boundaries)) {
    columns.push_back({"heat." + network.boundaries.sources[heat].name + "_W", {}, signal++});
  }
  return columns;
}

std::string sensor_column(const rom::KeyPoint& point) { return "measured." + point.name + "_degC"; }
std::string deformation_column(const rom::DeformationOutput& output) { return "measured." + output.name + "_um"; }

/// Columns that go by a surrounding's own name, as in a schedule of `simulate`, by that of the signal that the daemon
/// reads it by. Refused where another column or surrounding has the same signal: one cannot say what two are.
void name_by_signals(rom::CsvTable& table, const rom::Network& network) {
  for (const rom::Environment& environment : network.boundaries.environments) {
    const std::string own = environment.name + "_degC";
    const std::string signal = environment.kind == rom::EnvironmentKind::coolant ? "coolant_degC" : "ambient_degC";
    const auto found = std::find(table.names.begin(), table.names.end(), own);
    if (own == signal || found == table.names.end()) continue;
    const auto alike = std::count_if(network.boundaries.environments.begin(), network.boundaries.environments.end(),
                                     [&](const rom::Environment& each) { return each.kind == environment.kind; });
    if (alike > 1 || table.has(signal)) {
      throw rom::InputError(table.header(), own,
                            fmt::format("{}; the column {} says it for all of them",
                                        alike > 1 ? "is one of several surroundings that the daemon reads as one signal"
                                                  : "is there beside " + signal,
                                        signal));
    }
    *found = signal;
  }
}

void check_columns(const rom::CsvTable& table, const rom::Network& network) {
  std::vector<std::string> allowed = {"time_s"};
  for (const SignalColumn& column : signal_columns(network)) allowed.push_back(column.name);
  for (const rom::KeyPoint& point : network.key_points) allowed.push_back(sensor_column(point));
  for (const rom::DeformationOutput& output : network.deformations) allowed.push_back(deformation_column(output));
  const std::size_t plain = allowed.size();
  std::istringstream history(replay_header(network));
  for (std::string name; std::getline(history, name, ',');) allowed.push_back(name);
  for (const std::string& name : table.names) {
    if (std::find(allowed.begin(), allowed.end(), name) != allowed.end()) continue;
    const auto end = allowed.begin() + static_cast<std::ptrdiff_t>(plain);
    throw rom::InputError(table.header(), name,
                          fmt::format("unknown column; allowed: {}, and those of a history of spindle-twind",
                                      fmt::join(allowed.begin(), end, ", ")));
  }
}

/// A column that must have a number in every row.
const std::vector<double>& full_column(const rom::CsvTable& table, const std::string& name) {
  const std::vector<double>& values = table.column(name);
  const auto gap = std::find_if(values.begin(), values.end(), [](double value) { return std::isnan(value); });
  if (gap != values.end()) {
    throw rom::InputError(table.where(static_cast<std::size_t>(gap - values.begin())), name, "must not be empty");
  }
  return values;
}

/// A column of whole numbers from 0 to most, in each row.
const std::vector<double>& counts(const rom::CsvTable& table, const std::string& name, double most) {
  const std::vector<double>& values = full_column(table, name);
  const auto wrong = std::find_if(values.begin(), values.end(), [&](double value) {
    return !(value >= 0.0 && value <= most) || value != std::floor(value);
  });
  if (wrong != values.end()) {
    throw rom::InputError(table.where(static_cast<std::size_t>(wrong - values.begin())), name,
                          fmt::format("must be a whole number from 0 to {:.0f}", most));
  }
  return values;
}

template <std::size_t room>
void take(const std::vector<double>& values, Unit unit, std::size_t slot, std::array<double, room> LogRow::*field,
          std::vector<LogRow>& rows) {
  for (std::size_t i = 0; i < rows.size(); ++i) (rows[i].*field)[slot] = values[i] * unit.factor + unit.shift;
}

/// Of a sensor's states; empty where no health was watched.
void take_disbelief(const std::vector<double>& states, std::size_t sensor, std::vector<LogRow>& rows) {
  constexpr auto good = static_cast<double>(firmware::bits(firmware::SensorState::good));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].disbelieved[sensor] = std::isfinite(states[i]) && states[i] != good;
  }
}

void read_values(const rom::CsvTable& table, const rom::Network& network, Log& log) {
  for (const SignalColumn& column : signal_columns(network)) {
    const std::size_t s = column.signal;
    if (s >= firmware::first_optional_signal && !table.has(column.name)) continue;
    // A history has every column, empty where the daemon was not told.
    const bool is_flow = s >= firmware::first_flow_signal && s < firmware::first_heat_signal;
    const bool may_be_empty = table.has("sequence") && s >= firmware::first_optional_signal && !is_flow;
    const std::vector<double>& values = may_be_empty ? table.column(column.name) : full_column(table, column.name);
    log.has_signal[s] = std::any_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
    take(values, column.unit, s, &LogRow::signals, log.rows);
  }
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    const std::string name = sensor_column(network.key_points[k]);
    if (!table.has(name)) continue;
    const std::vector<double>& values = table.column(name);
    log.has_sensor[k] = std::any_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
    take(values, celsius, k, &LogRow::measured_K, log.rows);
    const std::string raw = "raw." + network.key_points[k].name + "_degC";
    take(table.column(table.has(raw) ? raw : name), celsius, k, &LogRow::raw_K, log.rows);
    const std::string age = "age." + network.key_points[k].name + "_s";
    if (table.has(age)) take(table.column(age), {}, k, &LogRow::age_s, log.rows);
    const std::string state = "sensor_state." + network.key_points[k].name;
    if (table.has(state)) take_disbelief(table.column(state), k, log.rows);
  }
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    const std::string probe = "probe." + network.deformations[d].name + "_m";
    if (table.has(probe)) {
      take(table.column(probe), {}, d, &LogRow::probe_m, log.rows);
      take(table.column("probe_age." + network.deformations[d].name + "_s"), {}, d, &LogRow::probe_age_s, log.rows);
    }
    const std::string name = deformation_column(network.deformations[d]);
    if (!table.has(name)) continue;
    log.has_deformation[d] = true;
    take(table.column(name), micrometre, d, &LogRow::deformation_m, log.rows);
  }
}

void check_times(const Log& log, double longest_gap_s) {
  for (std::size_t i = 1; i < log.rows.size(); ++i) {
    const double gap_s = log.rows[i].time_s - log.rows[i - 1].time_s;
    if (gap_s <= 0.0) throw rom::InputError(log.rows[i].where, "time_s", "times must rise from row to row");
    if (gap_s > longest_gap_s) {
      throw rom::InputError(
          log.rows[i].where, "time_s",
          fmt::format("{:g} s after the row before; gaps may be {:g} s long (--longest-gap-s)", gap_s, longest_gap_s));
    }
  }
}

/// What came at which instant; without the columns, which histories of before had not, cycles came on time.
void read_orders(const rom::CsvTable& table, double period_ns, Log& log) {
  const std::vector<double>& enabled = full_column(table, "correction_enabled");
  const std::vector<double>& tare_um = full_column(table, "tare_um");
  std::int64_t clock_ns = 0;
  for (std::size_t i = 0; i < log.rows.size(); ++i) {
    LogRow& row = log.rows[i];
    row.correction_enabled = enabled[i] != 0.0;
    log.switched_correction = log.switched_correction || row.correction_enabled;
    row.tared = tare_um[i] != 0.0;
    row.tare_orders = i > 0 ? log.rows[i - 1].tare_orders : 0;
    if (i > 0 && tare_um[i] != tare_um[i - 1]) ++row.tare_orders;
    if (i > 0) clock_ns += std::llround(period_ns * static_cast<double>(1 + row.missed));
    row.clock_ns = clock_ns;
  }
  if (!table.has("clock_ns")) return;
  const std::vector<double>& began_ns = counts(table, "clock_ns", most_ns);
  const std::vector<double>& tares = counts(table, "tare_count", most_count);
  const std::vector<double>& orders = counts(table, "length_orders", most_count);
  const std::vector<double>& output = counts(table, "length_output", most_count);
  const std::vector<double>& length_m = table.column("length_m");
  const std::vector<double>& length_sd_m = table.column("length_sd_m");
  for (std::size_t i = 0; i < log.rows.size(); ++i) {
    LogRow& row = log.rows[i];
    row.clock_ns = std::llround(began_ns[i]);
    row.tare_orders = static_cast<std::uint32_t>(tares[i]);
    row.length_orders = static_cast<std::uint32_t>(orders[i]);
    row.length = {static_cast<std::size_t>(output[i]), length_m[i], length_sd_m[i]};
    if (i > 0 && row.clock_ns <= log.rows[i - 1].clock_ns) {
      throw rom::InputError(row.where, "clock_ns", "must rise from row to row");
    }
  }
}

/// Orders for the sensors, which histories of before sensors could be tared did not have.
void read_sensor_orders(const rom::CsvTable& table, Log& log) {
  if (!table.has("sensor_orders")) return;
  const std::vector<double>& orders = counts(table, "sensor_orders", most_count);
  const std::vector<double>& last = full_column(table, "sensor_order");
  for (std::size_t i = 0; i < log.rows.size(); ++i) {
    if (last[i] != 0.0 && last[i] != 1.0 && last[i] != 2.0) {
      throw rom::InputError(log.rows[i].where, "sensor_order", "must be 0 (tare), 1 (clear) or 2 (acknowledge)");
    }
    log.rows[i].sensor_orders = static_cast<std::uint32_t>(orders[i]);
    log.rows[i].sensor_order = static_cast<firmware::SensorOrder>(last[i]);
  }
}

/// A history's rows are cycles: what each advanced the model by follows from the periods that it missed, and its time
/// is that of the prediction, one advance later than the cycle's own. While the daemon waited for its sensors time
/// stood.
void read_cycles(const rom::CsvTable& table, Log& log) {
  const std::vector<double>& time_s = full_column(table, "time_s");
  const std::vector<double>& sequence = counts(table, "sequence", most_ns);
  const std::vector<double>& overruns = counts(table, "overruns", most_count);
  const std::vector<double>& quality = counts(table, "quality", most_count);
  const auto offline = static_cast<unsigned>(firmware::Quality::device_offline);
  for (std::size_t i = 0; i < log.rows.size(); ++i) {
    LogRow& row = log.rows[i];
    const double before = i > 0 ? overruns[i - 1] : sequence[0] == 1.0 ? 0.0 : overruns[0];
    if (i > 0 && sequence[i] != sequence[i - 1] + 1.0) {
      throw rom::InputError(row.where, "sequence",
                            fmt::format("{:g} after {:g}: rows are missing", sequence[i], sequence[i - 1]));
    }
    if (overruns[i] < before) throw rom::InputError(row.where, "overruns", "must not fall");
    row.missed = std::llround(overruns[i] - before);
    row.connected = (static_cast<unsigned>(quality[i]) & offline) == 0;
    if (time_s[i] == 0.0 || (i == 0 && sequence[0] != 1.0)) continue;
    const double earlier_s = i > 0 ? time_s[i - 1] : 0.0;
    // The cycle in which the model starts advances it by one period, whatever had been missed before.
    const double periods = earlier_s > 0.0 ? 1.0 + static_cast<double>(row.missed) : 1.0;
    const double period_s = std::round(1e6 * (time_s[i] - earlier_s) / periods) / 1e6;
    if (!log.cycle_s && period_s > 0.0) log.cycle_s = period_s;
    if (!log.cycle_s || std::abs(period_s - *log.cycle_s) > 1e-6 + 1e-8 * time_s[i]) {
      throw rom::InputError(row.where, "time_s", "must rise by one period, and one more for each overrun");
    }
  }
  if (!log.cycle_s)
    throw rom::InputError({log.file, 0}, "time_s", "this history holds no two cycles with a prediction");
  read_orders(table, 1e9 * *log.cycle_s, log);
  read_sensor_orders(table, log);
  double end_s = std::max(0.0, time_s[0] - *log.cycle_s * static_cast<double>(1 + log.rows[0].missed));
  log.before_s = end_s;
  for (LogRow& row : log.rows) {
    row.time_s = end_s + *log.cycle_s * static_cast<double>(row.missed);
    end_s = row.time_s + *log.cycle_s;
  }
}

}  // namespace

Log read_log(const std::string& path, const rom::Network& network, double longest_gap_s,
             std::optional<std::int64_t> run) {
  const bool is_database = firmware::is_sqlite_file(path);
  if (run && !is_database) throw rom::InputError({path, 0}, "run", "only a history in SQLite has several");
  rom::CsvTable table = is_database ? firmware::SqliteHistoryReader(path).table(run)
                                    : rom::read_csv_table(path, rom::LastLine::may_be_cut);
  name_by_signals(table, network);
  check_columns(table, network);
  Log log;
  log.file = path;
  log.rows.resize(table.rows());
  const std::vector<double>& time_s = full_column(table, "time_s");
  for (std::size_t i = 0; i < log.rows.size(); ++i) {
    log.rows[i].time_s = time_s[i];
    log.rows[i].where = table.where(i);
  }
  read_values(table, network, log);
  if (table.has("sequence")) {
    read_cycles(table, log);
  } else {
    check_times(log, longest_gap_s);
  }
  return log;
}

void take_signals(const rom::Network& network, const Log& log, const LogRow& row, rom::OperatingState& operating) {
  for (std::size_t s = 0; s < firmware::signal_count; ++s) {
    if (!log.has_signal[s] || !std::isfinite(row.signals[s])) continue;
    firmware::put_signal(network.boundaries, s, row.signals[s], operating);
  }
}

}  // namespace spindle_twin::host_tools
