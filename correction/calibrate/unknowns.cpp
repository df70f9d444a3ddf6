#include "correction/calibrate/unknowns.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace spindle_twin::correction {
namespace {

constexpr double zero_deviation_m = 1e-3;  // of a probe: unknown

}  // namespace

TestUnknowns::TestUnknowns(const rom::Network& network, const ParameterModel& parameters,
                           const CalibrateOptions& options, std::size_t tests)
    : list_(parameters.list()),
      sensors_(static_cast<Eigen::Index>(options.sensors.size())),
      channels_(sensors_ + static_cast<Eigen::Index>(network.deformations.size())) {
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    (is_of_the_machine(list_[static_cast<std::size_t>(i)].kind) ? machine_ : of_test_).push_back(i);
  }
  const auto shared = static_cast<Eigen::Index>(machine_.size()) + sensors_;
  const Eigen::Index each = static_cast<Eigen::Index>(of_test_.size()) + channels_;
  mean_ = Eigen::VectorXd::Zero(shared + static_cast<Eigen::Index>(tests) * each);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count(), count());
  const Eigen::MatrixXd prior = parameters.covariance();
  for (std::size_t a = 0; a < machine_.size(); ++a) {
    mean_[static_cast<Eigen::Index>(a)] = parameters.mean()[machine_[a]];
    for (std::size_t b = 0; b < machine_.size(); ++b) {
      covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = prior(machine_[a], machine_[b]);
    }
  }
  for (Eigen::Index s = 0; s < sensors_; ++s) {
    const Eigen::Index at = static_cast<Eigen::Index>(machine_.size()) + s;
    mean_[at] = options.sensors[static_cast<std::size_t>(s)].lag_s;
    covariance(at, at) = options.lag_deviation_s * options.lag_deviation_s;
  }
  for (std::size_t test = 0; test < tests; ++test) {
    const Eigen::Index first = shared + static_cast<Eigen::Index>(test) * each;
    for (std::size_t i = 0; i < of_test_.size(); ++i) {
      const Eigen::Index at = first + static_cast<Eigen::Index>(i);
      mean_[at] = parameters.mean()[of_test_[i]];
      covariance(at, at) = prior(of_test_[i], of_test_[i]);
    }
    for (Eigen::Index c = 0; c < channels_; ++c) {
      const Eigen::Index at = offset_at(test, static_cast<int>(c));
      const double deviation =
          c < sensors_ ? options.sensors[static_cast<std::size_t>(c)].offset_deviation_K : zero_deviation_m;
      covariance(at, at) = deviation * deviation;
    }
  }
  root_ = Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL();
}

Eigen::Index TestUnknowns::offset_at(std::size_t test, int channel) const {
  const auto of_test = static_cast<Eigen::Index>(of_test_.size());
  return static_cast<Eigen::Index>(machine_.size()) + sensors_ +
         static_cast<Eigen::Index>(test) * (of_test + channels_) + of_test + channel;
}

Eigen::VectorXd TestUnknowns::theta(const Eigen::VectorXd& z, std::size_t test) const {
  Eigen::VectorXd theta(static_cast<Eigen::Index>(list_.size()));
  for (std::size_t i = 0; i < machine_.size(); ++i) theta[machine_[i]] = z[static_cast<Eigen::Index>(i)];
  const Eigen::Index first = offset_at(test, 0) - static_cast<Eigen::Index>(of_test_.size());
  for (std::size_t i = 0; i < of_test_.size(); ++i) theta[of_test_[i]] = z[first + static_cast<Eigen::Index>(i)];
  for (std::size_t i = 0; i < list_.size(); ++i) {
    double& value = theta[static_cast<Eigen::Index>(i)];
    value = std::clamp(value, list_[i].minimum, list_[i].maximum);
  }
  return theta;
}

Eigen::VectorXd TestUnknowns::lag_s(const Eigen::VectorXd& z) const {
  return z.segment(static_cast<Eigen::Index>(machine_.size()), sensors_).cwiseMax(0.0);
}

Eigen::VectorXd TestUnknowns::row(const Eigen::VectorXd& theta_row, std::size_t test) const {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(count());
  for (std::size_t i = 0; i < machine_.size(); ++i) row[static_cast<Eigen::Index>(i)] = theta_row[machine_[i]];
  const Eigen::Index first = offset_at(test, 0) - static_cast<Eigen::Index>(of_test_.size());
  for (std::size_t i = 0; i < of_test_.size(); ++i) row[first + static_cast<Eigen::Index>(i)] = theta_row[of_test_[i]];
  return row;
}

Eigen::MatrixXd TestUnknowns::rows(const TestPrediction& prediction, std::size_t test) const {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(prediction.readings.size()), count());
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    const TestReading& reading = prediction.readings[static_cast<std::size_t>(r)];
    rows.row(r) = row(prediction.sensitivities.row(r).transpose(), test).transpose();
    rows(r, offset_at(test, reading.channel)) = 1.0;
    if (reading.channel < sensors_) {
      rows(r, static_cast<Eigen::Index>(machine_.size()) + reading.channel) = reading.lag_slope;
    }
  }
  return rows;
}

}  // namespace spindle_twin::correction
