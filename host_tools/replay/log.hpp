#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "firmware/cycle/snapshot.hpp"
#include "rom/network.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {

/// Of so many slots no reading.
template <std::size_t slots>
constexpr std::array<double, slots> none_of() {
  std::array<double, slots> none{};
  none.fill(std::numeric_limits<double>::quiet_NaN());
  return none;
}

/// What was known at one instant, in SI; NaN: nothing new.
struct LogRow {  // NOLINT(public-members): one for each column of a log
  double time_s = 0.0;
  rom::SourceLine where;
  std::array<double, firmware::signal_count> signals{};
  std::array<double, firmware::slots::key_points> measured_K = none_of<firmware::slots::key_points>();
  /// Of a history: before the sensor tare.
  std::array<double, firmware::slots::key_points> raw_K = none_of<firmware::slots::key_points>();
  std::array<double, firmware::slots::key_points> age_s{};  ///< of the readings of a history
  /// Measured: a probe, or from outside for judging only.
  std::array<double, firmware::slots::deformations> deformation_m = none_of<firmware::slots::deformations>();
  // Of a history:
  std::array<bool, firmware::slots::key_points> disbelieved{};  ///< the daemon did not use the sensor's reading
  std::int64_t missed = 0;                                      ///< periods without a cycle before this one
  bool connected = true;
  bool correction_enabled = true;
  std::int64_t clock_ns = 0;        ///< when the cycle began
  std::uint32_t tare_orders = 0;    ///< since the start
  bool tared = false;               ///< what the last of them left
  std::uint32_t length_orders = 0;  ///< touch-offs since the start, and the last one
  firmware::Displacement length;
  std::uint32_t sensor_orders = 0;  ///< to tare or acknowledge sensors, since the start, and the last one
  firmware::SensorOrder sensor_order = firmware::SensorOrder::tare;
  std::array<double, firmware::slots::deformations> probe_m = none_of<firmware::slots::deformations>();
  std::array<double, firmware::slots::deformations> probe_age_s{};
};

/// The log of a machine. A plain one has a row per sample, at any times; a history of spindle-twind a row per cycle.
struct Log {
  std::string file;
  std::vector<LogRow> rows;  ///< times rise strictly
  std::array<bool, firmware::signal_count> has_signal{};
  std::array<bool, firmware::slots::key_points> has_sensor{};
  std::array<bool, firmware::slots::deformations> has_deformation{};
  // Of a history:
  std::optional<double> cycle_s;     ///< the period that it was made with; empty: this is a plain log
  double before_s = 0.0;             ///< model time at its first cycle
  bool switched_correction = false;  ///< the correction was on in some rows
};

/// Reads a CSV of the columns time_s, speed_rpm, load (required), coolant_degC, ambient_degC, current_A, power_W,
/// flow.<circuit>_kg_per_s, heat.<measured heat>_W, measured.<key point>_degC, measured.<deformation>_um (an empty
/// cell: no new reading); `<surrounding>_degC` as in a schedule where it is the only one of its kind; or a history of
/// spindle-twind as it is, which may have measured.<deformation>_um besides. Times of a history are those at which its
/// cycles began. Throws rom::InputError with file, line and column for a missing or unknown column, a cell that is no
/// finite number, an empty one where a number must be, times that do not rise, two rows further apart than
/// longest_gap_s, and for a history that lacks rows between two others. Of a history in SQLite one run is read, by its
/// id or else the last one; `where` then counts that run's rows.
Log read_log(const std::string& path, const rom::Network& network, double longest_gap_s,
             std::optional<std::int64_t> run = std::nullopt);

/// Puts the signals of a row over what `operating` had before; one that the row does not say stays.
void take_signals(const rom::Network& network, const Log& log, const LogRow& row, rom::OperatingState& operating);

}  // namespace spindle_twin::host_tools
