#include "fem_offline/solve/coolant_coupling.hpp"

#include <utility>

namespace spindle_twin::fem_offline {

CoolantCoupling::CoolantCoupling(const AffineModel& model) : segments_(rom::coolant_segments(model.boundaries)) {
  const Eigen::Index n = model.capacity_J_per_K.rows(), count = segments_.count();
  std::vector<Eigen::Triplet<double>> entries;
  for (Eigen::Index s = 0; s < count; ++s) {
    const SparseMatrix& term =
        model.conductance_terms_m2[static_cast<std::size_t>(segments_.conductance[static_cast<std::size_t>(s)])];
    const Eigen::VectorXd wetted_m2 = term * Eigen::VectorXd::Ones(n);
    segments_.area_m2[s] = wetted_m2.sum();
    for (Eigen::Index i = 0; i < n; ++i) {
      if (wetted_m2[i] != 0.0) entries.emplace_back(static_cast<int>(i), static_cast<int>(s), wetted_m2[i]);
    }
  }
  wetted_m2_.resize(n, count);
  wetted_m2_.setFromTriplets(entries.begin(), entries.end());
  film_W_per_m2K_ = inlet_K_ = Eigen::VectorXd::Zero(count);
  upstream_ = Eigen::MatrixXd::Zero(count, count);
}

void CoolantCoupling::hold(const rom::BoundaryValues& values) {
  for (Eigen::Index s = 0; s < segments_.count(); ++s) {
    film_W_per_m2K_[s] = values.conductance_W_per_m2K[segments_.conductance[static_cast<std::size_t>(s)]];
    inlet_K_[s] = values.environment_K[segments_.inlet[static_cast<std::size_t>(s)]];
  }
  if (!empty()) rom::coolant_upstream(segments_, values, upstream_);
}

Eigen::MatrixXd CoolantCoupling::walls_K(const Eigen::Ref<const Eigen::MatrixXd>& temperatures_K) const {
  const Eigen::MatrixXd over_area_m2K = wetted_m2_.transpose() * temperatures_K;
  return over_area_m2K.array().colwise() / segments_.area_m2.array();
}

Eigen::VectorXd CoolantCoupling::entering_K(const Eigen::VectorXd& temperatures_K) const {
  return inlet_K_ + upstream_ * (walls_K(temperatures_K) - inlet_K_);
}

Eigen::MatrixXd CoolantCoupling::heat_per_inlet_W_per_K() const {
  return Eigen::MatrixXd(wetted_m2_) * film_W_per_m2K_.asDiagonal();
}

void CoolantCoupling::add_heat(const Eigen::Ref<const Eigen::MatrixXd>& temperatures_K,
                               Eigen::Ref<Eigen::MatrixXd> heat_W) const {
  if (!empty()) heat_W += wetted_m2_ * (film_W_per_m2K_.asDiagonal() * fed_K(temperatures_K));
}

void CoolantCoupling::add_load(double datum_K, Eigen::VectorXd& load_W) const {
  if (empty()) return;
  const Eigen::VectorXd above_K = inlet_K_.array() - datum_K;
  load_W -= wetted_m2_ * film_W_per_m2K_.cwiseProduct(upstream_ * above_K);
}

CoupledFactor::CoupledFactor(CholeskyFactor symmetric, const CoolantCoupling& coupling, double factor)
    : symmetric_(std::move(symmetric)), factor_(factor) {
  if (coupling.empty()) return;
  responses_ = symmetric_.solve(coupling.heat_per_inlet_W_per_K());
  const Eigen::Index count = responses_.cols();
  small_.compute(Eigen::MatrixXd::Identity(count, count) - factor_ * coupling.fed_K(responses_));
}

void CoupledFactor::solve(const Eigen::VectorXd& right_hand_side, const CoolantCoupling& coupling,
                          Eigen::VectorXd& solution) {
  symmetric_.solve(right_hand_side, solution);
  if (coupling.empty()) return;
  const Eigen::VectorXd fed_K = factor_ * coupling.fed_K(solution);
  solution += responses_ * small_.solve(fed_K);
}

Eigen::MatrixXd CoupledFactor::solve(const Eigen::MatrixXd& right_hand_sides, const CoolantCoupling& coupling) {
  Eigen::MatrixXd solutions = symmetric_.solve(right_hand_sides);
  if (!coupling.empty()) solutions += responses_ * small_.solve(factor_ * coupling.fed_K(solutions));
  return solutions;
}

}  // namespace spindle_twin::fem_offline
