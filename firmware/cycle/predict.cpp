#include "firmware/cycle/integrate.hpp"

namespace spindle_twin::firmware {

void predict(const rom::Network& network, Model& model, double expansion) {
  rom::evaluate_outputs(network, model.stepper->temperatures_K(), model.outputs, expansion);
}

}  // namespace spindle_twin::firmware
