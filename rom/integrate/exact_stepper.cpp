#include "rom/integrate/exact_stepper.hpp"

#include <cmath>
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
  if (rhs_.hold(values) || !decomposed_) {
    modes_.compute(rhs_.lower());
    decomposed_ = modes_.info() == Eigen::Success;
    if (!decomposed_) return StepStatus::integrator_failed;
  }
  modal_.noalias() = modes_.eigenvectors().transpose() * x_;
  modal_drive_.noalias() = modes_.eigenvectors().transpose() * rhs_.drive();
  for (Eigen::Index i = 0; i < modal_.size(); ++i) {
    const double z = modes_.eigenvalues()[i] * period_s;
    const double phi = z == 0.0 ? 1.0 : -std::expm1(-z) / z;
    modal_[i] = std::exp(-z) * modal_[i] + phi * period_s * modal_drive_[i];
  }
  x_new_.noalias() = modes_.eigenvectors() * modal_;
  rhs_.network().to_temperatures(x_new_, candidate_K_);
  if (!candidate_K_.allFinite()) return StepStatus::not_finite;
  x_.swap(x_new_);
  temperatures_K_.swap(candidate_K_);
  return StepStatus::ok;
}

}  // namespace spindle_twin::rom
