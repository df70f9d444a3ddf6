#include "correction/health/swap_detector.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::correction {
namespace {

constexpr double impossible = -std::numeric_limits<double>::infinity();
constexpr double least_gain = 0.05;  // so that ln stays finite; beyond eight σ of it
constexpr std::size_t middle = 1;    // the scale at which gains are compared

Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

}  // namespace

SwapDetector::SwapDetector(const std::vector<double>& noise_K)
    : noise_K_(Eigen::Map<const Eigen::VectorXd>(noise_K.data(), index(noise_K.size()))),
      seen_s_(Eigen::VectorXd::Zero(noise_K_.size())) {
  const Eigen::Index n = noise_K_.size();
  for (Scale& scale : scales_) {
    scale.reading_filters.resize(noise_K.size());
    scale.model_filters.resize(noise_K.size());
    scale.model_K = scale.reading_square_K2 = scale.model_fourth_K4 = Eigen::VectorXd::Zero(n);
    scale.product_K2 = scale.model_square_K2 = Eigen::MatrixXd::Zero(n, n);
  }
}

double SwapDetector::HighPass::pass(double x, double h_s, double tau_s, double first) {
  if (!started_) mean_ = x - first;
  started_ = true;
  const double out = x - mean_;
  mean_ += (1.0 - std::exp(-h_s / tau_s)) * out;
  return out;
}

void SwapDetector::note_model(std::size_t channel, double uncorrected_K, double h_s) {
  for (std::size_t s = 0; s < scales_.size(); ++s) {
    scales_[s].model_K[index(channel)] = scales_[s].model_filters[channel].pass(uncorrected_K, h_s, scales_s[s]);
  }
}

void SwapDetector::note_reading(std::size_t channel, double reading_K, double elapsed_s, bool counts,
                                const HealthLimits& limits) {
  const Eigen::Index i = index(channel);
  const double weight_s = std::min(elapsed_s, scales_s.front());  // what moved in a long gap was not seen
  const double keep = std::exp(-elapsed_s / limits.swap_memory_s);
  if (counts) seen_s_[i] = keep * seen_s_[i] + weight_s;
  for (std::size_t s = 0; s < scales_.size(); ++s) {
    Scale& scale = scales_[s];
    const double moved_K = scale.reading_filters[channel].pass(reading_K, elapsed_s, scales_s[s], scale.model_K[i]);
    if (!counts) continue;
    scale.reading_square_K2[i] = keep * scale.reading_square_K2[i] + weight_s * moved_K * moved_K;
    for (Eigen::Index j = 0; j < noise_K_.size(); ++j) {
      const double model_K = scale.model_K[j];
      scale.product_K2(i, j) = keep * scale.product_K2(i, j) + weight_s * moved_K * model_K;
      scale.model_square_K2(i, j) = keep * scale.model_square_K2(i, j) + weight_s * model_K * model_K;
    }
    const double square_K2 = scale.model_K[i] * scale.model_K[i];
    scale.model_fourth_K4[i] = keep * scale.model_fourth_K4[i] + weight_s * square_K2 * square_K2;
  }
}

void SwapDetector::forget(std::size_t channel) {
  const Eigen::Index i = index(channel);
  seen_s_[i] = 0.0;
  for (Scale& scale : scales_) {
    scale.reading_filters[channel] = {};
    scale.reading_square_K2[i] = scale.model_fourth_K4[i] = 0.0;
    scale.product_K2.row(i).setZero();
    scale.model_square_K2.row(i).setZero();
  }
}

SwapDetector::Fit SwapDetector::fit(const Scale& scale, Eigen::Index reading, Eigen::Index place) {
  const double square_K2 = scale.reading_square_K2[reading], product_K2 = scale.product_K2(reading, place);
  const double model_K2 = scale.model_square_K2(reading, place);
  if (!(product_K2 > 0.0 && model_K2 > 0.0)) return {0.0, square_K2};
  const double gain = product_K2 / model_K2;
  return {gain, std::max(0.0, square_K2 - gain * product_K2)};
}

double SwapDetector::independent_samples(const Scale& scale, double scale_s, Eigen::Index place) {
  const double square_K2 = scale.model_square_K2(place, place), fourth_K4 = scale.model_fourth_K4[place];
  return fourth_K4 > 0.0 ? square_K2 * square_K2 / fourth_K4 / scale_s : 0.0;
}

double SwapDetector::gain_penalty(Eigen::Index reading, Eigen::Index place, const HealthLimits& limits) const {
  const double square_K2 = scales_[middle].reading_square_K2[reading];
  if (!(square_K2 > 0.0)) return 0.0;
  const double log_gain = std::log(std::clamp(fit(scales_[middle], reading, place).gain, least_gain, 1.0 / least_gain));
  const double unsure = limits.swap_K * limits.swap_K * seen_s_[reading] / square_K2;
  return log_gain * log_gain / (limits.swap_gain * limits.swap_gain + unsure);
}

double SwapDetector::evidence(std::size_t one, std::size_t other, const HealthLimits& limits) const {
  const Eigen::Index i = index(one), j = index(other);
  if (std::min(seen_s_[i], seen_s_[j]) < limits.swap_least_s) return impossible;
  double one_gains = 0.0, other_gains = 0.0;
  for (std::size_t s = 0; s < scales_.size(); ++s) {
    const Scale& scale = scales_[s];
    const double samples =
        std::min(independent_samples(scale, scales_s[s], i), independent_samples(scale, scales_s[s], j));
    const auto gains = [&](Eigen::Index reading, Eigen::Index place, double& sum) {
      const double noise_K2 = noise_K_[reading] * noise_K_[reading] * seen_s_[reading];
      const double square_K2 = scale.reading_square_K2[reading];
      const double least_K2 = limits.swap_floor * limits.swap_floor * square_K2 + noise_K2;
      const double there_K2 = fit(scale, reading, place).left_over_K2;
      sum += samples * std::log((fit(scale, reading, reading).left_over_K2 + least_K2) / (there_K2 + least_K2));
      return there_K2 <= limits.swap_fit * limits.swap_fit * square_K2 + noise_K2;
    };
    if (!gains(i, j, one_gains) || !gains(j, i, other_gains)) return impossible;
  }
  // The comparison is false for what is no number, too.
  if (!(one_gains > 0.0 && other_gains > 0.0)) return impossible;
  return one_gains + other_gains + gain_penalty(i, i, limits) + gain_penalty(j, j, limits) -
         gain_penalty(i, j, limits) - gain_penalty(j, i, limits);
}

int SwapDetector::partner_of(std::size_t channel, const std::vector<bool>& in_use, const HealthLimits& limits) const {
  int partner = -1;
  double most = limits.swap_support;
  for (std::size_t i = 0; i < in_use.size(); ++i) {
    if (i == channel || !in_use[i]) continue;
    const double sum = evidence(channel, i, limits);
    if (!(sum > most)) continue;
    most = sum;
    partner = static_cast<int>(i);
  }
  return partner;
}

SwapDetector::Pair SwapDetector::find(const std::vector<bool>& in_use, const HealthLimits& limits) const {
  Pair found;
  double most = limits.swap_limit;
  for (std::size_t i = 0; i < in_use.size(); ++i) {
    for (std::size_t j = i + 1; j < in_use.size(); ++j) {
      if (!in_use[i] || !in_use[j]) continue;
      const double sum = evidence(i, j, limits);
      if (!(sum > most)) continue;
      most = sum;
      found = {static_cast<int>(i), static_cast<int>(j)};
    }
  }
  return found;
}

}  // namespace spindle_twin::correction
