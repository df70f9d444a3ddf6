#include "rom/integrate/network_operator.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "rom/require.hpp"

namespace spindle_twin::rom {
namespace {

constexpr Eigen::Index block_entries = 512;

Eigen::VectorXd packed_lower(const Eigen::MatrixXd& symmetric) {
  const Eigen::Index n = symmetric.rows();
  Eigen::VectorXd packed(n * (n + 1) / 2);
  for (Eigen::Index column = 0, at = 0; column < n; at += n - column, ++column) {
    packed.segment(at, n - column) = symmetric.col(column).tail(n - column);
  }
  return packed;
}

void require_shapes(const Network& network) {
  const Eigen::Index n = network.capacity_J_per_K.rows();
  require(n > 0 && network.capacity_J_per_K.cols() == n, "the capacity matrix is not square");
  require(network.conduction_W_per_K.rows() == n && network.conduction_W_per_K.cols() == n,
          "the conduction matrix has not the shape of the capacity matrix");
  require(network.source_distribution.rows() == n, "the source distribution has not one row per node");
  require(network.boundaries.conductances.size() == network.factors_m.size(), "not one factor per conductance");
}

}  // namespace

NetworkOperator::NetworkOperator(const Network& network)
    : segments_(coolant_segments(network.boundaries)),
      environments_(static_cast<Eigen::Index>(network.boundaries.environments.size())),
      reference_K_(network.boundaries.reference_temperature_K) {
  require_shapes(network);
  set_capacity(network.capacity_J_per_K);
  const auto root = capacity_root_.triangularView<Eigen::Lower>();
  Eigen::MatrixXd conduction = network.conduction_W_per_K;
  root.solveInPlace(conduction);
  capacity_root_.transpose().triangularView<Eigen::Upper>().solveInPlace<Eigen::OnTheRight>(conduction);
  packed_conduction_ = packed_lower(0.5 * (conduction + conduction.transpose()));
  set_conductances(network);
  set_walls(network);
  sources_ = network.source_distribution;
  if (sources_.cols() > 0) root.solveInPlace(sources_);
  laws_ = LawTerms(network, capacity_root_, segments_);
  if (!laws_.empty()) set_feedback_columns();
}

/// L, and what follows from the capacities alone.
void NetworkOperator::set_capacity(const Eigen::MatrixXd& capacity) {
  const Eigen::LLT<Eigen::MatrixXd> cholesky(capacity);
  require(cholesky.info() == Eigen::Success, "the capacity matrix is not positive definite");
  capacity_root_ = cholesky.matrixL();
  diagonal_capacity_ = capacity == Eigen::MatrixXd(capacity.diagonal().asDiagonal());
  internal_per_kelvin_ = std::sqrt(capacity.sum() / static_cast<double>(capacity.rows()));
}

/// All K̃ⱼ in blocks, and the columns of those that have an environment.
void NetworkOperator::set_conductances(const Network& network) {
  const auto root = capacity_root_.triangularView<Eigen::Lower>();
  const Eigen::Index n = nodes();
  const Eigen::Index count = conductances_ = static_cast<Eigen::Index>(network.factors_m.size());
  conductance_terms_.resize(packed_conduction_.size() * count);
  films_.resize(n, count);
  for (Eigen::Index j = 0; j < count; ++j) {
    Eigen::MatrixXd factor = network.factors_m[static_cast<std::size_t>(j)];
    require(factor.rows() == n, "a conductance factor has not one row per node");
    const Eigen::VectorXd column_sums = factor.colwise().sum().transpose();
    root.solveInPlace(factor);
    const Eigen::VectorXd term = packed_lower(factor * factor.transpose());
    for (Eigen::Index first = 0; first < term.size(); first += block_entries) {
      const Eigen::Index width = std::min(block_entries, term.size() - first);
      conductance_terms_.segment(first * count + j * width, width) = term.segment(first, width);
    }
    const int environment = network.boundaries.conductances[static_cast<std::size_t>(j)].environment;
    if (environment < 0) continue;
    require(environment < environments_, "a conductance names an environment that does not exist");
    films_.col(static_cast<Eigen::Index>(film_environment_.size())) = factor * column_sums;
    film_conductance_.push_back(j);
    film_environment_.push_back(environment);
  }
  films_.conservativeResize(Eigen::NoChange, static_cast<Eigen::Index>(film_environment_.size()));
}

/// P of the coolant's segments, and their areas.
void NetworkOperator::set_walls(const Network& network) {
  walls_.resize(nodes(), segments_.count());
  for (Eigen::Index s = 0; s < segments_.count(); ++s) {
    const auto j = static_cast<std::size_t>(segments_.conductance[static_cast<std::size_t>(s)]);
    const Eigen::VectorXd column_sums = network.factors_m[j].colwise().sum().transpose();
    segments_.area_m2[s] = column_sums.squaredNorm();
    walls_.col(s) = network.factors_m[j] * column_sums;
  }
  // Eigen takes the address of a right-hand side that may be empty.
  if (walls_.cols() > 0) capacity_root_.triangularView<Eigen::Lower>().solveInPlace(walls_);
}

/// W; after walls and laws.
void NetworkOperator::set_feedback_columns() {
  feedback_columns_ = walls_;
  const auto append = [&](const Eigen::MatrixXd& columns) {
    feedback_columns_.conservativeResize(Eigen::NoChange, feedback_columns_.cols() + columns.cols());
    feedback_columns_.rightCols(columns.cols()) = columns;
  };
  for (const LawTerm& term : laws_.list()) {
    if (term.source >= 0) append(term.direction);
  }
  append(laws_.rows());
}

void NetworkOperator::to_internal(const Eigen::VectorXd& temperatures_K, Eigen::VectorXd& x) const {
  // xᵢ = Lᵀ's row i times the rise; a row of Lᵀ is a column of L.
  const Eigen::Index n = nodes();
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto below = capacity_root_.col(i).tail(n - i);
    x[i] = below.dot(temperatures_K.tail(n - i)) - below.sum() * reference_K_;
  }
}

