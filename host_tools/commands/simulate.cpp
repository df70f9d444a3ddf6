#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "host_tools/commands/column_names.hpp"
#include "host_tools/commands/commands.hpp"
#include "host_tools/commands/finite_range.hpp"
#include "host_tools/commands/plausibility.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

// spindle-twin simulate reference.rom --schedule day.csv -o out.csv
namespace spindle_twin::host_tools {
namespace {

struct SimulateOptions {
  std::string network;
  std::string schedule;
  std::string output;
  double period_s = 1.0;
  double every_s = 10.0;
  Plausibility plausibility;
};

std::string header(const std::string& file, const rom::Network& network) {
  ColumnNames names(file);
  for (const rom::KeyPoint& point : network.key_points) names.add(point.name, "_degC", "key point");
  for (const rom::PartOutput& part : network.parts) names.add(part.name, "_max_degC", "part");
  for (const rom::DeformationOutput& output : network.deformations) names.add(output.name, "_um", "deformation");
  for (const rom::ContactPressureOutput& output : network.contact_pressures) {
    names.add(output.name, "_MPa", "contact pressure");
  }
  for (const rom::HeatSource& source : network.boundaries.sources) names.add(source.name, "_W", "heat source");
  for (const rom::CoolantCircuit& circuit : network.boundaries.circuits) {
    names.add(circuit.name, "_outlet_degC", "coolant circuit");
    names.add(circuit.name, "_heat_W", "coolant circuit");
  }
  return names.text() + "\n";
}

void add_number(std::string& row, const char* format, double number) {
  char text[48];
  std::snprintf(text, sizeof text, format, number);
  row += text;
}

void add_row(std::string& table, double time_s, const rom::NetworkOutputs& outputs, const Eigen::VectorXd& heat_W,
             const rom::CoolantOutlets& coolant) {
  add_number(table, "%.10g", time_s);
  for (const double kelvin : outputs.key_points_K) add_number(table, ",%.5f", kelvin - rom::zero_degC_K);
  for (const double kelvin : outputs.part_maximum_K) add_number(table, ",%.5f", kelvin - rom::zero_degC_K);
  for (const double metre : outputs.deformations_m) add_number(table, ",%.5f", rom::um_per_m * metre);
  for (const double pressure_Pa : outputs.contact_pressures_Pa) add_number(table, ",%.5f", 1e-6 * pressure_Pa);
  for (const double watt : heat_W) add_number(table, ",%.5f", watt);
  for (Eigen::Index c = 0; c < coolant.heat_W.size(); ++c) {
    add_number(table, ",%.5f", coolant.outlet_K[c] - rom::zero_degC_K);
    add_number(table, ",%.5f", coolant.heat_W[c]);
  }
  table += '\n';
}

void simulate(const SimulateOptions& options) {
  rom::check_writable(options.output, "--output");
  const rom::Network network = rom::read_network(options.network);
  const rom::Boundaries& boundaries = network.boundaries;
  const rom::Schedule schedule = rom::read_schedule(options.schedule, boundaries);
  Plausibility plausibility = options.plausibility;
  plausibility.note_schedule(options.schedule, schedule, boundaries, network.certificate.box.speed_high_rpm);
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::NetworkOutputs outputs = rom::make_network_outputs(network);
  rom::OperatingState state = boundaries.operating;
  const auto stepper = rom::make_runtime_stepper(network);
  const rom::NetworkOperator channels(network);

  const auto hold = [&](double time_s) {
    rom::state_at(schedule, time_s, state);
    rom::evaluate_boundaries(boundaries, state, factors, values);
  };
  hold(0.0);
  stepper->set_temperatures(
      Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), rom::rest_temperature_K(boundaries, state)));
  std::string table = header(options.network, network);
  const auto add_row_at = [&](double time_s) {
    const Eigen::VectorXd& nodes_K = stepper->temperatures_K();
    plausibility.add_temperatures(options.network, boundaries, nodes_K);
    rom::evaluate_outputs(network, nodes_K, outputs);
    channels.laws().at_temperatures(nodes_K, values);
    add_row(table, time_s, outputs, values.heat_W, rom::coolant_outlets(channels, values, nodes_K));
  };
  add_row_at(0.0);

  double time_s = 0.0;
  double due_s = options.every_s;
  for (long cycle = 1; time_s < schedule.end_s; ++cycle) {
    const double end_s = std::min(static_cast<double>(cycle) * options.period_s, schedule.end_s);
    hold(0.5 * (time_s + end_s));  // the middle: exact for the linear ramps of the environments
    if (stepper->advance(end_s - time_s, values) != rom::StepStatus::ok) {
      throw std::runtime_error("simulate: no solution at " + std::to_string(end_s) + " s; nothing was written");
    }
    time_s = end_s;
    if (time_s < due_s - 1e-6 * options.period_s && time_s < schedule.end_s) continue;
    while (due_s <= time_s + 1e-6 * options.period_s) due_s += options.every_s;
    add_row_at(time_s);
  }
  plausibility.note_temperatures(options.network, boundaries);
  rom::write_whole_file(options.output, table);
  if (stepper->fallbacks() > 0) {
    std::fprintf(stderr, "simulate: CVODE failed in %ld cycles, the exact stepper did them\n", stepper->fallbacks());
  }
  std::printf("%g s simulated, %s written\n", time_s, options.output.c_str());
}

}  // namespace

void add_simulate(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("simulate", "Run a network along a schedule with the integrator of spindle-twind");
  const auto options = std::make_shared<SimulateOptions>();
  const CLI::Validator positive = finite_range(1e-3, 1e6, "1e-3 to 1e6 s");
  command->add_option("network", options->network, "network file, .rom")->required();
  options->plausibility.add_to(*command);
  command
      ->add_option("--schedule", options->schedule,
                   "CSV: time_s,speed_rpm,load <environment>_degC and <circuit>_kg_per_s columns")
      ->required();
  command->add_option("-o,--output", options->output, "CSV to write")->required();
  command->add_option("--period", options->period_s, "cycle period in s; inputs are held for it")
      ->capture_default_str()
      ->check(positive);
  command->add_option("--every", options->every_s, "model time between two rows, s")
      ->capture_default_str()
      ->check(positive);
  command->callback([options] { simulate(*options); });
}

}  // namespace spindle_twin::host_tools
