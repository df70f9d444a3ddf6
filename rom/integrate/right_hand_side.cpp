#include "rom/integrate/right_hand_side.hpp"

#include <utility>

namespace spindle_twin::rom {

RightHandSide::RightHandSide(std::shared_ptr<const NetworkOperator> network)
    : network_(std::move(network)),
      assembled_for_W_per_m2K_(Eigen::VectorXd::Zero(network_->conductances())),
      base_W_per_m2K_(Eigen::VectorXd::Zero(network_->conductances())),
      base_packed_(network_->make_packed()),
      packed_(base_packed_),
      lower_(Eigen::MatrixXd::Zero(network_->nodes(), network_->nodes())),
      drive_(Eigen::VectorXd::Zero(network_->nodes())),
      held_coolant_W_per_K_(Eigen::VectorXd::Zero(network_->circuits())) {
  const Eigen::Index segments = network_->segments().count();
  coupling_ = Eigen::MatrixXd::Zero(segments, segments);
  walls_ = fed_ = Eigen::VectorXd::Zero(segments);
  walls_by_coupling_ = Eigen::MatrixXd::Zero(network_->nodes(), segments);
}

bool RightHandSide::hold(const BoundaryValues& values) {
  network_->drive(values, drive_);
  bool new_flow = false;
  if (coupled()) {
    network_->couple(values, coupling_, walls_, drive_);
    new_flow = held_coolant_W_per_K_ != values.coolant_W_per_K;
    held_coolant_W_per_K_ = values.coolant_W_per_K;
  }
  if (assembled_ && assembled_for_W_per_m2K_ == values.conductance_W_per_m2K) return new_flow;
  assemble(values.conductance_W_per_m2K);
  assembled_for_W_per_m2K_ = values.conductance_W_per_m2K;
  assembled_ = true;
  return true;
}

void RightHandSide::assemble(const Eigen::VectorXd& conductance_W_per_m2K) {
  const Eigen::Index others = (conductance_W_per_m2K.array() != base_W_per_m2K_.array()).count();
  if (!assembled_ || 2 * others > base_W_per_m2K_.size()) {
    network_->assemble(conductance_W_per_m2K, base_packed_, lower_);
    base_W_per_m2K_ = conductance_W_per_m2K;
  } else {
    network_->assemble_from(base_W_per_m2K_, base_packed_, conductance_W_per_m2K, packed_, lower_);
  }
}

void RightHandSide::evaluate(const double* x, double* dx) const {
  const Eigen::Map<const Eigen::VectorXd> state(x, drive_.size());
  Eigen::Map<Eigen::VectorXd> rate(dx, drive_.size());
  rate = drive_;
  rate.noalias() -= lower_.selfadjointView<Eigen::Lower>() * state;
  if (!coupled()) return;
  walls_.noalias() = network_->walls().transpose() * state;
  fed_.noalias() = coupling_ * walls_;
  rate.noalias() += network_->walls() * fed_;
}

void RightHandSide::full(Eigen::Ref<Eigen::MatrixXd> target) const {
  const Eigen::Index n = lower_.rows();
  for (Eigen::Index column = 0; column < n; ++column) {
    target.col(column).tail(n - column) = lower_.col(column).tail(n - column);
    target.row(column).tail(n - column) = lower_.col(column).tail(n - column).transpose();
  }
  if (!coupled()) return;
  walls_by_coupling_ = network_->walls().lazyProduct(coupling_);
  // Segment by segment: Eigen's product of whole matrices may take its buffers from the heap.
  for (Eigen::Index s = 0; s < coupling_.cols(); ++s) {
    target.noalias() -= walls_by_coupling_.col(s) * network_->walls().col(s).transpose();
  }
}

bool all_finite(const BoundaryValues& values) {
  return values.conductance_W_per_m2K.allFinite() && values.heat_W.allFinite() && values.environment_K.allFinite() &&
         values.coolant_W_per_K.allFinite();
}

}  // namespace spindle_twin::rom
