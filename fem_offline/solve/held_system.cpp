#include "fem_offline/solve/held_system.hpp"

#include "fem_offline/sparse/symmetric_product.hpp"

namespace spindle_twin::fem_offline {
namespace {

CholeskyFactor factorise(const CholeskyAnalysis* analysed, const SparseMatrix& lower) {
  return analysed != nullptr ? CholeskyFactor(*analysed, lower) : CholeskyFactor(lower);
}

}  // namespace

HeldSystem::HeldSystem(const AffineModel& model)
    : matrices_(model),
      circuits_(model),
      conductance_W_per_m2K_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.conductance_terms_m2.size()))) {
  matrices_.set_conductances(conductance_W_per_m2K_);
}

void HeldSystem::hold(const rom::BoundaryValues& values, double datum_K) {
  hold_conductances(values.conductance_W_per_m2K);
  circuits_.hold(values);
  load_W_ = matrices_.load_W(values, datum_K);
  circuits_.add_load(datum_K, load_W_);
}

void HeldSystem::hold_conductances(const Eigen::VectorXd& conductance_W_per_m2K) {
  if (conductance_W_per_m2K_ == conductance_W_per_m2K) return;
  conductance_W_per_m2K_ = conductance_W_per_m2K;
  matrices_.set_conductances(conductance_W_per_m2K);
}

void HeldSystem::net_heat_W(const Eigen::VectorXd& temperatures_K, Eigen::VectorXd& heat_W) const {
  heat_W = load_W_;
  heat_W.noalias() -= matrices_.conduction_lower().selfadjointView<Eigen::Lower>() * temperatures_K;
  circuits_.add_heat(temperatures_K, heat_W);
}

Eigen::MatrixXd HeldSystem::conducted_W(const Eigen::MatrixXd& temperatures_K) const {
  Eigen::MatrixXd heat_W = symmetric_product(matrices_.conduction_lower(), temperatures_K);
  if (circuits_.empty()) return heat_W;
  Eigen::MatrixXd carried_W = Eigen::MatrixXd::Zero(heat_W.rows(), heat_W.cols());
  circuits_.add_heat(temperatures_K, carried_W);
  return heat_W - carried_W;
}

Eigen::MatrixXd HeldSystem::stored_J(const Eigen::MatrixXd& temperatures_K) const {
  return symmetric_product(matrices_.capacity_lower(), temperatures_K);
}

CoupledFactor HeldSystem::factor(const CholeskyAnalysis* analysed) const {
  return {factorise(analysed, matrices_.conduction_lower()), circuits_, 1.0};
}

CoupledFactor HeldSystem::factor(double step_s, const CholeskyAnalysis* analysed) const {
  return {factorise(analysed, matrices_.combined_lower(step_s)), circuits_, step_s};
}

}  // namespace spindle_twin::fem_offline
