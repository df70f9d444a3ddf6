#include "correction/plan_test/test_worth.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "correction/calibrate/residual_covariance.hpp"
#include "correction/calibrate/unknowns.hpp"
#include "rom/boundary_values/environments.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double not_read = std::numeric_limits<double>::quiet_NaN();
constexpr double drive_slack_s = 1e-6;

/// A drive as a test from rest whose readings all stand at the start temperature.
ThermalTest drive_as_test(const rom::Network& network, const CalibrateOptions& options, std::size_t probe,
                          const rom::Schedule& drive) {
  ThermalTest test;
  test.name = "the drive cycle";
  test.start_K = rom::rest_temperature_K(network.boundaries, drive.rows.front().state);
  std::vector<double> instants{0.0};
  std::size_t next = 1;
  while (instants.back() < drive.end_s - drive_slack_s) {
    double then_s = std::min(instants.back() + options.held_s, drive.end_s);
    while (next < drive.rows.size() && drive.rows[next].time_s <= instants.back() + drive_slack_s) ++next;
    if (next < drive.rows.size()) then_s = std::min(then_s, drive.rows[next].time_s);
    instants.push_back(then_s);
  }
  rom::OperatingState state = drive.rows.front().state;
  for (std::size_t i = 0; i < instants.size(); ++i) {
    const double end_s = i + 1 < instants.size() ? instants[i + 1] : instants[i];
    rom::state_at(drive, 0.5 * (instants[i] + end_s), state);
    test.operating.push_back(state);
  }
  const auto count = static_cast<Eigen::Index>(instants.size());
  test.measured_K = Eigen::MatrixXd::Constant(count, static_cast<Eigen::Index>(options.sensors.size()), test.start_K);
  test.deformation_m =
      Eigen::MatrixXd::Constant(count, static_cast<Eigen::Index>(network.deformations.size()), not_read);
  test.deformation_m.col(static_cast<Eigen::Index>(probe)).setZero();
  test.time_s = std::move(instants);
  return test;
}

TestPrediction linearised(const rom::Network& network, const TestPredictor& predictor, const CalibrateOptions& options,
                          std::size_t probe, const rom::Schedule& drive) {
  const TestUnknowns unknowns(network, predictor.parameters(), options, 1);
  TestPrediction prediction = predictor.predict(drive_as_test(network, options, probe, drive),
                                                unknowns.theta(unknowns.mean(), 0), unknowns.lag_s(unknowns.mean()));
  // Readings stood at the start temperature, so what the model says is what is left of them.
  for (TestReading& reading : prediction.readings) {
    if (reading.channel < static_cast<int>(options.sensors.size())) reading.rise = -reading.residual;
  }
  return prediction;
}

/// The readings that are taken, their channels numbered anew among the sensors that are.
TestPrediction taken_of(const TestPrediction& all, std::size_t sensors, const TakenReadings& taken) {
  const auto channel_of = [&](const TestReading& reading) {
    const auto channel = static_cast<std::size_t>(reading.channel);
    if (channel >= sensors) return taken.probe ? static_cast<int>(channel - sensors + taken.sensors.size()) : -1;
    const auto found = std::find(taken.sensors.begin(), taken.sensors.end(), channel);
    return found == taken.sensors.end() ? -1 : static_cast<int>(found - taken.sensors.begin());
  };
  TestPrediction result;
  std::vector<Eigen::Index> rows;
  for (std::size_t r = 0; r < all.readings.size(); ++r) {
    const int channel = channel_of(all.readings[r]);
    if (channel < 0 || all.readings[r].time_s > taken.until_s + drive_slack_s) continue;
    result.readings.push_back(all.readings[r]);
    result.readings.back().channel = channel;
    rows.push_back(static_cast<Eigen::Index>(r));
  }
  result.sensitivities = all.sensitivities(rows, Eigen::all);
  return result;
}

double rms(const std::vector<double>& variances) {
  double sum = 0.0;
  for (const double variance : variances) sum += variance;
  return std::sqrt(sum / static_cast<double>(variances.size()));
}

CalibrateOptions first_sensors(CalibrateOptions options, std::size_t count) {
  options.sensors.resize(count);
  return options;
}

std::size_t checked_probe(const rom::Network& network, std::size_t probe) {
  if (probe >= network.deformations.size()) {
    throw rom::InputError({}, "deformations", "the network has none that a probe could measure");
  }
  return probe;
}

}  // namespace

