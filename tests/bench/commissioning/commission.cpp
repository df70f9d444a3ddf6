#include "tests/bench/commissioning/commission.hpp"

#include <chrono>
#include <cmath>
#include <limits>
#include <random>

#include "correction/calibration/calibration.hpp"
#include "rom/units.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double probe_noise_m = 1e-6;
constexpr double probe_drift_m = 0.5e-6;
constexpr double probe_memory_s = 3600.0;
constexpr double probe_zero_m = 20e-6;
constexpr double sensor_lag_s = 5.0;
constexpr double speed_exponent = 0.1;
constexpr std::uint64_t probe_stream = 7'000'000;

std::vector<DriveBlock> base_drive(double test_s) {
  return {{test_s / 3.0, 6000.0, 0.5}, {2.0 * test_s / 3.0, 12000.0, 0.5}, {2.0 * test_s, 3000.0, 0.5}};
}

}  // namespace

Conditions conditions_of_test(const TestPlan& plan) {
  Conditions of_test;
  of_test.run_s = plan.test_s;
  of_test.lag_s = sensor_lag_s;
  of_test.speed_exponent = speed_exponent;
  of_test.expansion = plan.expansion;
  of_test.drive = base_drive(plan.test_s);
  return of_test;
}

Conditions conditions_of_day(const TestPlan& plan, const Eigen::VectorXd& theta) {
  Conditions of_day;
  of_day.run_s = plan.service_s;
  of_day.lag_s = sensor_lag_s;
  of_day.theta = theta;
  return of_day;
}

correction::ThermalTest log_of(const rom::Network& network, const Truth& truth, int sensors, const TestPlan& plan) {
  std::mt19937_64 random(truth.seed + probe_stream);
  std::normal_distribution<double> normal(0.0, 1.0);
  correction::ThermalTest test;
  test.name = "test";
  const Eigen::Index samples = truth.nose_m.size();
  test.measured_K = truth.measured_K.leftCols(sensors);
  test.deformation_m = Eigen::MatrixXd::Constant(samples, static_cast<Eigen::Index>(network.deformations.size()),
                                                 std::numeric_limits<double>::quiet_NaN());
  const double zero_m = probe_zero_m * normal(random);
  double drifted_m = probe_drift_m * normal(random);
  const double keep = std::exp(-truth.conditions.sample_s / probe_memory_s);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double time_s = static_cast<double>(k) * truth.conditions.sample_s;
    test.time_s.push_back(time_s);
    test.operating.push_back(truth.read[static_cast<std::size_t>(k)]);
    const double noise_m = probe_noise_m * normal(random);
    if (!plan.touch_offs || std::fmod(time_s, touch_off_s) == 0.0) {
      test.deformation_m(k, 0) = truth.nose_m[k] + zero_m + drifted_m + noise_m;
    }
    drifted_m = keep * drifted_m + probe_drift_m * std::sqrt(1.0 - keep * keep) * normal(random);
  }
  test.start_K = network.boundaries.reference_temperature_K;
  return test;
}

correction::CalibrateOptions calibrate_options(const rom::Network& network, int sensors, HeatErrors heats) {
  correction::CalibrateOptions options;
  options.priors = correction::test_priors(priors_of(heats));
  options.sensors = correction::key_point_sensors(network, {});
  options.sensors.resize(static_cast<std::size_t>(sensors));
  return options;
}

double probe_rms_um(const std::vector<correction::ChannelFit>& channels, std::size_t sensors) {
  for (const correction::ChannelFit& channel : channels) {
    if (channel.channel == static_cast<int>(sensors)) return rom::um_per_m * channel.rms;
  }
  return 0.0;
}

Eigen::VectorXd drifted(const correction::ParameterModel& parameters, const Eigen::VectorXd& theta, const Drifted& by,
                        std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  Eigen::VectorXd other = theta;
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const correction::ParameterKind kind = parameters.list()[static_cast<std::size_t>(i)].kind;
    const double step = normal(random);
    if (kind == correction::ParameterKind::heat) other[i] += by.heat * step;
    if (kind == correction::ParameterKind::contact) other[i] += by.contact * step;
    if (kind == correction::ParameterKind::film) other[i] += by.film * step;
  }
  return other;
}

