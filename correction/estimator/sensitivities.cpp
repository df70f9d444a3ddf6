#include "correction/estimator/sensitivities.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double gamma = 1.0 - 1.0 / std::numbers::sqrt2;
/// States per block of the substitution: the buffers of Eigen's products stay below 128 kB, up to which it takes them
/// from the stack.
constexpr Eigen::Index states_at_once = 100;

}  // namespace

Sensitivities::Sensitivities(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> the_operator,
                             const ParameterModel& parameters)
    : operator_(std::move(the_operator)), network_(&network) {
  const Eigen::Index n = operator_->nodes();
  count_ = parameters.count();
  // Vector instructions take four rows at a time; the rest would cost as much again.
  const Eigen::Index p = (count_ + 3) / 4 * 4;
  padded_ = Eigen::VectorXd::Zero(p);
  capacity_root_ = Eigen::LLT<Eigen::MatrixXd>(network.capacity_J_per_K).matrixL();
  set_factors(network);
  sources_ = network.source_distribution;
  source_rows_ = network.source_distribution.transpose();
  if (sources_.cols() > 0) capacity_root_.triangularView<Eigen::Lower>().solveInPlace(sources_);
  transposed_ = stage_ = impulse_ = Eigen::MatrixXd::Zero(p, n);
  drive_ = Eigen::MatrixXd::Zero(n, p);
  lower_ = Eigen::MatrixXd::Zero(n, n);
  packed_ = operator_->make_packed();
  mean_K_ = x_ = shift_ = unused_drive_ = Eigen::VectorXd::Zero(n);
  rises_K_ = Eigen::VectorXd::Zero(sources_.cols());
  const Eigen::Index segments = operator_->segments().count();
  coupling_ = Eigen::MatrixXd::Zero(segments, segments);
  wall_sensitivity_ = fed_sensitivity_ = Eigen::MatrixXd::Zero(p, segments);
  wall_rises_K_ = Eigen::VectorXd::Zero(segments);
  starts_.resize(parameters.starts(), n);
  for (Eigen::Index k = 0; k < starts_.rows(); ++k) {
    starts_.row(k) = parameters.shapes()[static_cast<std::size_t>(k)].rise_K.transpose() * capacity_root_;
  }
  if (parameters.has_disturbances()) {
    group_heats_.resize(n, static_cast<Eigen::Index>(parameters.groups().size()));
    for (Eigen::Index g = 0; g < group_heats_.cols(); ++g) {
      const ThermalGroup& group = parameters.groups()[static_cast<std::size_t>(g)];
      group_heats_.col(g) = capacity_root_.transpose() * group.indicator / group.capacity_J_per_K;
    }
  }
  if (parameters.has_capacities()) inertia_ = Eigen::VectorXd::Ones(n);
  law_values_ = make_boundary_values(network.boundaries);
  law_values_.node_heat_W = Eigen::VectorXd::Zero(n);
  law_values_.capacity_factor = Eigen::VectorXd::Ones(n);
  law_inputs_ = Eigen::VectorXd::Zero(operator_->laws().rows().cols());
  law_slopes_ = Eigen::MatrixXd::Zero(operator_->laws().count(), static_cast<Eigen::Index>(rom::law_readings));
}

/// L⁻¹F_j side by side, their column sums, and what films to an environment give.
void Sensitivities::set_factors(const rom::Network& network) {
  const Eigen::Index n = operator_->nodes();
  Eigen::Index columns = 0;
  for (const Eigen::MatrixXd& factor : network.factors_m) {
    first_.push_back(columns);
    columns += factor.cols();
  }
  first_.push_back(columns);
  Eigen::MatrixXd factors(n, columns);
  column_sums_.resize(columns);
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd& factor = network.factors_m[j];
    factors.middleCols(first_[j], factor.cols()) = factor;
    column_sums_.segment(first_[j], factor.cols()) = factor.colwise().sum().transpose();
  }
  if (columns > 0) capacity_root_.triangularView<Eigen::Lower>().solveInPlace(factors);
  films_ = Eigen::MatrixXd::Zero(n, static_cast<Eigen::Index>(network.factors_m.size()));
  for (Eigen::Index j = 0; j < films_.cols(); ++j) {
    const auto index = static_cast<std::size_t>(j);
    if (network.boundaries.conductances[index].environment < 0) continue;
    const Eigen::Index begin = first_[index], count = first_[index + 1] - begin;
    films_.col(j) = factors.middleCols(begin, count) * column_sums_.segment(begin, count);
  }
  factors_ = std::make_shared<const Eigen::MatrixXd>(std::move(factors));
}

