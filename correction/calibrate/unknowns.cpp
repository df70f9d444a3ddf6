#include "correction/calibrate/unknowns.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace spindle_twin::correction {
namespace {

constexpr double zero_deviation_m = 1e-3;  // of a probe: unknown

std::vector<double> spreads_of(const std::vector<ThermalTest>& tests, const CalibrateOptions& options) {
  std::vector<double> spreads_K;
  spreads_K.reserve(tests.size());
  for (const ThermalTest& test : tests) spreads_K.push_back(start_spread_K(test, options));
  return spreads_K;
}

}  // namespace

double start_deviation_K(const ParameterModel& parameters, Eigen::Index i, double spread_K) {
  const double of_shape = parameters.is_start_of_group(i) ? open_groups_share : open_rises_share;
  const double share = i == parameters.start() ? 1.0 : of_shape;
  return std::max(parameters.list()[static_cast<std::size_t>(i)].deviation, share * spread_K);
}

double start_spread_K(const ThermalTest& test, const CalibrateOptions& options) {
  double spread_K = 0.0, expected_K = 0.0;
  for (std::size_t s = 0; s < options.sensors.size(); ++s) {
    const auto column = static_cast<Eigen::Index>(s);
    for (std::size_t r = 0; r < test.time_s.size() && test.time_s[r] <= test.time_s[0] + options.held_s; ++r) {
      const double measured_K = test.measured_K(static_cast<Eigen::Index>(r), column);
      if (!std::isfinite(measured_K)) continue;
      spread_K = std::max(spread_K, std::abs(measured_K - test.start_K));
      expected_K = std::max(expected_K, std::hypot(options.sensors[s].noise_K, options.sensors[s].offset_deviation_K));
      break;
    }
  }
  if (spread_K <= start_isothermal * expected_K) spread_K = 0.0;
  const Eigen::VectorXd& around_K = test.operating[0].environment_K;
  if (around_K.size() == 0) return spread_K;
  return std::max({spread_K, test.start_K - around_K.maxCoeff(), around_K.minCoeff() - test.start_K});
}

TestUnknowns::TestUnknowns(const rom::Network& network, const ParameterModel& parameters,
                           const CalibrateOptions& options, const std::vector<ThermalTest>& tests)
    : TestUnknowns(network, parameters, options, spreads_of(tests, options)) {}

TestUnknowns::TestUnknowns(const rom::Network& network, const ParameterModel& parameters,
                           const CalibrateOptions& options, std::size_t tests)
    : TestUnknowns(network, parameters, options, std::vector<double>(tests, 0.0)) {}

TestUnknowns::TestUnknowns(const rom::Network& network, const ParameterModel& parameters,
                           const CalibrateOptions& options, const std::vector<double>& spreads_K)
    : list_(parameters.list()),
      sensors_(static_cast<Eigen::Index>(options.sensors.size())),
      channels_(sensors_ + static_cast<Eigen::Index>(network.deformations.size())) {
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    (is_of_the_machine(list_[static_cast<std::size_t>(i)].kind) ? machine_ : of_test_).push_back(i);
  }
  const auto shared = static_cast<Eigen::Index>(machine_.size()) + sensors_;
  const Eigen::Index each = static_cast<Eigen::Index>(of_test_.size()) + channels_;
  mean_ = Eigen::VectorXd::Zero(shared + static_cast<Eigen::Index>(spreads_K.size()) * each);
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
  for (std::size_t test = 0; test < spreads_K.size(); ++test) {
    const Eigen::Index first = shared + static_cast<Eigen::Index>(test) * each;
    for (std::size_t i = 0; i < of_test_.size(); ++i) {
      const Eigen::Index at = first + static_cast<Eigen::Index>(i);
      mean_[at] = parameters.mean()[of_test_[i]];
      covariance(at, at) = parameters.is_start(of_test_[i])
                               ? std::pow(start_deviation_K(parameters, of_test_[i], spreads_K[test]), 2)
                               : prior(of_test_[i], of_test_[i]);
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
