#pragma once

#include "firmware/config/config.hpp"

namespace spindle_twin::firmware {

/// What is believed of a signal that somebody tells: as configured, otherwise
/// what rom::plausible_inputs believes, the coolant changing by 2 K/s at most, the ambient by 0.5 K/s,
/// and of the others what the configuration file allows as a number. Constants are believed as they are.
void limit_signal(const ConfiguredSignal& configured, std::size_t signal, const rom::Network& network,
                  SignalPlan& plan);

/// How far published deformations may be from zero: as configured, otherwise what 200 K more in all nodes at once
/// could make at most. Throws rom::InputError for an output that the network does not have.
void limit_outputs(const Config& config, const rom::Network& network, CyclePlan& plan);

}  // namespace spindle_twin::firmware