void Sensitivities::start(const ParameterModel& parameters) {
  transposed_.setZero();
  restart(parameters);
}

void Sensitivities::restart(const ParameterModel& parameters) {
  if (parameters.start() >= 0) transposed_.middleRows(parameters.start(), starts_.rows()) = starts_;
}

void Sensitivities::set_start(const Eigen::VectorXd& column_K, const ParameterModel& parameters) {
  transposed_.row(parameters.start()) = column_K.transpose() * capacity_root_;
}

void Sensitivities::internal_row(const Eigen::VectorXd& row, Eigen::VectorXd& internal) const {
  internal = row;
  capacity_root_.triangularView<Eigen::Lower>().solveInPlace(internal);
}

void Sensitivities::source_rises(const Eigen::VectorXd& nodes_K, Eigen::VectorXd& rises_K) const {
  rises_K.noalias() = source_rows_ * nodes_K;
  rises_K.array() -= operator_->reference_K();
}

void Sensitivities::correct(const Eigen::VectorXd& theta_step, Eigen::VectorXd& nodes_K) {
  padded_.head(count_) = theta_step;
  padded_.tail(padded_.size() - count_).setZero();
  shift_.noalias() = transposed_.transpose() * padded_;
  capacity_root_.transpose().triangularView<Eigen::Upper>().solveInPlace(shift_);
  nodes_K += shift_;
}

Eigen::MatrixXd Sensitivities::in_kelvin() const {
  Eigen::MatrixXd result = transposed_.topRows(count_).transpose();
  capacity_root_.transpose().triangularView<Eigen::Upper>().solveInPlace(result);
  return result;
}

void Sensitivities::drive(const HeldInterval& held, const ParameterModel& parameters) {
  mean_K_ = 0.5 * (held.start_K + held.end_K);
  operator_->to_internal(mean_K_, x_);
  source_rises(mean_K_, rises_K_);
  drive_.setZero();
  drive_by_heats(held, parameters);
  drive_by_conductances(held, parameters);
  for (Eigen::Index g = 0; g < group_heats_.cols(); ++g) drive_.col(parameters.disturbance(g)) = group_heats_.col(g);
  for (Eigen::Index i = 0; i < inertia_.size(); ++i) {
    const double rate_K_per_s = (held.end_K[i] - held.start_K[i]) / held.period_s;
    drive_(i, parameters.capacity(i)) = -inertia_[i] * capacity_root_(i, i) * rate_K_per_s;
  }
  if (operator_->segments().count() == 0) return;
  drive_by_coolant(held, parameters);
  weaken_by_coolant(held, parameters);
}

void Sensitivities::drive_by_heats(const HeldInterval& held, const ParameterModel& parameters) {
  const double log_x = parameters.log_speed(held.speed_rpm);
  for (Eigen::Index i = 0; i < sources_.cols(); ++i) {
    const double heat_W = held.values.heat_W[i];
    if (heat_W == 0.0) continue;
    const auto into = [&](int slot, double weight) {
      if (slot >= 0) drive_.col(slot) += weight * sources_.col(i);
    };
    into(parameters.heat(i), heat_W);
    into(parameters.exponent(i), heat_W * log_x);
    if (parameters.is_friction(i)) into(parameters.bearing(), -heat_W * rises_K_[i]);
  }
}

