#pragma once

#include <string>
#include <vector>

#include "tests/bench/reality/truth.hpp"

namespace spindle_twin::bench {

// Sensors of the reference spindle, by their number; before them those at the rear sleeve.
inline constexpr std::size_t rear_sensors = 3, front_seat = 3, winding = 4, jacket = 5;

enum class Gaps { none, signals_known, signals_held };

/// What a limit of the nose's error is a multiple of.
enum class Measure { present, nominal, open_loop };

struct ErrorLimit {
  Measure of = Measure::present;
  double most = 1.0;
};

/// One way for reality to differ from what the twin takes it for: a truth, and what its sensors and signals say of it.
struct Family {
  std::string name;
  TruthKind truth = TruthKind::nominal;
  bool inside_priors = false;  ///< the filter's own assumptions hold
  bool must_run = false;       ///< nothing is wrong with sensors, signals and machine: `running` at the end
  double lag_s = 0.0;          ///< first order, of all sensors; the twin is told 0
  Gaps gaps = Gaps::none;
  bool touch_offs = false;
  double winding_drift_K_per_h = 0.0;
  double offset_K = 0.02;              ///< 1σ of the sensors' offsets; the twin is told 0.02
  bool exchanged = false;              ///< front seat and jacket
  bool displaced = false;              ///< sensors sit 10 mm off
  double speed_scale = 1.0;            ///< of the speed signal
  bool inlet_untold = false;           ///< the coolant's step is not in its signal
  std::size_t sensors = sensor_count;  ///< the first of them
  double cycle_s = 0.0;                ///< 0: the campaign's
  double run_s = followed_s;
  int most_runs = 1000;  ///< of a dear one
  // What issue "An estimator that survives reality" asks of it; 0: nothing.
  std::vector<ErrorLimit> error_limits = {};
  double least_inside = 0.0;
  double least_inside_of_a_run = 0.0;

  /// Whether this sensor is broken or wired wrongly.
  bool is_faulty(std::size_t sensor) const;
};

/// In the order of the tables; the first is the nominal one.
const std::vector<Family>& all_families();
const Family& nominal_family();

}  // namespace spindle_twin::bench
