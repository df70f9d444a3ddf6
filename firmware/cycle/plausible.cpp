#include "firmware/cycle/plausible.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::firmware {
namespace {

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

double furthest_K(const Span& span, const Eigen::VectorXd& predicted_K, const Eigen::VectorXd& uncorrected_K) {
  double furthest = 0.0;
  for (Eigen::Index i = 0; i < predicted_K.size(); ++i) {
    if (!std::isfinite(predicted_K[i])) return std::numeric_limits<double>::infinity();
    furthest = std::max(furthest, span.outside_K(predicted_K[i]) - span.outside_K(uncorrected_K[i]));
  }
  return furthest;
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
    const Signal which = environment.kind == rom::EnvironmentKind::coolant ? Signal::coolant : Signal::ambient;
    span.take(judgement.signals[static_cast<std::size_t>(which)]);
  }
  if (span.empty()) return 0.0;
  return std::max(furthest_K(span, model.outputs.key_points_K, uncorrected.outputs.key_points_K),
                  furthest_K(span, model.outputs.part_maximum_K, uncorrected.outputs.part_maximum_K));
}

}  // namespace spindle_twin::firmware
