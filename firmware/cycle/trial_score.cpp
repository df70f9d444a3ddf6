#include "firmware/cycle/trial_score.hpp"

#include <cmath>
#include <numeric>
#include <utility>

namespace spindle_twin::firmware {

void TrialScore::clear() { running_ = beside_ = {}; }

/// The errors of both at key point k; NaN where one has none.
bool TrialScore::add(std::size_t k, double running_K, double beside_K, Sums& running, Sums& beside) {
  if (!std::isfinite(running_K) || !std::isfinite(beside_K)) return false;
  running.K2[k] += running_K * running_K;
  beside.K2[k] += beside_K * beside_K;
  running.count[k] += 1.0;
  beside.count[k] += 1.0;
  return true;
}

bool TrialScore::add(const Snapshot& running, const Snapshot& beside) {
  bool compared = false;
  for (std::size_t k = 0; k < running.key_points; ++k) {
    // A wrong network holds healthy sensors for broken, so one that believes in it is enough.
    const bool good =
        running.sensor_quality[k] == SensorQuality::good || beside.sensor_quality[k] == SensorQuality::good;
    const auto off_K = [&](const Snapshot& snapshot, double predicted_K, Sums& sums) {
      const double said_K = std::exchange(sums.said_K[k], predicted_K);
      return good ? snapshot.measured_K[k] - said_K : not_a_value;
    };
    const double running_K = off_K(running, running.predicted_K[k], running_.corrected);
    const double beside_K = off_K(beside, beside.predicted_K[k], beside_.corrected);
    const double running_uncorrected_K = off_K(running, running.uncorrected_K[k], running_.uncorrected);
    const double beside_uncorrected_K = off_K(beside, beside.uncorrected_K[k], beside_.uncorrected);
    compared = add(k, running_K, beside_K, running_.corrected, beside_.corrected) || compared;
    add(k, running_uncorrected_K, beside_uncorrected_K, running_.uncorrected, beside_.uncorrected);
  }
  return compared;
}

double TrialScore::rms(const Sums& sums) {
  const double count = std::accumulate(sums.count.begin(), sums.count.end(), 0.0);
  return count > 0.0 ? std::sqrt(std::accumulate(sums.K2.begin(), sums.K2.end(), 0.0) / count) : not_a_value;
}

bool TrialScore::is_worse(const Sums& one, const Sums& other, const ExchangePlan& plan) {
  const auto beyond = [&](double one_K, double other_K) {
    return one_K > (1.0 + plan.margin) * other_K + plan.margin_K;
  };
  if (beyond(rms(one), rms(other))) return true;
  for (std::size_t k = 0; k < one.K2.size(); ++k) {
    if (one.count[k] == 0.0) continue;
    if (beyond(std::sqrt(one.K2[k] / one.count[k]), std::sqrt(other.K2[k] / other.count[k]))) return true;
  }
  return false;
}

bool TrialScore::is_worse(const Twin& one, const Twin& other, const ExchangePlan& plan) {
  return is_worse(one.corrected, other.corrected, plan) || is_worse(one.uncorrected, other.uncorrected, plan);
}

bool TrialScore::is_beside_worse(const ExchangePlan& plan) const { return is_worse(beside_, running_, plan); }
bool TrialScore::is_running_worse(const ExchangePlan& plan) const { return is_worse(running_, beside_, plan); }

}  // namespace spindle_twin::firmware
