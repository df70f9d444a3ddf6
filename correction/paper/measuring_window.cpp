#include "correction/paper/measuring_window.hpp"

#include <cmath>

namespace spindle_twin::correction {

MeasuringWindow::MeasuringWindow(Eigen::Index key_points)
    : measured_sum_K_(Eigen::VectorXd::Zero(key_points)),
      predicted_sum_K_(measured_sum_K_),
      valid_samples_(Eigen::VectorXi::Zero(key_points)) {}

void MeasuringWindow::clear() {
  measured_sum_K_.setZero();
  predicted_sum_K_.setZero();
  valid_samples_.setZero();
  samples_ = 0;
}

void MeasuringWindow::add(const Eigen::VectorXd& measured_K, const Eigen::Array<bool, Eigen::Dynamic, 1>& valid,
                          const Eigen::VectorXd& predicted_K) {
  ++samples_;
  predicted_sum_K_ += predicted_K;
  for (Eigen::Index k = 0; k < measured_K.size(); ++k) {
    if (!valid[k] || !std::isfinite(measured_K[k])) continue;
    measured_sum_K_[k] += measured_K[k];
    ++valid_samples_[k];
  }
}

}  // namespace spindle_twin::correction
