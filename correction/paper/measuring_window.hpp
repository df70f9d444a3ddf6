#pragma once

#include <Eigen/Core>

namespace spindle_twin::correction {

/// What the sensors read and what the model said at their places, averaged alike over the last part of a period. One
/// entry per key point. No allocation after construction; may run in the cycle.
class MeasuringWindow {
 public:
  explicit MeasuringWindow(Eigen::Index key_points);

  void clear();
  /// One instant; a reading that is not valid or not finite leaves its key point incomplete.
  void add(const Eigen::VectorXd& measured_K, const Eigen::Array<bool, Eigen::Dynamic, 1>& valid,
           const Eigen::VectorXd& predicted_K);

  int samples() const { return samples_; }
  /// Whether every sample had a reading of this key point; its means say nothing otherwise.
  bool is_complete(Eigen::Index key_point) const { return valid_samples_[key_point] >= samples_; }
  double measured_K(Eigen::Index key_point) const { return measured_sum_K_[key_point] / samples_; }
  double predicted_K(Eigen::Index key_point) const { return predicted_sum_K_[key_point] / samples_; }
  /// Mean of measured − predicted.
  double residual_K(Eigen::Index key_point) const {
    return (measured_sum_K_[key_point] - predicted_sum_K_[key_point]) / samples_;
  }

 private:
  Eigen::VectorXd measured_sum_K_, predicted_sum_K_;
  Eigen::VectorXi valid_samples_;
  int samples_ = 0;
};

}  // namespace spindle_twin::correction
