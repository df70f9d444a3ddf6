#include "firmware/cycle/integrate.hpp"

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::firmware {

Model make_model(const rom::Network& network, const MakeStepper& make_stepper) {
  return {make_stepper(network), rom::make_boundary_values(network.boundaries), rom::make_network_outputs(network)};
}

Integrated integrate(const rom::Network& network, const rom::OperatingState& operating,
                     const rom::CorrectionFactors& factors, double advance_s, Model& model) {
  rom::evaluate_boundaries(network.boundaries, operating, factors, model.values);
  if (model.stepper->advance(advance_s, model.values) != rom::StepStatus::ok) return Integrated::not_at_all;
  return model.stepper->first_status() == rom::StepStatus::ok ? Integrated::by_cvode : Integrated::by_exact_stepper;
}

}  // namespace spindle_twin::firmware
