#include "rom/integrate/right_hand_side.hpp"

#include <algorithm>
#include <cmath>
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
      held_coolant_W_per_K_(Eigen::VectorXd::Zero(network_->circuits())),
      node_drive_(drive_),
      capacity_factor_(Eigen::VectorXd::Ones(network_->nodes())),
      inverse_capacity_(capacity_factor_) {
  const Eigen::Index segments = network_->segments().count();
  coupling_ = Eigen::MatrixXd::Zero(segments, segments);
  walls_ = fed_ = Eigen::VectorXd::Zero(segments);
  walls_by_coupling_ = Eigen::MatrixXd::Zero(network_->nodes(), segments);
  const LawTerms& laws = network_->laws();
  if (laws.empty()) return;
  Eigen::Index rank = 0;
  for (const LawTerm& term : laws.list()) rank = std::max(rank, term.direction.cols());
  through_ = Eigen::VectorXd::Zero(rank);
  readings_ = Eigen::VectorXd::Zero(laws.rows().cols());
  feedback_ = Eigen::MatrixXd::Zero(network_->feedback_columns().cols(), network_->feedback_columns().cols());
  slopes_ = Eigen::MatrixXd::Zero(laws.count(), static_cast<Eigen::Index>(law_readings));
  now_drive_ = by_value_ = by_state_ = drive_;
  wall_rise_K_ = weights_ = walls_;
  now_.conductance_W_per_m2K = assembled_for_W_per_m2K_;
  now_.heat_W = Eigen::VectorXd::Zero(network_->sources());
  now_.environment_K = Eigen::VectorXd::Zero(network_->environments());
  now_.coolant_W_per_K = held_coolant_W_per_K_;
  now_.laws.flow_kg_per_s = held_coolant_W_per_K_;
  now_.laws.heat_factor = now_.heat_W;
  now_.laws.conductance_factor = now_.conductance_W_per_m2K;
  base_ = now_;
}

bool RightHandSide::follow(const BoundaryValues& values, const double* x) {
  if (!values.laws.follow || network_->laws().empty()) return hold(values);
  constexpr double nearest_share = 0.02;
  now_ = base_ = values;
  follow_to(Eigen::Map<const Eigen::VectorXd>(x, drive_.size()));
  for (const LawTerm& term : network_->laws().list()) {
    if (term.conductance < 0) continue;
    const double before = assembled_for_W_per_m2K_[term.conductance];
    const double present = now_.conductance_W_per_m2K[term.conductance];
    const bool near = assembled_ && std::abs(present - before) <= nearest_share * std::abs(before);
    base_.conductance_W_per_m2K[term.conductance] = near ? before : present;
  }
  if (!base_.conductance_W_per_m2K.allFinite()) base_.conductance_W_per_m2K = values.conductance_W_per_m2K;
  const bool changed = hold(base_);
  following_ = true;
  return changed;
}

bool RightHandSide::hold(const BoundaryValues& values) {
  following_ = false;
  network_->drive_of_sources(values, drive_);
  has_node_heat_ = values.node_heat_W.size() > 0;
  if (has_node_heat_) {
    network_->drive_of_nodes(values, node_drive_);
    drive_ += node_drive_;
  }
  bool changed = set_capacities(values.capacity_factor);
  if (coupled()) {
    network_->couple(values, coupling_, walls_, drive_);
    changed = changed || held_coolant_W_per_K_ != values.coolant_W_per_K;
    held_coolant_W_per_K_ = values.coolant_W_per_K;
  }
  if (assembled_ && assembled_for_W_per_m2K_ == values.conductance_W_per_m2K) return changed;
  assemble(values.conductance_W_per_m2K);
  assembled_for_W_per_m2K_ = values.conductance_W_per_m2K;
  assembled_ = true;
  return true;
}

