#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"
#include "correction/health/isothermal_tare.hpp"
#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// What a cycle needs to go on after a restart, and what its estimator knows. Its sizes are those of network and plan.
struct Remembered {            // NOLINT(public-members): a checkpoint as it is written, member by member
  bool started = false;        ///< else the rest is without meaning
  std::string network_sha256;  ///< hex; empty: nobody said
  double model_time_s = 0.0;
  double tare_m = 0.0;
  double trial_away_m = 0.0;  ///< how far a trial had the compensation from where it is wanted; Compensation::away_m()
  correction::SensorTare sensor_tare;  ///< per key point
  /// Four of each key point: SensorFault that it is out for, whether until acknowledged (2: and read for its
  /// partner's place meanwhile), its partner, its failures.
  /// Empty where no health is watched.
  std::vector<double> sensor_health;
  /// Two of each key point: what it read more than the model in the last minutes in which it was used [K], and how long
  /// ago that was [s]. Empty in what was written before it was kept.
  std::vector<double> sensor_course;
  std::array<double, signal_count> signals = not_values;
  std::vector<double> nodes_K;
  std::vector<double> uncorrected_K;
  std::string layout;       ///< names of the estimator's parameters and sensors; empty without one that corrects
  std::string spindle;      ///< that the network is of; empty in what was written before it was kept
  std::string calibration;  ///< origin of the one that the estimator began with; empty: none
  std::string unknowns;     ///< names of the estimator's, a line each, in its order
  correction::EstimatorState estimator;
  std::vector<correction::ParameterEstimate> parameters;
};

/// What it says of the machine, for an estimator of other days, sensors or networks. Nothing without an estimator that
/// corrected, and from what was written before names were kept.
std::optional<correction::KnownParameters> known_of_machine(const Remembered& from);

/// A value too large for a triple buffer, from one thread that fills it when another has asked for it. Neither waits
/// for the other; between fill() and the next ask() the value is the asking thread's.
template <class T>
class OnRequest {
 public:
  T value;

  void ask() { asked_.store(true, std::memory_order_release); }
  bool asked() const { return asked_.load(std::memory_order_acquire); }
  void fill() { asked_.store(false, std::memory_order_release); }

 private:
  std::atomic<bool> asked_{false};
};

}  // namespace spindle_twin::firmware
