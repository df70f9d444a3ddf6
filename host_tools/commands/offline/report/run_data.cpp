#include "host_tools/commands/offline/report/run_data.hpp"

#include <algorithm>
#include <cmath>

#include "host_tools/pages/outlines.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

std::size_t find_part(const rom::Network& network, const std::string& name) {
  std::string list;
  for (std::size_t p = 0; p < network.parts.size(); ++p) {
    if (network.parts[p].name == name) return p;
    list.append(list.empty() ? "" : ", ").append(network.parts[p].name);
  }
  throw rom::InputError({}, "--part", "'" + name + "' does not exist; allowed: " + list);
}

std::vector<double> on_axis(const std::vector<double>& time_s, const rom::CsvTable& table, const std::string& column) {
  const std::vector<double>& table_time_s = table.column("time_s");
  const std::vector<double>& values = table.column(column);
  std::vector<double> result;
  for (const double time : time_s) result.push_back(rom::interpolate(table_time_s, values, time));
  return result;
}

/// The operating state that the daemon used in one row of its history.
void operating_of_row(const rom::CsvTable& history, std::size_t row, const rom::Boundaries& boundaries,
                      rom::OperatingState& state) {
  state.speed_rpm = history.column("speed_rpm")[row];
  state.load = history.column("load")[row];
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    const bool coolant = boundaries.environments[e].kind == rom::EnvironmentKind::coolant;
    state.environment_K[static_cast<Eigen::Index>(e)] =
        history.column(coolant ? "coolant_degC" : "ambient_degC")[row] + rom::zero_degC_K;
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    state.flow_kg_per_s[static_cast<Eigen::Index>(c)] =
        history.column("flow." + boundaries.circuits[c].name + "_kg_per_s")[row];
  }
}

void run_uncorrected(const rom::Network& network, const rom::CsvTable& history, std::size_t part, RunData& run) {
  const auto stepper = rom::make_runtime_stepper(network);
  const rom::CorrectionFactors none = rom::no_correction(network.boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::NetworkOutputs outputs = rom::make_network_outputs(network);
  rom::OperatingState state = network.boundaries.operating;
  double time_s = 0.0;
  for (std::size_t row = 0; row < run.time_s.size(); ++row) {
    operating_of_row(history, row, network.boundaries, state);
    rom::evaluate_boundaries(network.boundaries, state, none, values);
    const double period_s = run.time_s[row] - time_s;
    if (period_s > 0.0 && stepper->advance(period_s, values) != rom::StepStatus::ok) {
      throw rom::InputError({history.file, static_cast<int>(row) + 2}, "",
                            "the uncorrected model cannot be integrated");
    }
    time_s = run.time_s[row];
    rom::evaluate_outputs(network, stepper->temperatures_K(), outputs);
    for (std::size_t k = 0; k < run.key_points.size(); ++k) {
      run.key_points[k].uncorrected.push_back(outputs.key_points_K[static_cast<Eigen::Index>(k)] - rom::zero_degC_K);
    }
    run.hottest.uncorrected.push_back(outputs.part_maximum_K[static_cast<Eigen::Index>(part)] - rom::zero_degC_K);
    run.nose.uncorrected.push_back(rom::um_per_m * outputs.deformations_m[0]);
  }
}

void gather_factors(const rom::Network& network, const rom::CsvTable& history, RunData& run) {
  for (const rom::HeatSource& source : network.boundaries.sources) {
    run.factor_names.push_back(source.name);
    std::vector<double> factor = history.column("heat_factor." + source.name);
    factor.resize(run.time_s.size());
    run.heat_factors.push_back(factor);
  }
  const bool common =
      std::all_of(run.heat_factors.begin(), run.heat_factors.end(),
                  [&](const std::vector<double>& factor) { return factor == run.heat_factors.front(); });
  if (!common) return;
  run.factor_names = {"all sources"};
  run.heat_factors.resize(1);
}

}  // namespace

RunData gather_run(const rom::Network& network, const rom::CsvTable& history, const rom::CsvTable& plant,
                   const std::string& part, double until_s) {
  const std::size_t part_index = find_part(network, part);
  const double reference_degC = network.boundaries.reference_temperature_K - rom::zero_degC_K;
  RunData run;
  run.spindle = network.spindle;
  run.time_s = history.column("time_s");
  const double end_s = std::min(until_s, plant.column("time_s").back());
  run.time_s.erase(std::upper_bound(run.time_s.begin(), run.time_s.end(), end_s), run.time_s.end());
  if (run.time_s.empty()) throw rom::InputError({history.file, 0}, "time_s", "no row within the plant's log");
  const auto shown = [&](const std::string& column) {
    const std::vector<double>& values = history.column(column);
    return std::vector<double>(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(run.time_s.size()));
  };
  const auto shown_or_empty = [&](const std::string& column) {
    return history.has(column) ? shown(column) : std::vector<double>{};
  };
  run.speed_rpm = shown("speed_rpm").back();
  run.ambient_degC = shown("ambient_degC").back();
  run.coolant_degC = shown("coolant_degC").back();
  for (const rom::KeyPoint& point : network.key_points) {
    Quantity quantity{point.name, "degC", reference_degC, {}, {}, {}, {}};
    quantity.measured = shown("measured." + point.name + "_degC");
    quantity.twin = shown("predicted." + point.name + "_degC");
    quantity.plant = on_axis(run.time_s, plant, "key_point." + point.name + "_degC");
    quantity.twin_sd = shown_or_empty("predicted_sd." + point.name + "_K");
    run.key_points.push_back(quantity);
    run.key_point_places_m.push_back({point.r_m, point.z_m});
  }
  for (const rom::PartOutput& each : network.parts) {
    run.part_rises.push_back({each.name, shown("part_maximum." + each.name + "_degC")});
    for (double& value : run.part_rises.back().rises_K) value -= reference_degC;
  }
  run.outlines = outlines_json(network);
  const std::string part_column = "part_maximum." + part + "_degC";
  run.hottest = {part, "degC", reference_degC, {}, on_axis(run.time_s, plant, part_column), shown(part_column), {}};
  const std::string nose_column = "deformation." + network.deformations.front().name + "_um";
  run.nose = {network.deformations.front().name,
              "um",
              0.0,
              {},
              on_axis(run.time_s, plant, nose_column),
              shown(nose_column),
              {}};
  run.hottest.twin_sd = shown_or_empty("part_maximum_sd." + part + "_K");
  run.nose.twin_sd = shown_or_empty("deformation_sd." + network.deformations.front().name + "_um");
  gather_factors(network, history, run);
  run_uncorrected(network, history, part_index, run);
  return run;
}

}  // namespace spindle_twin::host_tools
