#include "fem_offline/solve/thermal_system.hpp"

#include <algorithm>

namespace spindle_twin::fem_offline {

ThermalSystem::ThermalSystem(const AffineModel& model) : model_(&model) {
  const auto n = model.capacity_J_per_K.rows();
  std::vector<Eigen::Triplet<double>> pattern;
  const auto add_pattern = [&](const SparseMatrix& matrix) {
    for (int column = 0; column < matrix.outerSize(); ++column) {
      for (SparseMatrix::InnerIterator it(matrix, column); it; ++it) {
        if (it.row() >= column) pattern.emplace_back(static_cast<int>(it.row()), column, 0.0);
      }
    }
  };
  add_pattern(model.capacity_J_per_K);
  add_pattern(model.conduction_W_per_K);
  for (const SparseMatrix& term : model.conductance_terms_m2) add_pattern(term);
  conduction_.resize(n, n);
  conduction_.setFromTriplets(pattern.begin(), pattern.end());
  capacity_ = conduction_;
  add(scatter_of(model.capacity_J_per_K), 1.0, capacity_);
  constant_ = scatter_of(model.conduction_W_per_K);
  std::vector<Eigen::Triplet<double>> wetted_m2;
  for (std::size_t j = 0; j < model.conductance_terms_m2.size(); ++j) {
    const SparseMatrix& term = model.conductance_terms_m2[j];
    terms_.push_back(scatter_of(term));
    if (model.boundaries.conductances[j].environment < 0) continue;
    const Eigen::VectorXd own_m2 = term * Eigen::VectorXd::Ones(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      if (own_m2[i] != 0.0) wetted_m2.emplace_back(static_cast<int>(i), static_cast<int>(j), own_m2[i]);
    }
  }
  wetted_m2_.resize(n, static_cast<Eigen::Index>(terms_.size()));
  wetted_m2_.setFromTriplets(wetted_m2.begin(), wetted_m2.end());
}

ThermalSystem::Scatter ThermalSystem::scatter_of(const SparseMatrix& matrix) const {
  Scatter scatter;
  for (int column = 0; column < matrix.outerSize(); ++column) {
    const int* begin = conduction_.innerIndexPtr() + conduction_.outerIndexPtr()[column];
    const int* end = conduction_.innerIndexPtr() + conduction_.outerIndexPtr()[column + 1];
    for (SparseMatrix::InnerIterator it(matrix, column); it; ++it) {
      if (it.row() < column) continue;
      scatter.positions.push_back(std::lower_bound(begin, end, it.row()) - conduction_.innerIndexPtr());
      scatter.values.push_back(it.value());
    }
  }
  return scatter;
}

void ThermalSystem::add(const Scatter& scatter, double factor, SparseMatrix& to) const {
  double* values = to.valuePtr();
  for (std::size_t i = 0; i < scatter.positions.size(); ++i) {
    values[scatter.positions[i]] += factor * scatter.values[i];
  }
}

void ThermalSystem::set_conductances(const Eigen::VectorXd& conductance_W_per_m2K) {
  conduction_.coeffs().setZero();
  add(constant_, 1.0, conduction_);
  for (std::size_t j = 0; j < terms_.size(); ++j) {
    add(terms_[j], conductance_W_per_m2K[static_cast<Eigen::Index>(j)], conduction_);
  }
}

SparseMatrix ThermalSystem::combined_lower(double factor) const {
  SparseMatrix combined = capacity_;
  combined.coeffs() += factor * conduction_.coeffs();
  return combined;
}

Eigen::VectorXd ThermalSystem::load_W(const rom::BoundaryValues& values, double datum_K) const {
  Eigen::VectorXd flux_W_per_m2 = Eigen::VectorXd::Zero(wetted_m2_.cols());
  for (Eigen::Index j = 0; j < flux_W_per_m2.size(); ++j) {
    const int environment = model_->boundaries.conductances[static_cast<std::size_t>(j)].environment;
    if (environment < 0) continue;
    flux_W_per_m2[j] = values.conductance_W_per_m2K[j] * (values.environment_K[environment] - datum_K);
  }
  return model_->source_distribution * values.heat_W + wetted_m2_ * flux_W_per_m2;
}

}  // namespace spindle_twin::fem_offline
