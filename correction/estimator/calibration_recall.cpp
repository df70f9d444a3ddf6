#include "correction/estimator/calibration_recall.hpp"

#include <Eigen/Cholesky>
#include <cmath>

namespace spindle_twin::correction {
namespace {

constexpr double variances_left = 2.0;  // k: σ of a parameter that nothing else tells ends at √k times that of the test

}  // namespace

CalibrationRecall::CalibrationRecall(const ParameterModel& parameters, Eigen::Index unknowns) {
  const std::vector<Eigen::Index>& slots = parameters.calibrated_slots();
  const auto n = static_cast<Eigen::Index>(slots.size());
  if (n == 0) return;
  mean_ = Eigen::VectorXd::Zero(unknowns);
  mean_.head(parameters.count()) = parameters.mean();
  const Eigen::MatrixXd covariance = parameters.covariance()(slots, slots);
  Eigen::VectorXd rate(n);  // √D
  for (Eigen::Index i = 0; i < n; ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(slots[static_cast<std::size_t>(i)])];
    rate[i] = parameter.walk_per_root_s / (variances_left * parameter.deviation);
  }
  Eigen::MatrixXd scaled = Eigen::MatrixXd(rate.asDiagonal());
  Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL().solveInPlace(scaled);
  rows_ = Eigen::MatrixXd::Zero(unknowns, n);
  for (Eigen::Index i = 0; i < n; ++i) rows_.row(slots[static_cast<std::size_t>(i)]) = scaled.col(i).transpose();
  row_ = Eigen::VectorXd::Zero(unknowns);
}

void CalibrationRecall::take_in(double elapsed_s, SquareRootFilter& filter) {
  const Eigen::Index rows = rows_.cols();
  if (rows == 0 || !(elapsed_s > 0.0)) return;
  row_ = rows_.col(next_);
  next_ = (next_ + 1) % rows;
  const double innovation = row_.dot(mean_) - row_.dot(filter.mean());
  filter.update(row_, innovation, 1.0 / (static_cast<double>(rows) * elapsed_s));
}

}  // namespace spindle_twin::correction