/// Whether they differ from the ones before.
bool RightHandSide::set_capacities(const Eigen::VectorXd& capacity_factor) {
  if (capacity_factor.size() == 0) return std::exchange(scaled_, false);
  if (scaled_ && capacity_factor_ == capacity_factor) return false;
  scaled_ = true;
  capacity_factor_ = capacity_factor;
  inverse_capacity_ = capacity_factor.cwiseInverse();
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
  if (following_) follow_to(state);
  rate = following_ ? now_drive_ : drive_;
  rate.noalias() -= lower_.selfadjointView<Eigen::Lower>() * state;
  if (following_) {
    for (const LawTerm& term : network_->laws().list()) {
      if (term.conductance < 0) continue;
      const double moved = now_.conductance_W_per_m2K[term.conductance] - assembled_for_W_per_m2K_[term.conductance];
      auto through = through_.head(term.direction.cols());
      through.noalias() = term.direction.transpose() * state;
      through *= moved;
      rate.noalias() -= term.direction * through;
    }
  }
  if (coupled()) {
    walls_.noalias() = network_->walls().transpose() * state;
    fed_.noalias() = coupling_ * walls_;
    rate.noalias() += network_->walls() * fed_;
  }
  if (scaled_) rate.array() *= inverse_capacity_.array();
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

/// Heats, conductances, drive and coupling at x.
void RightHandSide::follow_to(const Eigen::Ref<const Eigen::VectorXd>& x) const {
  const LawTerms& laws = network_->laws();
  readings_ = laws.offset();
  readings_.noalias() += laws.rows().transpose() * x;
  laws.evaluate(readings_, now_, slopes_);
  network_->drive_of_sources(now_, now_drive_);
  if (has_node_heat_) now_drive_ += node_drive_;
  if (coupled()) network_->couple(now_, coupling_, walls_, now_drive_);
}

/// by_value_ = −∂f/∂gⱼ at x:  F̃ⱼ (F̃ⱼᵀx − Fⱼᵀ1 (T_env − T_ref)), less what it does to the liquid that comes and goes on.
void RightHandSide::set_conductance_slope(const LawTerm& term, const Eigen::Ref<const Eigen::VectorXd>& x) const {
  auto through = through_.head(term.direction.cols());
  through.noalias() = term.direction.transpose() * x;
  if (term.environment >= 0) {
    through -= (now_.environment_K[term.environment] - network_->reference_K()) * term.column_sums;
  }
  by_value_.noalias() = term.direction * through;
  if (term.segment < 0) return;
  const CoolantSegments& segments = network_->segments();
  wall_rise_K_.noalias() = network_->walls().transpose() * x;
  for (Eigen::Index s = 0; s < segments.count(); ++s) {
    const int inlet = segments.inlet[static_cast<std::size_t>(s)];
    wall_rise_K_[s] = wall_rise_K_[s] / segments.area_m2[s] - (now_.environment_K[inlet] - network_->reference_K());
  }
  coolant_slope(segments, now_, wall_rise_K_, static_cast<std::size_t>(term.circuit), term.segment, weights_);
  by_value_.noalias() -= network_->walls() * weights_;
}

const Eigen::MatrixXd& RightHandSide::feedback(const double* x) const {
  const LawTerms& laws = network_->laws();
  if (laws.empty()) return coupling_;
  feedback_.setZero();
  if (following_) follow_to(Eigen::Map<const Eigen::VectorXd>(x, drive_.size()));
  const Eigen::Index segments = coupling_.rows();
  feedback_.topLeftCorner(segments, segments) = coupling_;
  if (!following_) return feedback_;
  Eigen::Index heat = segments;
  const Eigen::Index first_reading = feedback_.cols() - laws.rows().cols();
  for (Eigen::Index t = 0; t < laws.count(); ++t) {
    const LawTerm& term = laws.list()[static_cast<std::size_t>(t)];
    if (term.source < 0) continue;
    for (std::size_t k = 0; k < law_readings; ++k) {
      if (term.reading[k] < 0) continue;
      feedback_(heat, first_reading + term.reading[k]) += slopes_(t, static_cast<Eigen::Index>(k));
    }
    ++heat;
  }
  return feedback_;
}

void RightHandSide::linearise(const double* x, Eigen::Ref<Eigen::MatrixXd> target) const {
  if (following_) follow_to(Eigen::Map<const Eigen::VectorXd>(x, drive_.size()));
  full(target);
  if (following_) add_law_slopes(Eigen::Map<const Eigen::VectorXd>(x, drive_.size()), target);
  if (!scaled_) return;
  for (Eigen::Index column = 0; column < target.cols(); ++column) {
    target.col(column).array() *= inverse_capacity_.array();
  }
}

/// To −∂f/∂x of held laws what they add by following the state x, at which now_ and slopes_ are.
void RightHandSide::add_law_slopes(const Eigen::Ref<const Eigen::VectorXd>& state,
                                   Eigen::Ref<Eigen::MatrixXd> target) const {
  const LawTerms& laws = network_->laws();
  for (Eigen::Index t = 0; t < laws.count(); ++t) {
    const LawTerm& term = laws.list()[static_cast<std::size_t>(t)];
    by_state_.setZero();
    for (std::size_t k = 0; k < law_readings; ++k) {
      if (term.reading[k] < 0) continue;
      by_state_ += slopes_(t, static_cast<Eigen::Index>(k)) * laws.rows().col(term.reading[k]);
    }
    if (term.source >= 0) {
      target.noalias() -= term.direction.col(0) * by_state_.transpose();
      continue;
    }
    set_conductance_slope(term, state);
    target.noalias() += by_value_ * by_state_.transpose();
    const double moved = now_.conductance_W_per_m2K[term.conductance] - assembled_for_W_per_m2K_[term.conductance];
    for (Eigen::Index column = 0; column < term.direction.cols(); ++column) {
      by_value_ = moved * term.direction.col(column);
      target.noalias() += by_value_ * term.direction.col(column).transpose();
    }
  }
}

bool all_finite(const BoundaryValues& values) {
  return values.conductance_W_per_m2K.allFinite() && values.heat_W.allFinite() && values.environment_K.allFinite() &&
         values.coolant_W_per_K.allFinite() && std::isfinite(values.laws.speed_rpm) &&
         std::isfinite(values.laws.load) && std::isfinite(values.laws.current_A.value_or(0.0)) &&
         std::isfinite(values.laws.power_W.value_or(0.0)) && values.laws.flow_kg_per_s.allFinite() &&
         values.laws.heat_factor.allFinite() && values.laws.conductance_factor.allFinite() &&
         values.node_heat_W.allFinite() && values.capacity_factor.allFinite();
}

bool accepts(const NetworkOperator& network, const BoundaryValues& values) {
  const Eigen::Index heats = values.node_heat_W.size(), factors = values.capacity_factor.size();
  if (heats != 0 && heats != network.nodes()) return false;
  if (factors == 0) return true;
  return factors == network.nodes() && network.diagonal_capacity() && (values.capacity_factor.array() > 0.0).all();
}

}  // namespace spindle_twin::rom