/// Of conductances and of the environments behind them.
void Sensitivities::drive_by_conductances(const HeldInterval& held, const ParameterModel& parameters) {
  const double reference_K = operator_->reference_K();
  const rom::Boundaries& boundaries = network_->boundaries;
  for (std::size_t j = 0; j + 1 < first_.size(); ++j) {
    const auto index = static_cast<Eigen::Index>(j);
    const double conductance = held.values.conductance_W_per_m2K[index];
    if (conductance == 0.0) continue;
    const int environment = boundaries.conductances[j].environment;
    const double rise_K = environment < 0 ? 0.0 : held.values.environment_K[environment] - reference_K;
    const int bias = environment < 0 ? -1 : parameters.environment(environment);
    if (bias >= 0) drive_.col(bias) += conductance * films_.col(index);
    const int slot = parameters.conductance(static_cast<int>(index));
    if (slot < 0) continue;
    auto effect = drive_.col(slot);
    // Column by column, each used twice while it is at hand: the factors come from memory in the order in which they
    // lie, which is what they cost.
    for (Eigen::Index column = first_[j]; column < first_[j + 1]; ++column) {
      const auto factor = factors_->col(column);
      effect -= conductance * (factor.dot(x_) - rise_K * column_sums_[column]) * factor;
    }
  }
}

/// What the liquid has taken up before a segment lowers that segment's flow.
void Sensitivities::drive_by_coolant(const HeldInterval& held, const ParameterModel& parameters) {
  const rom::CoolantSegments& segments = operator_->segments();
  const double reference_K = operator_->reference_K();
  operator_->couple(held.values, coupling_, wall_rises_K_, unused_drive_);
  wall_rises_K_.noalias() = operator_->walls().transpose() * x_;
  for (Eigen::Index s = 0; s < segments.count(); ++s) {
    const auto segment = static_cast<std::size_t>(s);
    const double inlet_K = held.values.environment_K[segments.inlet[segment]] - reference_K;
    const int bias = parameters.environment(segments.inlet[segment]);
    double fed_W = 0.0;
    for (Eigen::Index up = 0; up < segments.count(); ++up) {
      fed_W += coupling_(s, up) * (wall_rises_K_[up] - inlet_K * segments.area_m2[up]);
      if (bias >= 0) drive_.col(bias) -= coupling_(s, up) * segments.area_m2[up] * operator_->walls().col(s);
    }
    const int slot = parameters.conductance(segments.conductance[segment]);
    const double conductance = held.values.conductance_W_per_m2K[segments.conductance[segment]];
    if (slot < 0 || conductance == 0.0) continue;
    drive_.col(slot) += fed_W * operator_->walls().col(s);
    // What a segment takes up more, those behind it are fed.
    const double over_liquid_K = wall_rises_K_[s] - (inlet_K + fed_W / conductance) * segments.area_m2[s];
    for (Eigen::Index down = 0; down < segments.count(); ++down) {
      drive_.col(slot) += coupling_(down, s) * over_liquid_K * operator_->walls().col(down);
    }
  }
}

/// d(G/A)/d ln h of a segment is below G/A: the liquid warms up along it.
void Sensitivities::weaken_by_coolant(const HeldInterval& held, const ParameterModel& parameters) {
  const rom::CoolantSegments& segments = operator_->segments();
  for (std::size_t c = 0; c + 1 < segments.first.size(); ++c) {
    const double flow_W_per_K = std::abs(held.values.coolant_W_per_K[static_cast<Eigen::Index>(c)]);
    for (int s = segments.first[c]; s < segments.first[c + 1]; ++s) {
      const int conductance = segments.conductance[static_cast<std::size_t>(s)];
      const int slot = parameters.conductance(conductance);
      if (slot < 0 || flow_W_per_K == 0.0) continue;
      const double share = held.values.conductance_W_per_m2K[conductance] * segments.area_m2[s] / flow_W_per_K;
      // G = W (1 − e^(−NTU)): dG/d ln h = G NTU / (e^NTU − 1), nothing where a trickle leaves at the wall's temperature
      const double transfer_units = share < 1.0 ? -std::log1p(-share) : std::numeric_limits<double>::infinity();
      const double left = std::isinf(transfer_units) ? 0.0 : transfer_units / std::expm1(transfer_units);
      if (transfer_units > 0.0) drive_.col(slot) *= left;
    }
  }
}

