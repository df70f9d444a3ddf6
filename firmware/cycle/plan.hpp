#pragma once

#include <array>
#include <optional>

#include "correction/paper/paper_correction.hpp"
#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// The sensor at one key point, and when its reading is believed.
struct SensorPlan {
  bool configured = false;
  double min_K = 253.15;
  double max_K = 423.15;
  double stale_after_s = 3.0;  ///< model time
};

enum class SignalSource { constant, device, plc };

struct SignalPlan {
  SignalSource source = SignalSource::constant;
  double value = 0.0;  ///< of a constant; else what is used until the first good reading
  double min = 0.0;    ///< believed range
  double max = 0.0;
  double stale_after_s = 0.0;  ///< model time; 0: never, for a PLC that writes on change only
};

/// What a cycle needs besides the network; made once from the configuration.
struct CyclePlan {
  double period_s = 1.0;    ///< model time
  double clock_rate = 1.0;  ///< model seconds per second of the clock
  bool compare_uncorrected = true;
  std::array<SensorPlan, slots::key_points> sensors;
  std::array<SignalPlan, signal_count> signals;   ///< flows that no circuit has are constants of 0
  bool correction_enabled = true;                 ///< until the PLC says otherwise
  std::optional<correction::PaperOptions> paper;  ///< empty: no correction law
  std::optional<double> start_temperature_K;      ///< empty: mean of the first good readings
  double start_wait_s = 60.0;                     ///< model time until fewer sensors must do, or a fault is raised
};

}  // namespace spindle_twin::firmware
