#include "firmware/cycle/plausible.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::firmware {
namespace {

Signal signal_of(const rom::Environment& environment) {
  return environment.kind == rom::EnvironmentKind::coolant ? Signal::coolant : Signal::ambient;
}

struct Span {
  double low_K = std::numeric_limits<double>::infinity();
  double high_K = -std::numeric_limits<double>::infinity();
  void take(double value_K) {
    if (!std::isfinite(value_K)) return;
    low_K = std::min(low_K, value_K);
    high_K = std::max(high_K, value_K);
  }
  bool empty() const { return low_K > high_K; }
  double outside_K(double value_K) const { return std::max({0.0, low_K - value_K, value_K - high_K}); }
};

constexpr double least_rise_K = 5.0;
constexpr double most_times = 5.0;

/// The uncorrected model, and how many times higher than its own the rises above the surroundings are.
struct Described {
  double surroundings_K = 0.0;
  double times = 1.0;
  double hotter_K(double uncorrected_K) const {
    return uncorrected_K + (times - 1.0) * std::max(0.0, uncorrected_K - surroundings_K);
  }
};

double furthest_K(const Span& span, const Described& described, const Eigen::VectorXd& predicted_K,
                  const Eigen::VectorXd& uncorrected_K) {
  double furthest = 0.0;
  for (Eigen::Index i = 0; i < predicted_K.size(); ++i) {
    if (!std::isfinite(predicted_K[i])) return std::numeric_limits<double>::infinity();
    const double free_K = span.outside_K(described.hotter_K(uncorrected_K[i]));
    furthest = std::max(furthest, span.outside_K(predicted_K[i]) - free_K);
  }
  return furthest;
}

Described described_by(const rom::Network& network, const Judgement& judgement, const SensedInputs& sensed,
                       const Eigen::VectorXd& uncorrected_K) {
  Described described;
  double sum_K = 0.0, count = 0.0;
  for (const rom::Environment& environment : network.boundaries.environments) {
    const double surroundings_K = judgement.signals[static_cast<std::size_t>(signal_of(environment))];
    if (!std::isfinite(surroundings_K)) continue;
    sum_K += surroundings_K;
    count += 1.0;
  }
  if (count == 0.0) return described;
  described.surroundings_K = sum_K / count;
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    if (judgement.sensors[k] != SensorQuality::good || !std::isfinite(sensed.sensors[k].value)) continue;
    const double rise_K =
        std::max(least_rise_K, uncorrected_K[static_cast<Eigen::Index>(k)] - described.surroundings_K);
    described.times = std::max(described.times, (sensed.sensors[k].value - described.surroundings_K) / rise_K);
  }
  described.times = std::min(described.times, most_times);
  return described;
}

}  // namespace

double outside_K(const rom::Network& network, const Judgement& judgement, const SensedInputs& sensed,
                 const Model& model, const Model& uncorrected) {
  Span span;
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    const SensorQuality quality = judgement.sensors[k];
    const bool read = quality != SensorQuality::not_configured && quality != SensorQuality::out_of_range;
    if (read) span.take(sensed.sensors[k].value);
  }
  for (const rom::Environment& environment : network.boundaries.environments) {
    span.take(judgement.signals[static_cast<std::size_t>(signal_of(environment))]);
  }
  if (span.empty()) return 0.0;
  const Described described = described_by(network, judgement, sensed, uncorrected.outputs.key_points_K);
  return std::max(furthest_K(span, described, model.outputs.key_points_K, uncorrected.outputs.key_points_K),
                  furthest_K(span, described, model.outputs.part_maximum_K, uncorrected.outputs.part_maximum_K));
}

}  // namespace spindle_twin::firmware
