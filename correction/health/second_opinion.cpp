#include "correction/health/second_opinion.hpp"

#include <algorithm>
#include <cmath>

#include "correction/health/surprise.hpp"
#include "correction/health/update_without.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double doubted = -4.0;   // evidence: odds of e^2 that the model was wrong,
constexpr double refuted = -12.0;  // and of e^6

}  // namespace

SecondOpinion::SecondOpinion(const EstimatorCorrection& estimator)
    : filter_(estimator.prior()),
      keep_(Eigen::VectorXd::Ones(estimator.prior().size())),
      growth_(Eigen::VectorXd::Zero(estimator.prior().size())),
      row_(growth_) {}

void SecondOpinion::begin(Eigen::Index sensor, const LeaveOneOut& bank) {
  sensor_ = sensor;
  filter_.set_mean(bank.without(sensor).mean());
  filter_.set_root(bank.without(sensor).root());
  begun_with_ = bank.misfit(sensor).evidence;
  misfit_ = {};
  widths_ = closed_;
  age_s_ = 0.0;
  is_new_ = true;
}

void SecondOpinion::update(const EstimatorCorrection& estimator) {
  const bool loosened = estimator.loosened() != loosened_;
  loosened_ = estimator.loosened();
  if (!loosened) closed_ = estimator.widths();
  if (sensor_ < 0) return;
  const EstimatorUpdate& made = estimator.last_update();
  if (loosened || is_new_) {
    // The start is now: what it has done until now is in the state.
    const ParameterModel& parameters = estimator.parameters();
    const Eigen::Index first = parameters.count() - parameters.starts();
    row_ = filter_.mean();
    row_.segment(first, parameters.starts()) = made.unknowns.segment(first, parameters.starts());
    filter_.set_mean(row_);
    is_new_ = false;
  }
  widths_.disturbance = std::min(widths_.disturbance, estimator.widths().disturbance);
  widths_.environment = std::min(widths_.environment, estimator.widths().environment);
  estimator.passing_of_time(made.elapsed_s, widths_, keep_, growth_);
  filter_.pass_time(estimator.prior().mean(), keep_, growth_);
  note_misfit(estimator, sensor_, filter_, row_, misfit_);
  const double gained = surprise_of(estimator) - update_without(estimator, sensor_, filter_, row_);
  misfit_.evidence = std::exp(-made.elapsed_s / evidence_memory_s) * misfit_.evidence + gained;
  age_s_ += made.elapsed_s;
}

Opinion SecondOpinion::conclude(bool again, const HealthLimits& limits) const {
  if (sensor_ < 0) return Opinion::pending;
  if (misfit_.evidence < refuted) return Opinion::against_model;
  if (age_s_ > limits.second_opinion_s) return Opinion::undecided;
  const bool failed = misfit_.evidence > (again ? 0.0 : limits.drift_lead);
  return failed && age_s_ > limits.opinion_least_s ? Opinion::against_sensor : Opinion::pending;
}

void SecondOpinion::widen_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double deviation_K) {
  keep_.setOnes();
  growth_.setZero();
  growth_[estimator.parameters().count() + sensor] = deviation_K * deviation_K;
  filter_.pass_time(estimator.prior().mean(), keep_, growth_);
}

void SecondOpinion::shift_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double shift_K) {
  filter_.shift(estimator.parameters().count() + sensor, -shift_K);
}

void SecondOpinion::put_alternative(const EstimatorCorrection& estimator, Eigen::MatrixXd& alternatives) const {
  if (sensor_ < 0) return;
  const double since = std::clamp((misfit_.evidence - refuted) / (doubted - refuted), 0.0, 1.0);
  const double weight = std::min(since, LeaveOneOut::weight_of(begun_with_ + misfit_.evidence));
  alternatives.rightCols<1>() =
      std::sqrt(weight) * (filter_.mean() - estimator.filter().mean()).head(alternatives.rows());
}

}  // namespace spindle_twin::correction
