#pragma once

#include <functional>
#include <memory>

#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// Makes the stepper of one model; tests give one that fails.
using MakeStepper = std::function<std::unique_ptr<rom::FallbackStepper>(const rom::Network&)>;

/// One network in time: its stepper, the inputs of the right-hand side and what it says now.
struct Model {
  std::unique_ptr<rom::FallbackStepper> stepper;
  rom::BoundaryValues values;
  rom::NetworkOutputs outputs;
};

/// Allocates.
Model make_model(const rom::Network& network, const MakeStepper& make_stepper);

enum class Integrated { by_cvode, by_exact_stepper, not_at_all };

/// Heats and conductances of the operating state times the factors, then advance_s of model time. When CVODE fails
/// the exact stepper makes the step from the last good state; when that fails too the state stays as it was.
/// Runs in the cycle, no allocation unless the exact stepper is needed.
Integrated integrate(const rom::Network& network, const rom::OperatingState& operating,
                     const rom::CorrectionFactors& factors, double advance_s, Model& model);

/// y = H T, d = expansion · L (T − T_ref) at the model's present state. Runs in the cycle.
void predict(const rom::Network& network, Model& model, double expansion = 1.0);

}  // namespace spindle_twin::firmware
