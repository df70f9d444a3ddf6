#include "rom/integrate/right_hand_side.hpp"

#include <utility>

namespace spindle_twin::rom {

RightHandSide::RightHandSide(std::shared_ptr<const NetworkOperator> network)
    : network_(std::move(network)),
      assembled_for_W_per_m2K_(Eigen::VectorXd::Zero(network_->conductances())),
      packed_(network_->make_packed()),
      lower_(Eigen::MatrixXd::Zero(network_->nodes(), network_->nodes())),
      drive_(Eigen::VectorXd::Zero(network_->nodes())) {}

bool RightHandSide::hold(const BoundaryValues& values) {
  network_->drive(values, drive_);
  if (assembled_ && assembled_for_W_per_m2K_ == values.conductance_W_per_m2K) return false;
  network_->assemble(values.conductance_W_per_m2K, packed_, lower_);
  assembled_for_W_per_m2K_ = values.conductance_W_per_m2K;
  assembled_ = true;
  return true;
}

void RightHandSide::evaluate(const double* x, double* dx) const {
  const Eigen::Map<const Eigen::VectorXd> state(x, drive_.size());
  Eigen::Map<Eigen::VectorXd> rate(dx, drive_.size());
  rate = drive_;
  rate.noalias() -= lower_.selfadjointView<Eigen::Lower>() * state;
}

bool all_finite(const BoundaryValues& values) {
  return values.conductance_W_per_m2K.allFinite() && values.heat_W.allFinite() && values.environment_K.allFinite();
}

}  // namespace spindle_twin::rom
