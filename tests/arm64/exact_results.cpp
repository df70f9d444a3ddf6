// What a network does, with all digits of its numbers, for comparing one architecture's results with another's:
//   exact_results simulate X.rom SCHEDULE.csv TOLERANCE_K OUT.csv    nodes, outputs, heats and circuits, every 10 s
//   exact_results replay X.rom LOG.csv LAW TOLERANCE_K OUT.csv       all that each cycle of a replay publishes
// TOLERANCE_K is that of the integrator, `daemon` for the daemon's own.
#include <spdlog/fmt/fmt.h>

#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/keep/history_row.hpp"
#include "host_tools/replay/log.hpp"
#include "host_tools/replay/plan.hpp"
#include "host_tools/replay/replay.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"

namespace spindle_twin::exact_results {
namespace {

constexpr double period_s = 1.0;
constexpr int cycles_per_row = 10;

/// A table of numbers, each with as many digits as bring it back.
class Table {
 public:
  explicit Table(const std::string& header) : text_(header) {}
  template <class Numbers>
  void add(const Numbers& numbers) {
    for (const double number : numbers) fmt::format_to(std::back_inserter(text_), "{}{}", separator(), number);
  }
  void end_row() {
    text_ += '\n';
    first_ = true;
  }
  const std::string& text() const { return text_; }

 private:
  const char* separator() {
    const bool first = first_;
    first_ = false;
    return first ? "" : ",";
  }
  std::string text_;
  bool first_ = true;
};

std::string numbered(const char* name, Eigen::Index count, const char* unit) {
  std::string columns;
  for (Eigen::Index i = 0; i < count; ++i) columns += fmt::format(",{}.{}{}", name, i, unit);
  return columns;
}

std::string simulation_header(const rom::Network& network, const rom::NetworkOutputs& outputs) {
  const auto circuits = static_cast<Eigen::Index>(network.boundaries.circuits.size());
  return "time_s" + numbered("node", network.capacity_J_per_K.rows(), "_K") +
         numbered("key_point", outputs.key_points_K.size(), "_K") +
         numbered("part_mean", outputs.part_mean_K.size(), "_K") +
         numbered("part_maximum", outputs.part_maximum_K.size(), "_K") +
         numbered("deformation", outputs.deformations_m.size(), "_um") +
         numbered("contact_pressure", outputs.contact_pressures_Pa.size(), "_MPa") +
         numbered("heat", static_cast<Eigen::Index>(network.boundaries.sources.size()), "_W") +
         numbered("outlet", circuits, "_K") + numbered("coolant_heat", circuits, "_W") + "\n";
}

rom::CvodeSettings settings(const std::string& tolerance_K) {
  rom::CvodeSettings settings;
  if (tolerance_K != "daemon") settings.tolerance_K = std::stod(tolerance_K);
  return settings;
}

std::string simulate(const rom::Network& network, const std::string& schedule_path, const std::string& tolerance_K) {
  const rom::Boundaries& boundaries = network.boundaries;
  const rom::Schedule schedule = rom::read_schedule(schedule_path, boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::NetworkOutputs outputs = rom::make_network_outputs(network);
  rom::OperatingState state = boundaries.operating;
  const auto stepper = rom::make_runtime_stepper(network, settings(tolerance_K));
  const rom::NetworkOperator channels(network);
  const rom::CorrectionFactors factors = rom::no_correction(boundaries);

  rom::state_at(schedule, 0.0, state);
  stepper->set_temperatures(
      Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), rom::rest_temperature_K(boundaries, state)));
  Table table(simulation_header(network, outputs));
  for (int cycle = 1; cycle * period_s <= schedule.end_s; ++cycle) {
    rom::state_at(schedule, (cycle - 0.5) * period_s, state);
    rom::evaluate_boundaries(boundaries, state, factors, values);
    if (stepper->advance(period_s, values) != rom::StepStatus::ok) throw std::runtime_error("no solution");
    if (cycle % cycles_per_row != 0) continue;
    const Eigen::VectorXd& nodes_K = stepper->temperatures_K();
    rom::evaluate_outputs(network, nodes_K, outputs);
    channels.laws().at_temperatures(nodes_K, values);
    const rom::CoolantOutlets coolant = rom::coolant_outlets(channels, values, nodes_K);
    table.add(std::vector<double>{cycle * period_s});
    table.add(nodes_K);
    table.add(outputs.key_points_K);
    table.add(outputs.part_mean_K);
    table.add(outputs.part_maximum_K);
    table.add((1e6 * outputs.deformations_m).eval());
    table.add((1e-6 * outputs.contact_pressures_Pa).eval());
    table.add(values.heat_W);
    table.add(coolant.outlet_K);
    table.add(coolant.heat_W);
    table.end_row();
  }
  return table.text();
}

std::string replay(const rom::Network& network, const std::string& network_path, const std::string& log_path,
                   const std::string& law, const std::string& tolerance_K) {
  const host_tools::Log log = host_tools::read_log(log_path, network, 60.0);
  host_tools::ReplayOptions options;
  options.network = network_path;
  options.correction = law;
  Table table(firmware::history_header(network) + "\n");
  std::vector<double> numbers;
  const auto add_cycle = [&](const host_tools::ReplayedCycle& cycle) {
    firmware::history_numbers(cycle.snapshot, numbers);
    table.add(numbers);
    table.end_row();
  };
  host_tools::replay(network, host_tools::plan_replay(network, log, options), log, add_cycle,
                     [&](const rom::Network& of) { return rom::make_runtime_stepper(of, settings(tolerance_K)); });
  return table.text();
}

}  // namespace
}  // namespace spindle_twin::exact_results

int main(int argc, char** argv) {
  using namespace spindle_twin;
  const std::vector<std::string> words(argv + 1, argv + argc);
  const bool simulates = words.size() == 5 && words[0] == "simulate";
  if (!simulates && !(words.size() == 6 && words[0] == "replay")) {
    std::fprintf(stderr,
                 "usage: exact_results simulate X.rom SCHEDULE.csv TOLERANCE_K OUT.csv\n"
                 "       exact_results replay X.rom LOG.csv LAW TOLERANCE_K OUT.csv\n");
    return 2;
  }
  try {
    const rom::Network network = rom::read_network(words[1]);
    rom::write_whole_file(words.back(), simulates
                                            ? exact_results::simulate(network, words[2], words[3])
                                            : exact_results::replay(network, words[1], words[2], words[3], words[4]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
