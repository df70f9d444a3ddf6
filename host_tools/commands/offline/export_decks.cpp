#include <cstdio>

#include "fem_offline/exchange_files/calculix_deck.hpp"
#include "fem_offline/exchange_files/freefem_deck.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/solve/coolant_coupling.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "host_tools/commands/offline/export_decks.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

/// Volumes of air, then the liquid that enters each segment: the order of DeckModel::fluids.
std::vector<double> fluid_K(const fem_offline::AffineModel& model, const fem_offline::CoolantCoupling& coupling,
                            const Eigen::VectorXd& temperatures_K) {
  const Eigen::VectorXd air_K = temperatures_K.tail(static_cast<Eigen::Index>(model.air_names.size()));
  std::vector<double> all_K(air_K.begin(), air_K.end());
  if (coupling.empty()) return all_K;
  const Eigen::VectorXd liquid_K = coupling.entering_K(temperatures_K);
  all_K.insert(all_K.end(), liquid_K.begin(), liquid_K.end());
  return all_K;
}

/// Steps grow with the time since the start, as the fluids' changes slow down.
fem_offline::FluidHistory fluid_history(const fem_offline::AffineModel& model, const rom::BoundaryValues& values,
                                        const fem_offline::DeckPlan& plan) {
  fem_offline::FluidHistory history;
  fem_offline::CoolantCoupling coupling(model);
  if (model.air_names.empty() && coupling.empty()) return history;
  coupling.hold(values);
  history.steady_K = fluid_K(model, coupling, fem_offline::solve_steady(model, values));
  fem_offline::FeStepper stepper(model);
  stepper.set_uniform_temperature(plan.start_K);
  double time_s = 0.0;
  const auto record = [&] {
    history.time_s.push_back(time_s);
    history.fluid_K.push_back(fluid_K(model, coupling, stepper.temperatures_K()));
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
  fem_offline::Spindle spindle = fem_offline::read_spindle(spindle_path);
  spindle.mesh.curved_arcs =
      false;  // as the decks have it, so that the fluids' temperatures are those of the same body
  const fem_offline::FeModel fe(spindle, fem_offline::build_section(spindle));
  const fem_offline::AffineModel& model = fe.affine();
  rom::BoundaryValues values = rom::make_boundary_values(model.boundaries);
  rom::evaluate_boundaries(model.boundaries, model.boundaries.operating, rom::no_correction(model.boundaries), values);
  const fem_offline::DeckModel deck = fem_offline::make_deck_model(spindle, values);
  if (!deck.growth_left_out.empty()) {
    std::fprintf(stderr, "warning: %s; the deck holds the thermal part alone\n", deck.growth_left_out.c_str());
  }
  fem_offline::DeckPlan plan;
  plan.start_K = rom::rest_temperature_K(model.boundaries, model.boundaries.operating);
  plan.surrounding_K = spindle.operating.surrounding_K;
  if (!calculix_directory.empty()) {
    fem_offline::write_calculix_deck(spindle, deck, plan, fluid_history(model, values, plan), calculix_directory);
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
