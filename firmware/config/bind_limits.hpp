#pragma once

#include "firmware/config/config.hpp"

namespace spindle_twin::firmware {

/// What is believed of a signal that somebody tells: as configured, otherwise
///   speed     up to twice the fastest of the description's speeds and of those that the certificate was measured at
///   load      up to 3 times the rated one
///   coolant   within 25 K of the description's, changing by 2 K/s at most; ambient within 30 K, by 0.5 K/s
///   flow      up to 5 times the description's, either way
/// and of the others what the configuration file allows as a number. Constants are believed as they are.
void limit_signal(const ConfiguredSignal& configured, std::size_t signal, const rom::Network& network,
                  SignalPlan& plan);

/// How far published deformations may be from zero: as configured, otherwise what 200 K more in all nodes at once
/// could make at most. Throws rom::InputError for an output that the network does not have.
void limit_outputs(const Config& config, const rom::Network& network, CyclePlan& plan);

}  // namespace spindle_twin::firmware