TestWorth::TestWorth(const rom::Network& network, WorthOptions options, const rom::Schedule& service)
    : network_(&network), options_(std::move(options)), predictor_(network, options_.calibrate) {
  checked_probe(network, options_.probe);
  const CalibrateOptions in_service = first_sensors(options_.calibrate, options_.permanent);
  const TestPredictor predictor(network, in_service);
  const TestUnknowns unknowns(network, predictor.parameters(), in_service, 1);
  const TestPrediction prediction = linearised(network, predictor, in_service, options_.probe, service);
  TakenReadings sensors;
  for (std::size_t s = 0; s < options_.permanent; ++s) sensors.sensors.push_back(s);
  sensors.probe = false;
  const TestPrediction readings = taken_of(prediction, options_.permanent, sensors);
  service_.prior = unknowns.root() * unknowns.root().transpose();
  const Eigen::MatrixXd rows = unknowns.rows(readings, 0);
  if (rows.rows() == 0) {
    service_.whitened = rows;
  } else {
    const Eigen::LLT<Eigen::MatrixXd> weight(residual_covariance(readings, predictor.parameters(), in_service));
    service_.whitened = weight.matrixL().solve(rows);
  }
  std::vector<Eigen::VectorXd> outputs;
  for (std::size_t r = 0; r < prediction.readings.size(); ++r) {
    const TestReading& reading = prediction.readings[r];
    if (reading.channel < static_cast<int>(options_.permanent) || reading.time_s < options_.judged_from_s) continue;
    outputs.push_back(unknowns.row(prediction.sensitivities.row(static_cast<Eigen::Index>(r)).transpose(), 0));
    service_.readings.push_back(std::count_if(readings.readings.begin(), readings.readings.end(),
                                              [&](const TestReading& one) { return one.time_s <= reading.time_s; }));
  }
  if (outputs.empty()) throw rom::InputError({}, "service", "is not longer than what is left out at its start");
  service_.outputs.resize(static_cast<Eigen::Index>(outputs.size()), unknowns.count());
  for (std::size_t k = 0; k < outputs.size(); ++k) {
    service_.outputs.row(static_cast<Eigen::Index>(k)) = outputs[k].transpose();
  }
  for (const Eigen::Index slot : unknowns.machine()) {
    service_.names.push_back(predictor.parameters().list()[static_cast<std::size_t>(slot)].name);
  }
}

TestPrediction TestWorth::linearise(const rom::Schedule& test) const {
  return linearised(*network_, predictor_, options_.calibrate, options_.probe, test);
}

Worth TestWorth::of(const TestPrediction& test, const TakenReadings& taken) const {
  CalibrateOptions options = options_.calibrate;
  options.sensors.clear();
  for (const std::size_t sensor : taken.sensors) options.sensors.push_back(options_.calibrate.sensors.at(sensor));
  const TestPrediction readings = taken_of(test, options_.calibrate.sensors.size(), taken);
  const TestUnknowns unknowns(*network_, predictor_.parameters(), options, 1);
  const auto machine = static_cast<Eigen::Index>(service_.names.size());
  if (readings.readings.empty()) return untested();
  const Eigen::LLT<Eigen::MatrixXd> weight(residual_covariance(readings, predictor_.parameters(), options));
  const Eigen::MatrixXd whitened = weight.matrixL().solve(unknowns.rows(readings, 0) * unknowns.root());
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(unknowns.count(), unknowns.count());
  information.selfadjointView<Eigen::Lower>().rankUpdate(whitened.transpose());
  const Eigen::MatrixXd half =
      Eigen::LLT<Eigen::MatrixXd>(information).matrixL().solve(unknowns.root().topRows(machine).transpose());
  Eigen::MatrixXd posterior = half.transpose() * half;
  for (Eigen::Index i = 0; i < machine; ++i) {
    const double drift = drift_of(service_.names[static_cast<std::size_t>(i)], options_.drift);
    posterior(i, i) += drift * drift;
  }
  return in_service(posterior);
}

Worth TestWorth::untested() const {
  const auto machine = static_cast<Eigen::Index>(service_.names.size());
  return in_service(service_.prior.topLeftCorner(machine, machine));
}

Worth TestWorth::known() const {
  constexpr double all_but = 1e-12;  // of a prior's variance, so that a root exists
  const auto machine = static_cast<Eigen::Index>(service_.names.size());
  Eigen::MatrixXd drifted = all_but * service_.prior.topLeftCorner(machine, machine);
  for (Eigen::Index i = 0; i < machine; ++i) {
    const double drift = drift_of(service_.names[static_cast<std::size_t>(i)], options_.drift);
    drifted(i, i) += drift * drift;
  }
  return in_service(drifted);
}

Worth TestWorth::in_service(const Eigen::MatrixXd& machine) const {
  Eigen::MatrixXd prior = service_.prior;
  prior.topLeftCorner(machine.rows(), machine.cols()) = machine;
  const Eigen::MatrixXd root = Eigen::LLT<Eigen::MatrixXd>(prior).matrixL();
  const Eigen::MatrixXd rows = service_.whitened * root;
  const Eigen::MatrixXd outputs = service_.outputs * root;
  Eigen::MatrixXd information = Eigen::MatrixXd::Identity(root.cols(), root.cols());
  std::vector<double> with_sensors, open_loop;
  Eigen::Index seen = 0;
  for (Eigen::Index k = 0; k < outputs.rows(); ++k) {
    const Eigen::Index until = service_.readings[static_cast<std::size_t>(k)];
    information.selfadjointView<Eigen::Lower>().rankUpdate(rows.middleRows(seen, until - seen).transpose());
    seen = until;
    const Eigen::VectorXd output = outputs.row(k).transpose();
    open_loop.push_back(output.squaredNorm());
    with_sensors.push_back(Eigen::LLT<Eigen::MatrixXd>(information).matrixL().solve(output).squaredNorm());
  }
  return {rms(with_sensors), rms(open_loop)};
}

}  // namespace spindle_twin::correction
