#pragma once

#include <cstddef>

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

/// Puts the value of signal `s` (a Signal, a flow or a measured heat; K, rpm, kg/s, W) where an operating state has it:
/// coolant into every coolant environment, ambient into every other, current and power as unknown where NaN. A flow or
/// a heat that the network does not have changes nothing. Runs in the cycle; `operating` is already sized.
void put_signal(const rom::Boundaries& boundaries, std::size_t s, double value, rom::OperatingState& operating);

/// The operating state that the network's boundaries see: put_signal of every signal as judged (a heat that was never
/// told is NaN). Runs in the cycle; `operating` is already sized.
void set_operating(const rom::Network& network, const Judgement& judgement, rom::OperatingState& operating);

}  // namespace spindle_twin::firmware
