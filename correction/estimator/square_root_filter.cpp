#include "correction/estimator/square_root_filter.hpp"

#include <cmath>
#include <stdexcept>

namespace spindle_twin::correction {

SquareRootFilter::SquareRootFilter(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance)
    : mean_(mean), scale_(covariance.diagonal().cwiseSqrt()), cholesky_(mean.size()) {
  const Eigen::Index n = mean.size();
  if (covariance.rows() != n || covariance.cols() != n || !(covariance.diagonal().array() > 0.0).all()) {
    throw std::invalid_argument("a covariance needs one positive variance per entry of the mean");
  }
  const Eigen::VectorXd inverse = scale_.cwiseInverse();
  square_ = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  cholesky_.compute(square_);
  if (cholesky_.info() != Eigen::Success) throw std::invalid_argument("a covariance is not positive definite");
  root_ = cholesky_.matrixL();
  scaled_ = projected_ = gain_ = Eigen::VectorXd::Zero(n);
}

void SquareRootFilter::pass_time(const Eigen::VectorXd& centre, const Eigen::VectorXd& keep,
                                 const Eigen::VectorXd& variance) {
  for (Eigen::Index i = 0; i < size(); ++i) {
    if (keep[i] == 1.0) continue;
    mean_[i] = centre[i] + keep[i] * (mean_[i] - centre[i]);
    root_.row(i) *= keep[i];
  }
  add_variance(variance);
}

void SquareRootFilter::widen(const Eigen::VectorXd& factor, const Eigen::VectorXd& variance) {
  for (Eigen::Index i = 0; i < size(); ++i) root_.row(i) *= factor[i];
  add_variance(variance);
}

void SquareRootFilter::add_variance(const Eigen::VectorXd& variance) {
  const Eigen::Index n = size();
  // Column by column: Eigen's product of whole matrices may take its buffers from the heap.
  for (Eigen::Index column = 0; column < n; ++column) {
    square_.col(column).tail(n - column).noalias() = root_.bottomRows(n - column) * root_.row(column).transpose();
    square_(column, column) += variance[column] / (scale_[column] * scale_[column]);
  }
  cholesky_.compute(square_);
  if (cholesky_.info() != Eigen::Success) return;  // W stays: an unchanged root is still a root
  root_.setZero();
  for (Eigen::Index column = 0; column < n; ++column) {
    root_.col(column).tail(n - column) = cholesky_.matrixLLT().col(column).tail(n - column);
  }
}

double SquareRootFilter::variance_of(const Eigen::VectorXd& h) {
  scaled_ = h.cwiseProduct(scale_);
  projected_.noalias() = root_.transpose() * scaled_;
  return projected_.squaredNorm();
}

double SquareRootFilter::variance_of(const Eigen::VectorXd& h, Eigen::VectorXd& covariance) {
  const double variance = variance_of(h);
  covariance.noalias() = root_ * projected_;
  covariance.array() *= scale_.array();
  return variance;
}

double SquareRootFilter::variance_of_first(const Eigen::VectorXd& h_first) {
  const Eigen::Index n = h_first.size();
  scaled_.head(n) = h_first.cwiseProduct(scale_.head(n));
  projected_.noalias() = root_.topRows(n).transpose() * scaled_.head(n);
  return projected_.squaredNorm();
}

double SquareRootFilter::variance_of_first(const Eigen::VectorXd& h_first, Eigen::VectorXd& covariance) {
  const double variance = variance_of_first(h_first);
  const Eigen::Index n = h_first.size();
  covariance.noalias() = root_.topRows(n) * projected_;
  covariance.array() *= scale_.head(n).array();
  return variance;
}

bool SquareRootFilter::update(const Eigen::VectorXd& h, double innovation, double noise) {
  const double total = variance_of(h) + noise;
  if (!std::isfinite(total) || !std::isfinite(innovation) || !(noise > 0.0)) return false;
  gain_.noalias() = root_ * projected_;
  mean_.array() += gain_.array() * scale_.array() * (innovation / total);
  const double shrink = 1.0 / (total + std::sqrt(total * noise));
  root_.noalias() -= (shrink * gain_) * projected_.transpose();
  return true;
}

double SquareRootFilter::deviation(Eigen::Index i) const { return scale_[i] * root_.row(i).norm(); }

Eigen::MatrixXd SquareRootFilter::covariance() const {
  const Eigen::MatrixXd scaled = scale_.asDiagonal() * root_;
  return scaled * scaled.transpose();
}

}  // namespace spindle_twin::correction
