#include "correction/health/exchange_detector.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::correction {

ExchangeDetector::ExchangeDetector(std::size_t channels)
    : movements_(channels),
      product_K2_(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(channels), static_cast<Eigen::Index>(channels))),
      reading_square_K2_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(channels))),
      model_square_K2_(reading_square_K2_) {}

double ExchangeDetector::HighPass::pass(double x, double h_s, double tau_s) {
  if (!started_) mean_ = x;
  started_ = true;
  const double out = x - mean_;
  mean_ += (1.0 - std::exp(-h_s / tau_s)) * out;
  return out;
}

void ExchangeDetector::note_model(std::size_t channel, double uncorrected_K, double h_s, const HealthLimits& limits) {
  Movement& movement = movements_[channel];
  movement.model_K = movement.model_filter.pass(uncorrected_K, h_s, limits.swap_window_s);
}

void ExchangeDetector::note_reading(std::size_t channel, double reading_K, double elapsed_s,
                                    const HealthLimits& limits) {
  Movement& movement = movements_[channel];
  movement.reading_K = movement.reading_filter.pass(reading_K, elapsed_s, limits.swap_window_s);
}

void ExchangeDetector::accumulate(double h_s, const HealthLimits& limits) {
  const double weight = 1.0 - std::exp(-h_s / limits.swap_window_s);
  for (std::size_t i = 0; i < movements_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double reading_K = movements_[i].reading_K, model_K = movements_[i].model_K;
    reading_square_K2_[row] += weight * (reading_K * reading_K - reading_square_K2_[row]);
    model_square_K2_[row] += weight * (model_K * model_K - model_square_K2_[row]);
    for (std::size_t j = 0; j < movements_.size(); ++j) {
      double& product_K2 = product_K2_(row, static_cast<Eigen::Index>(j));
      product_K2 += weight * (reading_K * movements_[j].model_K - product_K2);
    }
  }
}

double ExchangeDetector::left_over_K2(std::size_t reading, std::size_t model) const {
  const auto i = static_cast<Eigen::Index>(reading);
  const auto j = static_cast<Eigen::Index>(model);
  const double square_K2 = reading_square_K2_[i], product_K2 = product_K2_(i, j), model_K2 = model_square_K2_[j];
  if (!(product_K2 > 0.0 && model_K2 > 0.0)) return square_K2;
  return std::max(0.0, square_K2 - product_K2 * product_K2 / model_K2);
}

bool ExchangeDetector::move_exchanged(std::size_t one, std::size_t other, const HealthLimits& limits) const {
  const double least_K2 = limits.swap_K * limits.swap_K;
  const double own_one_K2 = left_over_K2(one, one), own_other_K2 = left_over_K2(other, other);
  return own_one_K2 > least_K2 && own_other_K2 > least_K2 &&
         left_over_K2(one, other) + left_over_K2(other, one) < limits.swap_share * (own_one_K2 + own_other_K2);
}

}  // namespace spindle_twin::correction
