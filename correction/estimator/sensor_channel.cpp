#include "correction/estimator/sensor_channel.hpp"

#include <cmath>
#include <utility>

namespace spindle_twin::correction {
namespace {

constexpr double shortest_lag_share = 1e-3;  // of a step: below, the sensor follows at once

}  // namespace

double lag(double y, double u0, double u1, double h_s, double tau_s) {
  if (tau_s <= 0.0) return u1;
  if (h_s <= 0.0) return y;
  const double keep = std::exp(-h_s / tau_s);
  return keep * y + (1.0 - keep) * u0 + (u1 - u0) * (1.0 - (1.0 - keep) * tau_s / h_s);
}

double lag_slope(double slope, double y, double u0, double u1, double h_s, double tau_s) {
  if (h_s <= 0.0) return slope;
  if (tau_s <= shortest_lag_share * h_s) return -(u1 - u0) / h_s;
  const double keep = std::exp(-h_s / tau_s);
  const double keep_slope = keep * h_s / (tau_s * tau_s);
  return keep * slope + keep_slope * (y - u0) + (u1 - u0) * (keep_slope * tau_s - (1.0 - keep)) / h_s;
}

SensorChannel::SensorChannel(Eigen::VectorXd internal, Eigen::Index parameters)
    : internal_(std::move(internal)), before_(Eigen::VectorXd::Zero(parameters)), shown_(before_) {}

void SensorChannel::start(double model_K) {
  temperature_K_ = shown_K_ = model_K;
  lag_slope_ = 0.0;
  shown_.setZero();
  before_.setZero();
  fused_s = never_s;
  clear();
}

void SensorChannel::clear() {
  readings_K_ = residuals_K_ = lag_slopes_ = 0.0;
  samples_ = 0;
}

void SensorChannel::predict(double model_K, double elapsed_s, double lag_s) {
  lag_slope_ = lag_slope(lag_slope_, shown_K_, temperature_K_, model_K, elapsed_s, lag_s);
  shown_K_ = lag(shown_K_, temperature_K_, model_K, elapsed_s, lag_s);
  temperature_K_ = model_K;
}

void SensorChannel::observe(double reading_K) {
  if (!std::isfinite(reading_K)) return;
  readings_K_ += reading_K;
  residuals_K_ += reading_K - shown_K_;
  lag_slopes_ += lag_slope_;
  ++samples_;
}

double SensorChannel::mean_reading_K() const {
  return samples_ > 0 ? readings_K_ / samples_ : std::numeric_limits<double>::quiet_NaN();
}

double SensorChannel::mean_residual_K() const {
  return samples_ > 0 ? residuals_K_ / samples_ : std::numeric_limits<double>::quiet_NaN();
}

void SensorChannel::end_period(const Eigen::VectorXd& place, double period_s, double lag_s) {
  for (Eigen::Index i = 0; i < shown_.size(); ++i) shown_[i] = lag(shown_[i], before_[i], place[i], period_s, lag_s);
}

void SensorChannel::set_sensitivity_from(Eigen::Index first, const Eigen::VectorXd& place) {
  shown_.tail(shown_.size() - first) = place.tail(place.size() - first);
}

void SensorChannel::restore(const Eigen::VectorXd& shown, double lag_slope_K_per_s) {
  shown_ = shown;
  lag_slope_ = lag_slope_K_per_s;
}

void SensorChannel::correct(const Eigen::VectorXd& place, const Eigen::VectorXd& step, double lag_step_s) {
  temperature_K_ += place.dot(step);
  shown_K_ += shown_.dot(step) + lag_slope_ * lag_step_s;
}

}  // namespace spindle_twin::correction
