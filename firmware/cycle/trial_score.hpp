#pragma once

#include <array>

#include "firmware/cycle/snapshot.hpp"

namespace spindle_twin::firmware {

/// How an exchange of networks is judged. All times are model time.
struct ExchangePlan {
  double trial_s = 3600.0;  ///< how long a new network runs beside the old one before it may take over
  double watch_s = 3600.0;  ///< how long the old one runs on beside the new one afterwards
  double margin = 0.1;      ///< the new one's errors may be larger by this share of the old one's
  double margin_K = 0.05;   ///< and by this

  bool operator==(const ExchangePlan&) const = default;
};

/// How well two twins foretell the same readings: for each sensor that one of them believes, the root mean square of
/// reading minus the prediction that the cycle before made for now. Where the uncorrected networks run too, theirs is
/// judged likewise: a correction hides what is wrong in a network as long as there are readings. All functions may run
/// in the cycle.
class TrialScore {
 public:
  /// Forgets what was scored.
  void clear();
  /// One cycle of both. Counts from the second one on. False: no sensor was compared.
  bool add(const Snapshot& running, const Snapshot& beside);

  /// Over all sensors. [K] NaN before there was a reading.
  double running_K() const { return rms(running_.corrected); }
  double beside_K() const { return rms(beside_.corrected); }
  /// The one beside is worse by more than the margin, over all sensors or at one of them, with or without correction.
  bool is_beside_worse(const ExchangePlan& plan) const;
  bool is_running_worse(const ExchangePlan& plan) const;

 private:
  /// What one model said, and how far off it was.
  struct Sums {
    std::array<double, slots::key_points> K2{};
    std::array<double, slots::key_points> count{};
    std::array<double, slots::key_points> said_K = not_values;
  };
  struct Twin {
    Sums corrected, uncorrected;
  };
  static bool add(std::size_t k, double running_K, double beside_K, Sums& running, Sums& beside);
  static double rms(const Sums& sums);
  static bool is_worse(const Sums& one, const Sums& other, const ExchangePlan& plan);
  static bool is_worse(const Twin& one, const Twin& other, const ExchangePlan& plan);

  Twin running_, beside_;
};

}  // namespace spindle_twin::firmware
