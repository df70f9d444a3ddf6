#include "correction/health/leave_one_out.hpp"

#include <algorithm>
#include <cmath>

#include "correction/health/surprise.hpp"
#include "correction/health/update_without.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double least_memory_s = 120.0;  // twelve updates
constexpr double keep_every_s = 300.0;    // three kept filters: the oldest is 10 to 15 minutes old
constexpr double doubt_from = 4.0;        // evidence: odds of e^2 that the sensor has failed,
constexpr double doubt_whole = 12.0;      // and of e^6

}  // namespace

LeaveOneOut::LeaveOneOut(const EstimatorCorrection& estimator)
    : filters_(estimator.sensors().size(), estimator.prior()),
      before_(estimator.prior()),
      misfits_(estimator.sensors().size()),
      keep_(Eigen::VectorXd::Ones(estimator.prior().size())),
      growth_(Eigen::VectorXd::Zero(estimator.prior().size())),
      row_(growth_),
      alternatives_(
          Eigen::MatrixXd::Zero(estimator.parameters().count(), static_cast<Eigen::Index>(filters_.size()) + 1)) {
  for (Kept& kept : kept_) kept.filter = estimator.prior();
}

void LeaveOneOut::keep_all(const SquareRootFilter& filter) {
  for (Kept& kept : kept_) {
    kept.filter.set_mean(filter.mean());
    kept.filter.set_root(filter.root());
    kept.age_s = 0.0;
  }
}

void LeaveOneOut::begin_anew(const EstimatorCorrection& estimator) {
  for (SquareRootFilter& filter : filters_) {
    filter.set_mean(estimator.filter().mean());
    filter.set_root(estimator.filter().root());
  }
  std::fill(misfits_.begin(), misfits_.end(), Misfit{});
  age_s_ = 0.0;
}

void LeaveOneOut::follow(const EstimatorCorrection& estimator) {
  begin_anew(estimator);
  keep_all(estimator.filter());
}

void LeaveOneOut::follow_loosened(const EstimatorCorrection& estimator) {
  begin_anew(estimator);
  const ParameterModel& parameters = estimator.parameters();
  const Eigen::Index end = parameters.count(), first = end - parameters.starts();
  keep_.setOnes();
  for (Kept& kept : kept_) {
    // The start is now: what it has done until now is in the state, and as unknown as the estimator says.
    row_ = kept.filter.mean();
    growth_.setZero();
    for (Eigen::Index i = first; i < end; ++i) {
      const double now = estimator.filter().deviation(i), then = kept.filter.deviation(i);
      row_[i] = estimator.filter().mean()[i];
      growth_[i] = std::max(0.0, now * now - then * then);
    }
    kept.filter.set_mean(row_);
    kept.filter.pass_time(estimator.prior().mean(), keep_, growth_);
  }
}

void LeaveOneOut::shift_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double shift_K) {
  const Eigen::Index offset = estimator.parameters().count() + sensor;
  for (SquareRootFilter& filter : filters_) filter.shift(offset, -shift_K);
  for (Kept& kept : kept_) kept.filter.shift(offset, -shift_K);
}

void LeaveOneOut::update(const EstimatorCorrection& estimator) {
  estimator.passing_of_time(estimator.last_update().elapsed_s, keep_, growth_);
  for (Kept& kept : kept_) kept.age_s += estimator.last_update().elapsed_s;
  if (kept_.front().age_s >= keep_every_s) {
    std::rotate(kept_.begin(), kept_.end() - 1, kept_.end());
    kept_.front().filter.set_mean(estimator.filter().mean());
    kept_.front().filter.set_root(estimator.filter().root());
    kept_.front().age_s = 0.0;
  }
  const double all = surprise_of(estimator);
  age_s_ += estimator.last_update().elapsed_s;
  const double fade =
      std::exp(-estimator.last_update().elapsed_s / std::clamp(age_s_, least_memory_s, evidence_memory_s));
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(filters_.size()); ++s) {
    double& evidence = misfits_[static_cast<std::size_t>(s)].evidence;
    evidence = fade * evidence + all - update_one(estimator, s);
  }
}

double LeaveOneOut::update_one(const EstimatorCorrection& estimator, Eigen::Index sensor) {
  SquareRootFilter& filter = filters_[static_cast<std::size_t>(sensor)];
  filter.pass_time(estimator.prior().mean(), keep_, growth_);
  note_misfit(estimator, sensor, filter, row_, misfits_[static_cast<std::size_t>(sensor)]);
  return update_without(estimator, sensor, filter, row_);
}

void LeaveOneOut::widen_offset(const EstimatorCorrection& estimator, Eigen::Index sensor, double deviation_K) {
  keep_.setOnes();
  growth_.setZero();
  growth_[estimator.parameters().count() + sensor] = deviation_K * deviation_K;
  for (SquareRootFilter& filter : filters_) filter.pass_time(estimator.prior().mean(), keep_, growth_);
  for (Kept& kept : kept_) kept.filter.pass_time(estimator.prior().mean(), keep_, growth_);
}

const SquareRootFilter& LeaveOneOut::before(const EstimatorCorrection& estimator) {
  const Kept& oldest = kept_.back();
  before_.set_mean(oldest.filter.mean());
  before_.set_root(oldest.filter.root());
  estimator.passing_of_time(oldest.age_s, keep_, growth_);
  before_.pass_time(estimator.prior().mean(), keep_, growth_);
  return before_;
}

Eigen::Index LeaveOneOut::most_doubtful(double least) const {
  Eigen::Index most = -1;
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(misfits_.size()); ++s) {
    if (!misfit(s).judged || misfit(s).evidence < least) continue;
    if (most < 0 || misfit(s).evidence > misfit(most).evidence) most = s;
  }
  return most;
}

double LeaveOneOut::weight_of(double evidence) {
  return std::clamp((evidence - doubt_from) / (doubt_whole - doubt_from), 0.0, 1.0);
}

Eigen::MatrixXd& LeaveOneOut::alternatives(const EstimatorCorrection& estimator) {
  alternatives_.rightCols<1>().setZero();
  for (Eigen::Index s = 0; s + 1 < alternatives_.cols(); ++s) {
    const double weight = std::sqrt(weight_of(misfit(s).evidence));
    alternatives_.col(s) = weight * (without(s).mean() - estimator.filter().mean()).head(alternatives_.rows());
  }
  return alternatives_;
}

void LeaveOneOut::settle_on(Eigen::Index sensor) {
  const SquareRootFilter& chosen = without(sensor);
  for (std::size_t s = 0; s < filters_.size(); ++s) {
    if (static_cast<Eigen::Index>(s) == sensor) continue;
    filters_[s].set_mean(chosen.mean());
    filters_[s].set_root(chosen.root());
  }
  std::fill(misfits_.begin(), misfits_.end(), Misfit{});
  keep_all(chosen);
}

}  // namespace spindle_twin::correction