namespace {

correction::Calibration calibrated(const rom::Network& network, const correction::ThermalTest& test,
                                   const correction::CalibrateOptions& options, std::size_t set, Commissioned& result) {
  const auto began = std::chrono::steady_clock::now();
  const correction::CalibrationResult found = correction::calibrate(network, options, {test}, {});
  result.fit_s[set] = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  result.evaluations[set] = found.fit.evaluations;
  result.starts[set] = found.starts;
  result.chi_square[set] = found.fit.chi_square_per_reading;
  result.refused[set] = !found.misfits.empty();
  result.probe_um[set] = probe_rms_um(found.fit.channels, options.sensors.size());
  result.hold_out_um[set] = probe_rms_um(found.held_out.channels, options.sensors.size());
  return found.calibration;
}

/// What was found of each parameter less what it is, in its deviations; contacts as they are in the middle of the test.
std::vector<double> off_by(const correction::ParameterModel& parameters, const Truth& tested,
                           const correction::Calibration& found) {
  std::vector<double> off;
  for (std::size_t i = 0; i < found.names.size(); ++i) {
    for (Eigen::Index k = 0; k < parameters.count(); ++k) {
      const correction::Parameter& parameter = parameters.list()[static_cast<std::size_t>(k)];
      if (parameter.name != found.names[i]) continue;
      const bool is_contact = parameter.kind == correction::ParameterKind::contact;
      const double middle_s = 0.5 * tested.conditions.run_s;
      const double truth = tested.theta[k] + (is_contact ? drift(tested.conditions, middle_s) : 0.0);
      const auto slot = static_cast<Eigen::Index>(i);
      off.push_back((found.mean[slot] - truth) / found.root.row(slot).norm());
    }
  }
  return off;
}

}  // namespace

Commissioned commission(const rom::Network& network, const fem_offline::AffineModel& truth_model, std::uint64_t seed,
                        HeatErrors heats, const TestPlan& plan) {
  Commissioned result;
  result.seed = seed;
  result.heats = heats;
  const correction::ParameterModel parameters(network, priors_of(heats));
  const Truth tested = make_truth(truth_model, parameters, seed, heats, conditions_of_test(plan));
  for (std::size_t set = 0; set < permanent_sensors.size(); ++set) {
    const int sensors = permanent_sensors[set];
    result.calibrations[set] = calibrated(network, log_of(network, tested, sensors, plan),
                                          calibrate_options(network, sensors, heats), set, result);
    result.off[set] = off_by(parameters, tested, result.calibrations[set]);
  }
  for (std::size_t d = 0; d < drifts.size(); ++d) {
    const Eigen::VectorXd theta = drifted(parameters, tested.theta, drifts[d], seed + day_stream + d);
    const Truth truth = make_truth(truth_model, parameters, seed + day_stream, heats, conditions_of_day(plan, theta));
    Service& day = result.days[d];
    day.span_um = rom::um_per_m * (truth.nose_m.maxCoeff() - truth.nose_m.minCoeff());
    day.uncorrected_um = run_open_loop(network, truth).error_um;
    for (std::size_t set = 0; set < permanent_sensors.size(); ++set) {
      correction::EstimatorOptions options;
      options.priors = priors_of(heats);
      day.without_test[set] = run_estimator(network, truth, permanent_sensors[set], false, options);
      options.priors.calibrated =
          correction::prior_of(result.calibrations[set], {drifts[d].heat, drifts[d].contact, drifts[d].film});
      day.with_test[set] = run_estimator(network, truth, permanent_sensors[set], false, options);
      day.blind[set] = run_blind(network, truth, options);
      day.bound_um[set] = bound_um(network, truth, permanent_sensors[set], false, options);
    }
  }
  return result;
}

}  // namespace spindle_twin::bench
