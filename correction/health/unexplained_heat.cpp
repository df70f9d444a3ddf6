#include "correction/health/unexplained_heat.hpp"

#include <algorithm>
#include <cmath>

#include "correction/health/surprise.hpp"
#include "correction/health/update_without.hpp"

namespace spindle_twin::correction {
namespace {

/// Healthy spindles reach some 40 within two hours.
constexpr double enough = 60.0;

}  // namespace

UnexplainedHeat::UnexplainedHeat(const EstimatorCorrection& estimator)
    : filter_(estimator.prior()),
      keep_(Eigen::VectorXd::Ones(estimator.prior().size())),
      growth_(Eigen::VectorXd::Zero(estimator.prior().size())),
      row_(growth_) {}

void UnexplainedHeat::follow(const EstimatorCorrection& estimator) {
  filter_.set_mean(estimator.filter().mean());
  filter_.set_root(estimator.filter().root());
  evidence_ = 0.0;
  keep_.setOnes();
  growth_.setZero();
  const ParameterModel& parameters = estimator.parameters();
  for (Eigen::Index g = 0; parameters.has_disturbances() && g < parameters.group_count(); ++g) {
    const Eigen::Index slot = parameters.disturbance(g);
    const double wanted_W = estimator.open_heat_W(g), present_W = filter_.deviation(slot);
    growth_[slot] = std::max(0.0, wanted_W * wanted_W - present_W * present_W);
  }
  filter_.widen(keep_, growth_);
}

bool UnexplainedHeat::update(const EstimatorCorrection& estimator) {
  const ParameterModel& parameters = estimator.parameters();
  const EstimatorUpdate& made = estimator.last_update();
  estimator.passing_of_time(made.elapsed_s, keep_, growth_);
  for (Eigen::Index g = 0; g < parameters.group_count(); ++g) {
    const Eigen::Index slot = parameters.disturbance(g);
    growth_[slot] = std::pow(estimator.open_heat_W(g), 2.0) * (1.0 - keep_[slot] * keep_[slot]);
  }
  filter_.pass_time(estimator.prior().mean(), keep_, growth_);
  constexpr Eigen::Index with_all = -1;
  double gained = surprise_of(estimator) - update_without(estimator, with_all, filter_, row_);
  if (!std::isfinite(gained)) gained = 0.0;
  evidence_ = std::exp(-made.elapsed_s / evidence_memory_s) * evidence_ + gained;
  return evidence_ > enough;
}

}  // namespace spindle_twin::correction