void NetworkOperator::to_temperatures(const Eigen::VectorXd& x, Eigen::VectorXd& temperatures_K) const {
  temperatures_K = x;
  capacity_root_.transpose().triangularView<Eigen::Upper>().solveInPlace(temperatures_K);
  temperatures_K.array() += reference_K_;
}

/// packed += Σ weightⱼ K̃ⱼ.
template <typename Weights>
void NetworkOperator::add_terms(const Eigen::MatrixBase<Weights>& weights, Eigen::VectorXd& packed) const {
  for (Eigen::Index first = 0; first < packed.size(); first += block_entries) {
    const Eigen::Index width = std::min(block_entries, packed.size() - first);
    auto sum = packed.segment(first, width);
    for (Eigen::Index j = 0; j < conductances_; ++j) {
      const double weight = weights[j];
      if (weight != 0.0) sum += weight * conductance_terms_.segment(first * conductances_ + j * width, width);
    }
  }
}

void NetworkOperator::assemble(const Eigen::VectorXd& conductance_W_per_m2K, Eigen::VectorXd& packed,
                               Eigen::MatrixXd& lower) const {
  packed = packed_conduction_;
  add_terms(conductance_W_per_m2K, packed);
  unpack(packed, lower);
}

void NetworkOperator::assemble_from(const Eigen::VectorXd& base_W_per_m2K, const Eigen::VectorXd& base_packed,
                                    const Eigen::VectorXd& conductance_W_per_m2K, Eigen::VectorXd& packed,
                                    Eigen::MatrixXd& lower) const {
  packed = base_packed;
  add_terms(conductance_W_per_m2K - base_W_per_m2K, packed);
  unpack(packed, lower);
}

void NetworkOperator::unpack(const Eigen::VectorXd& packed, Eigen::MatrixXd& lower) {
  const Eigen::Index n = lower.rows();
  for (Eigen::Index column = 0, at = 0; column < n; at += n - column, ++column) {
    lower.col(column).tail(n - column) = packed.segment(at, n - column);
  }
}

void NetworkOperator::drive(const BoundaryValues& values, Eigen::VectorXd& u) const {
  drive_of_nodes(values, u);
  add_sources(values, u);
}

void NetworkOperator::drive_of_sources(const BoundaryValues& values, Eigen::VectorXd& u) const {
  u.setZero();
  add_sources(values, u);
}

void NetworkOperator::drive_of_nodes(const BoundaryValues& values, Eigen::VectorXd& u) const {
  if (values.node_heat_W.size() == 0) {
    u.setZero();
    return;
  }
  u = values.node_heat_W;
  capacity_root_.triangularView<Eigen::Lower>().solveInPlace(u);
}

/// u += what sources and films give.
void NetworkOperator::add_sources(const BoundaryValues& values, Eigen::VectorXd& u) const {
  u.noalias() += sources_ * values.heat_W;
  for (std::size_t film = 0; film < film_environment_.size(); ++film) {
    const double weight = values.conductance_W_per_m2K[film_conductance_[film]] *
                          (values.environment_K[film_environment_[film]] - reference_K_);
    u += weight * films_.col(static_cast<Eigen::Index>(film));
  }
}

void NetworkOperator::couple(const BoundaryValues& values, Eigen::MatrixXd& coupling, Eigen::VectorXd& rises_K,
                             Eigen::VectorXd& u) const {
  coolant_upstream(segments_, values, coupling);
  for (Eigen::Index s = 0; s < segments_.count(); ++s) {
    const auto segment = static_cast<std::size_t>(s);
    coupling.row(s) *= values.conductance_W_per_m2K[segments_.conductance[segment]];
    rises_K[s] = values.environment_K[segments_.inlet[segment]] - reference_K_;
  }
  for (Eigen::Index s = 0; s < segments_.count(); ++s) u -= coupling.row(s).dot(rises_K) * walls_.col(s);
  for (Eigen::Index s = 0; s < segments_.count(); ++s) coupling.col(s) /= segments_.area_m2[s];
}

}  // namespace spindle_twin::rom