/// Right-hand side R ← (L Lᵀ)⁻¹ R for its transpose. Block by block: the buffers for a whole matrix would come from the
/// heap.
void Sensitivities::substitute(Eigen::MatrixXd& right_side) const {
  const Eigen::Index n = right_side.cols(), blocks = (n + states_at_once - 1) / states_at_once;
  const auto first = [&](Eigen::Index block) { return block * n / blocks; };
  const auto states = [&](Eigen::Index block) {
    return right_side.middleCols(first(block), first(block + 1) - first(block));
  };
  const auto factor = [&](Eigen::Index row, Eigen::Index column) {
    return lower_.block(first(row), first(column), first(row + 1) - first(row), first(column + 1) - first(column));
  };
  for (Eigen::Index i = 0; i < blocks; ++i) {
    auto present = states(i);
    for (Eigen::Index before = 0; before < i; ++before) {
      present.noalias() -= states(before) * factor(i, before).transpose();
    }
    factor(i, i).transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(present);
  }
  for (Eigen::Index i = blocks - 1; i >= 0; --i) {
    auto present = states(i);
    for (Eigen::Index after = i + 1; after < blocks; ++after) present.noalias() -= states(after) * factor(after, i);
    factor(i, i).triangularView<Eigen::Lower>().solveInPlace<Eigen::OnTheRight>(present);
  }
}

/// A heat that follows its parts' temperatures acts back on the source's own rise by its slope; the difference between
/// the parts that it reads and the places where it acts is left out, which keeps the matrix symmetric.
void Sensitivities::add_law_slopes(const HeldInterval& held) {
  const rom::LawTerms& laws = operator_->laws();
  if (laws.empty()) return;
  law_values_ = held.values;
  operator_->to_internal(held.end_K, x_);
  law_inputs_ = laws.offset();
  law_inputs_.noalias() += laws.rows().transpose() * x_;
  laws.evaluate(law_inputs_, law_values_, law_slopes_);
  for (Eigen::Index t = 0; t < laws.count(); ++t) {
    const int source = laws.list()[static_cast<std::size_t>(t)].source;
    if (source < 0) continue;
    const double loss_W_per_K = -(law_slopes_(t, 0) + law_slopes_(t, 1));
    lower_.selfadjointView<Eigen::Lower>().rankUpdate(sources_.col(source), loss_W_per_K);
  }
}

bool Sensitivities::advance(const HeldInterval& held, const ParameterModel& parameters) {
  if (!(held.period_s > 0.0)) return true;
  const double step = gamma * held.period_s;
  operator_->assemble(held.values.conductance_W_per_m2K, packed_, lower_);
  const int bearing = parameters.bearing();
  const double loss_per_K = bearing < 0 ? 0.0 : held.theta[bearing];
  for (Eigen::Index i = 0; i < sources_.cols(); ++i) {
    if (!parameters.is_friction(i) || loss_per_K == 0.0) continue;
    lower_.selfadjointView<Eigen::Lower>().rankUpdate(sources_.col(i), loss_per_K * held.values.heat_W[i]);
  }
  add_law_slopes(held);
  lower_ *= step;
  for (Eigen::Index i = 0; i < inertia_.size(); ++i) inertia_[i] = std::exp(held.theta[parameters.capacity(i)]);
  if (inertia_.size() > 0) {
    lower_.diagonal() += inertia_;
  } else {
    lower_.diagonal().array() += 1.0;
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> cholesky(lower_);  // in place
  if (cholesky.info() != Eigen::Success) return false;

  drive(held, parameters);
  if (coupling_.size() > 0) {
    for (Eigen::Index s = 0; s < coupling_.rows(); ++s) {
      wall_sensitivity_.col(s).noalias() = transposed_ * operator_->walls().col(s);
    }
    for (Eigen::Index s = 0; s < coupling_.rows(); ++s) {
      fed_sensitivity_.col(s).noalias() = wall_sensitivity_ * coupling_.row(s).transpose();
      drive_.noalias() += operator_->walls().col(s) * fed_sensitivity_.col(s).transpose();
    }
  }
  impulse_ = step * drive_.transpose();
  const auto weigh = [&](Eigen::MatrixXd& matrix) {
    for (Eigen::Index i = 0; i < inertia_.size(); ++i) matrix.col(i) *= inertia_[i];
  };
  stage_ = transposed_;
  weigh(stage_);
  stage_ += impulse_;
  substitute(stage_);
  transposed_ += ((1.0 - gamma) / gamma) * (stage_ - transposed_);
  weigh(transposed_);
  transposed_ += impulse_;
  substitute(transposed_);
  return true;
}

}  // namespace spindle_twin::correction
