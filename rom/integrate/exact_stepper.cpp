#include "rom/integrate/exact_stepper.hpp"

#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>
#include <utility>

namespace spindle_twin::rom {

ExactStepper::ExactStepper(std::shared_ptr<const NetworkOperator> network)
    : rhs_(std::move(network)), modes_(rhs_.network().nodes()) {
  const Eigen::Index n = rhs_.network().nodes();
  x_ = x_new_ = modal_ = modal_drive_ = temperatures_K_ = candidate_K_ = Eigen::VectorXd::Zero(n);
  rhs_.network().to_temperatures(x_, temperatures_K_);
}

void ExactStepper::set_temperatures(const Eigen::VectorXd& temperatures_K) {
  temperatures_K_ = temperatures_K;
  rhs_.network().to_internal(temperatures_K, x_);
}

StepStatus ExactStepper::advance(double period_s, const BoundaryValues& values) {
  if (!(period_s > 0.0) || !std::isfinite(period_s)) return StepStatus::integrator_failed;
  if (!all_finite(values) || !x_.allFinite()) return StepStatus::not_finite;
  if (!accepts(rhs_.network(), values)) return StepStatus::refused;
  held_ = values;
  if (values.laws.follow) rhs_.network().laws().at_temperatures(temperatures_K_, held_);
  if (!all_finite(held_)) return StepStatus::not_finite;
  if (!(rhs_.coupled() ? advance_coupled(period_s, held_) : advance_symmetric(period_s, held_))) {
    return StepStatus::integrator_failed;
  }
  rhs_.network().to_temperatures(x_new_, candidate_K_);
  if (!candidate_K_.allFinite()) return StepStatus::not_finite;
  x_.swap(x_new_);
  temperatures_K_.swap(candidate_K_);
  return StepStatus::ok;
}

bool ExactStepper::advance_symmetric(double period_s, const BoundaryValues& values) {
  const bool changed = rhs_.hold(values);
  const Eigen::VectorXd& inverse_capacity = rhs_.inverse_capacity();
  const bool scaled = inverse_capacity.size() > 0;
  const Eigen::VectorXd scale = inverse_capacity.cwiseSqrt();
  if (changed || !decomposed_) {
    if (scaled) {
      modes_.compute(scale.asDiagonal() * rhs_.lower() * scale.asDiagonal());
    } else {
      modes_.compute(rhs_.lower());
    }
    decomposed_ = modes_.info() == Eigen::Success;
    if (!decomposed_) return false;
  }
  if (scaled) {
    modal_.noalias() = modes_.eigenvectors().transpose() * x_.cwiseQuotient(scale);
    modal_drive_.noalias() = modes_.eigenvectors().transpose() * rhs_.drive().cwiseProduct(scale);
  } else {
    modal_.noalias() = modes_.eigenvectors().transpose() * x_;
    modal_drive_.noalias() = modes_.eigenvectors().transpose() * rhs_.drive();
  }
  for (Eigen::Index i = 0; i < modal_.size(); ++i) {
    const double z = modes_.eigenvalues()[i] * period_s;
    const double phi = z == 0.0 ? 1.0 : -std::expm1(-z) / z;
    modal_[i] = std::exp(-z) * modal_[i] + phi * period_s * modal_drive_[i];
  }
  x_new_.noalias() = modes_.eigenvectors() * modal_;
  if (scaled) x_new_.array() *= scale.array();
  return true;
}

bool ExactStepper::advance_coupled(double period_s, const BoundaryValues& values) {
  const bool changed = rhs_.hold(values);
  const Eigen::VectorXd& inverse_capacity = rhs_.inverse_capacity();
  const bool scaled = inverse_capacity.size() > 0;
  if (changed || exponential_for_s_ != period_s) {
    const Eigen::Index n = rhs_.network().nodes();
    Eigen::MatrixXd generator = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    rhs_.full(generator.topLeftCorner(n, n));
    if (scaled) generator.topLeftCorner(n, n) = inverse_capacity.asDiagonal() * generator.topLeftCorner(n, n);
    generator.topLeftCorner(n, n) *= -period_s;
    generator.topRightCorner(n, n).diagonal().setConstant(period_s);
    const Eigen::MatrixXd flow = generator.exp();
    exponential_ = flow.topLeftCorner(n, n);
    integral_ = flow.topRightCorner(n, n);
    exponential_for_s_ = period_s;
  }
  if (scaled) {
    x_new_.noalias() = exponential_ * x_ + integral_ * rhs_.drive().cwiseProduct(inverse_capacity);
  } else {
    x_new_.noalias() = exponential_ * x_ + integral_ * rhs_.drive();
  }
  return true;
}

}  // namespace spindle_twin::rom
