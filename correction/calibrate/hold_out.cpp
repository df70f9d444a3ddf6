#include "correction/calibrate/hold_out.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "correction/calibrate/residual_covariance.hpp"

namespace spindle_twin::correction {
namespace {

/// Readings of one test before and after the end of what was seen, and how the latter follow from the former.
class Foreseen {
 public:
  Foreseen(const FitTask& task, const TestFit& at, std::size_t test, double before_share)
      : task_(task), readings_(at.readings[test].readings), left_(at.left[test]), covariance_(at.covariance) {
    const double from_s = task.tests[test].time_s.front() + before_share * task.tests[test].length_s();
    for (Eigen::Index r = 0; r < left_.size(); ++r) {
      (readings_[static_cast<std::size_t>(r)].time_s < from_s ? seen_ : held_).push_back(r);
    }
    weight_ = residual_covariance(at.readings[test], task.predictor.parameters(), task.options);
    for (const Eigen::Index r : seen_) weight_(r, r) = at.weights[test](r, r);  // outliers say less
    root_.compute(weight_(seen_, seen_));
    const TestUnknowns unknowns(task.network, task.predictor.parameters(), task.options, task.tests.size());
    rows_ = unknowns.rows(at.readings[test], test);
  }

  HeldOutMean mean_of(int channel) const {
    Eigen::VectorXd share = Eigen::VectorXd::Zero(left_.size());
    double rise = 0.0, count = 0.0;
    for (const Eigen::Index r : held_) {
      const TestReading& reading = readings_[static_cast<std::size_t>(r)];
      if (reading.channel != channel) continue;
      share[r] = 1.0;
      rise += reading.rise;
      ++count;
    }
    share /= count;
    const Eigen::VectorXd together = (weight_ * share)(seen_);
    const Eigen::VectorXd carried = root_.solve(together);
    Eigen::VectorXd less = share;
    less(seen_) = -carried;
    const Eigen::VectorXd along = rows_.transpose() * less;
    double variance = share.dot(weight_ * share) - together.dot(carried) + along.dot(covariance_ * along);
    if (channel < static_cast<int>(task_.options.sensors.size())) {
      variance +=
          std::pow(task_.options.sensor_error_K, 2) + std::pow(task_.options.sensor_error_share * rise / count, 2);
    }
    return {less.dot(left_), std::sqrt(variance)};
  }

 private:
  const FitTask& task_;
  const std::vector<TestReading>& readings_;
  const Eigen::VectorXd& left_;
  const Eigen::MatrixXd& covariance_;
  std::vector<Eigen::Index> seen_, held_;
  Eigen::MatrixXd weight_, rows_;
  Eigen::LLT<Eigen::MatrixXd> root_;
};

}  // namespace

std::vector<ChannelFit> held_out_channels(const FitTask& task, const TestFit& seen, double before_share) {
  const TestFit at = judge_tests(task, seen.z, seen.covariance);
  std::vector<ChannelFit> channels = channels_from(task, at, before_share);
  for (std::size_t test = 0; test < task.tests.size(); ++test) {
    const Foreseen foreseen(task, at, test, before_share);
    for (ChannelFit& channel : channels) {
      if (channel.test == test) channel.held_out = foreseen.mean_of(channel.channel);
    }
  }
  return channels;
}

}  // namespace spindle_twin::correction
