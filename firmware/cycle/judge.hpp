#pragma once

#include "firmware/cycle/sense.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// What is believed. Signals keep their last good value in `signals` from cycle to cycle.
struct Judgement {
  std::array<SensorQuality, slots::key_points> sensors{};
  std::array<double, signal_count> signals{};
  std::uint16_t quality = 0;                             ///< the Quality bits that sensors and signals raise
  std::array<std::int64_t, signal_count> believed_ns{};  ///< when each signal's value was read; 0: never
  std::uint16_t signals_held = 0;                        ///< bit s: signal s is not believed, what it was is in use
  std::uint16_t signals_implausible = 0;  ///< of these, those outside their limits or faster than these allow
  std::size_t configured = 0;
  std::size_t good = 0;
  double data_age_s = not_a_value;  ///< oldest good sensor reading
};

/// Signals at the plan's values, nothing read.
Judgement first_judgement(const CyclePlan& plan);

/// Each sensor: configured, read, finite, in range, fresh, in this order. A signal that fails the same tests is held,
/// likewise one that changes faster than it may, until so much time has passed, and those of a PLC that is silent. Runs
/// in the cycle.
void judge(const CyclePlan& plan, const SensedInputs& sensed, Judgement& judgement);

/// The operating state that the network's boundaries see: every coolant circuit at the coolant inlet temperature,
/// every other environment at ambient, every circuit's flow and every measured heat as judged (a heat that was never
/// told is NaN); current and power where they are known. Runs in the cycle; `operating` is already sized.
void set_operating(const rom::Network& network, const Judgement& judgement, rom::OperatingState& operating);

}  // namespace spindle_twin::firmware
