#include <cstdio>

#include "fem_offline/exchange_files/calculix_deck.hpp"
#include "fem_offline/exchange_files/freefem_deck.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "host_tools/commands/offline/export_decks.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

std::vector<double> air_K(const fem_offline::AffineModel& model, const Eigen::VectorXd& temperatures_K) {
  const Eigen::VectorXd air = temperatures_K.tail(static_cast<Eigen::Index>(model.air_names.size()));
  return {air.begin(), air.end()};
}

/// Steps grow with the time since the start, as the air's changes slow down.
fem_offline::AirHistory air_history(const fem_offline::AffineModel& model, const rom::BoundaryValues& values,
                                    const fem_offline::DeckPlan& plan) {
  fem_offline::AirHistory history;
  if (model.air_names.empty()) return history;
  history.steady_K = air_K(model, fem_offline::solve_steady(model, values));
  fem_offline::FeStepper stepper(model);
  stepper.set_uniform_temperature(plan.start_K);
  double time_s = 0.0;
  const auto record = [&] {
    history.time_s.push_back(time_s);
    history.air_K.push_back(air_K(model, stepper.temperatures_K()));
  };
  record();
  while (time_s < plan.output_times_s.back()) {
    const double step_s = time_s < 10.0 ? 0.25 : time_s < 60.0 ? 1.0 : 5.0;
    stepper.advance(step_s, 1.0, values);
    time_s += step_s;
    record();
  }
  return history;
}

}  // namespace

void export_decks(const std::string& spindle_path, const std::string& calculix_directory,
                  const std::string& freefem_directory) {
  const fem_offline::Spindle spindle = fem_offline::read_spindle(spindle_path);
  if (!spindle.circuits.empty()) {
    const fem_offline::CoolantCircuit& circuit = spindle.circuits.front();
    throw rom::InputError(
        circuit.where, "coolant_circuit." + circuit.name,
        "cannot be exported: the decks know films at a given temperature only, no coolant that warms up");
  }
  const fem_offline::FeModel fe(spindle, fem_offline::build_section(spindle));
  const fem_offline::AffineModel& model = fe.affine();
  rom::BoundaryValues values = rom::make_boundary_values(model.boundaries);
  rom::evaluate_boundaries(model.boundaries, model.boundaries.operating, rom::no_correction(model.boundaries), values);
  const fem_offline::DeckModel deck = fem_offline::make_deck_model(spindle, values);
  if (!deck.growth_left_out.empty()) {
    std::fprintf(stderr, "warning: %s; the deck holds the thermal part alone\n", deck.growth_left_out.c_str());
  }
  fem_offline::DeckPlan plan;
  plan.start_K = rom::first_environment_K(model.boundaries, rom::EnvironmentKind::ambient, model.boundaries.operating)
                     .value_or(model.boundaries.reference_temperature_K);
  plan.surrounding_K = spindle.operating.surrounding_K;
  if (!calculix_directory.empty()) {
    fem_offline::write_calculix_deck(spindle, deck, plan, air_history(model, values, plan), calculix_directory);
    std::printf("CalculiX deck in %s: %zu nodes, %zu elements\n", calculix_directory.c_str(), deck.nodes.size(),
                deck.elements.size());
  }
  if (!freefem_directory.empty()) {
    fem_offline::write_freefem_deck(spindle, deck, plan, freefem_directory);
    std::printf("FreeFEM deck in %s: %zu parts, %zu triangles\n", freefem_directory.c_str(), spindle.parts.size(),
                2 * deck.elements.size());
  }
}

}  // namespace spindle_twin::host_tools
