#include "host_tools/commands/plausibility.hpp"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rom/units.hpp"

namespace spindle_twin::host_tools {

void Plausibility::add_to(CLI::App& command) {
  command.add_flag("--strict", strict_, "refuse implausible inputs, heats, films and temperatures instead of warning");
}

void Plausibility::note(const rom::SourceLine& where, const std::vector<rom::Implausible>& found) {
  for (const rom::Implausible& each : found) {
    const rom::InputError error(where, each.field, each.message);
    if (strict_) throw error;
    if (said_.insert(where.file + each.field).second) std::fprintf(stderr, "warning: %s\n", error.what());
  }
}

void Plausibility::note_schedule(const std::string& path, const rom::Schedule& schedule,
                                 const rom::Boundaries& boundaries, double certified_rpm) {
  const rom::PlausibleInputs believed = rom::plausible_inputs(boundaries, certified_rpm);
  for (const rom::ScheduleRow& row : schedule.rows) {
    note({path, row.line}, rom::implausible_inputs(boundaries, believed, row.state));
  }
}

void Plausibility::note_log(const Log& log, const rom::Network& network) {
  rom::Boundaries boundaries = network.boundaries;  // with the names of a log's columns
  for (rom::Environment& environment : boundaries.environments) {
    environment.name = environment.kind == rom::EnvironmentKind::coolant ? "coolant" : "ambient";
  }
  for (rom::CoolantCircuit& circuit : boundaries.circuits) circuit.name = "flow." + circuit.name;
  for (rom::HeatSource& source : boundaries.sources) source.name = "heat." + source.name;
  const rom::PlausibleInputs believed = rom::plausible_inputs(boundaries, network.certificate.box.speed_high_rpm);
  rom::OperatingState state = boundaries.operating;
  for (const LogRow& row : log.rows) {
    take_signals(network, log, row, state);
    note(row.where, rom::implausible_inputs(boundaries, believed, state));
  }
}

void Plausibility::note_readings(const Log& log, const rom::Network& network, const firmware::CyclePlan& plan) {
  for (const LogRow& row : log.rows) {
    for (std::size_t k = 0; k < network.key_points.size(); ++k) {
      const firmware::SensorPlan& sensor = plan.sensors[k];
      const double reading_K = row.measured_K[k];
      if (!sensor.configured || std::isnan(reading_K)) continue;
      const auto amiss = rom::judge_value(
          reading_K - rom::zero_degC_K, rom::between(sensor.min_K - rom::zero_degC_K, sensor.max_K - rom::zero_degC_K),
          "measured." + network.key_points[k].name + "_degC", "degC, not kelvin, and is not used");
      if (amiss) note(row.where, {*amiss});
    }
  }
}

void Plausibility::note_measured(const Log& log, const rom::Network& network) {
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    double coldest_K = std::numeric_limits<double>::infinity(), hottest_K = 0.0;
    for (const LogRow& row : log.rows) {
      if (!std::isfinite(row.measured_K[k]) || row.disbelieved[k]) continue;
      coldest_K = std::min(coldest_K, row.measured_K[k]);
      hottest_K = std::max(hottest_K, row.measured_K[k]);
    }
    if (coldest_K > hottest_K) continue;
    std::vector<rom::Implausible> found = rom::implausible_temperatures(network.boundaries, coldest_K, hottest_K);
    for (rom::Implausible& each : found) each.field = "measured." + network.key_points[k].name + "_degC, " + each.field;
    note({log.file, 0}, found);
  }
}

void Plausibility::add_temperatures(const std::string& file, const rom::Boundaries& boundaries,
                                    const Eigen::VectorXd& nodes_K) {
  if (nodes_K.size() == 0) return;
  coldest_K_ = std::min(coldest_K_, nodes_K.minCoeff());
  hottest_K_ = std::max(hottest_K_, nodes_K.maxCoeff());
  if (strict_) note_temperatures(file, boundaries);
}

void Plausibility::note_temperatures(const std::string& file, const rom::Boundaries& boundaries) {
  if (coldest_K_ > hottest_K_) return;
  note({file, 0}, rom::implausible_temperatures(boundaries, coldest_K_, hottest_K_));
}

}  // namespace spindle_twin::host_tools
