#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "correction/estimator/sensor_channel.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/bench/campaign/campaign.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double drift_at_end = 0.2;
constexpr double refactor_s = 600.0;        // the drift goes in steps of this length
constexpr double friction_update_s = 30.0;  // so does the friction heat with its temperature
constexpr double friction_per_K = 0.010;
constexpr double noise_K = 0.03;
constexpr double tare_K = 0.02;
constexpr double inlet_error_K = 0.1;
constexpr double inlet_memory_s = 1800.0;

constexpr double block_step_s = 10.0;

std::vector<DriveBlock> draw_spectrum(std::mt19937_64& random, const Conditions& conditions) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<DriveBlock> blocks;
  for (double time_s = 0.0; time_s < conditions.run_s;) {
    const double until_s = time_s + block_step_s * std::round((180.0 + 540.0 * unit(random)) / block_step_s);
    const double speed_rpm = unit(random) < 0.1 ? 0.0 : 12000.0 * unit(random);
    blocks.push_back({until_s, speed_rpm, unit(random)});
    time_s = until_s;
  }
  return blocks;
}

}  // namespace

double drift(const Conditions& conditions, double time_s) {
  return std::log1p(drift_at_end * std::floor(time_s / refactor_s) * refactor_s / conditions.run_s);
}

correction::EstimatorPriors priors_of(HeatErrors heats) {
  correction::EstimatorPriors priors;
  if (heats == HeatErrors::common) {
    priors.heat = 0.15;
    priors.heat_common = 0.5;
  }
  return priors;
}

Truth make_truth(const fem_offline::AffineModel& model, const correction::ParameterModel& parameters,
                 std::uint64_t seed, HeatErrors heats, const Conditions& conditions) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  Truth truth{seed, heats, conditions, Eigen::VectorXd::Zero(parameters.count()), {}, {}, {}, {}, {}, {}};
  const auto samples = static_cast<Eigen::Index>(std::lround(conditions.run_s / conditions.sample_s)) + 1;
  const double step_s = conditions.sample_s;
  const auto key_points = static_cast<Eigen::Index>(model.key_points.size());
  truth.key_points_K = truth.measured_K = Eigen::MatrixXd::Zero(samples, key_points);
  truth.nose_m = truth.touch_off_m = truth.rotor_K = Eigen::VectorXd::Zero(samples);

  // Medians of the factors are 1, whatever the twin starts from.
  const double common = heats == HeatErrors::common ? normal(random) : 0.0;
  const correction::EstimatorPriors priors = priors_of(heats);
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const correction::Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    switch (parameter.kind) {
      case correction::ParameterKind::heat:
        truth.theta[i] = priors.heat_common * common + priors.heat * normal(random);
        break;
      case correction::ParameterKind::bearing_temperature:
        truth.theta[i] = friction_per_K;
        break;
      case correction::ParameterKind::environment:
      case correction::ParameterKind::disturbance:
      case correction::ParameterKind::start:
        break;
      case correction::ParameterKind::expansion:
        truth.theta[i] = conditions.expansion * normal(random);
        break;
      case correction::ParameterKind::speed_exponent:
        truth.theta[i] = conditions.speed_exponent * normal(random);
        break;
      default:
        truth.theta[i] = parameter.deviation * normal(random);
    }
  }
  Eigen::VectorXd offsets_K(key_points);
  for (double& offset_K : offsets_K) offset_K = tare_K * normal(random);
  if (conditions.theta.size() > 0) truth.theta = conditions.theta;
  std::vector<DriveBlock> blocks = draw_spectrum(random, conditions);
  if (!conditions.drive.empty()) blocks = conditions.drive;
  const rom::Boundaries& boundaries = model.boundaries;
  const auto environments = static_cast<Eigen::Index>(boundaries.environments.size());
  Eigen::VectorXd inlet_K(environments), phase(environments);
  for (Eigen::Index e = 0; e < environments; ++e) {
    inlet_K[e] = inlet_error_K * normal(random);
    phase[e] = 2.0 * std::numbers::pi * normal(random);
  }
  Eigen::VectorXd sensors_K = Eigen::VectorXd::Zero(key_points);  // what they would show without noise
  const double keep = std::exp(-step_s / inlet_memory_s);

  fem_offline::FeStepper stepper(model);
  stepper.set_uniform_temperature(boundaries.reference_temperature_K);
  rom::CorrectionFactors factors = rom::no_correction(boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(environments), rises_K(boundaries.sources.size());
  const auto rotor = std::find_if(model.parts.begin(), model.parts.end(),
                                  [](const fem_offline::FePart& part) { return part.name == "rotor"; });
  Eigen::VectorXd theta = truth.theta;
  const double expansion = parameters.expansion_factor(theta);
  std::size_t block = 0;
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double time_s = static_cast<double>(k) * step_s;
    while (time_s >= blocks[block].until_s && block + 1 < blocks.size()) ++block;
    rom::OperatingState operating = boundaries.operating;
    operating.speed_rpm = blocks[block].speed_rpm;
    operating.load = blocks[block].load;
    if (conditions.standstill && time_s >= 0.5 * conditions.run_s && time_s < 0.75 * conditions.run_s) {
      operating.speed_rpm = operating.load = 0.0;
    }
    for (Eigen::Index e = 0; e < environments; ++e) {
      const double swing_K =
          boundaries.environments[static_cast<std::size_t>(e)].kind == rom::EnvironmentKind::ambient ? 1.5 : 0.5;
      const double slow = std::sin(2.0 * std::numbers::pi * time_s / 5400.0 + phase[e]) - std::sin(phase[e]);
      operating.environment_K[e] += swing_K * slow;
    }
    rom::OperatingState read = operating;
    read.environment_K += inlet_K;
    truth.read.push_back(read);
    for (double& error_K : inlet_K) {
      error_K = keep * error_K + inlet_error_K * std::sqrt(1.0 - keep * keep) * normal(random);
    }

    const Eigen::VectorXd& now_K = stepper.temperatures_K();
    for (Eigen::Index s = 0; s < key_points; ++s) {
      truth.key_points_K(k, s) = model.key_points[static_cast<std::size_t>(s)].row.dot(now_K);
      const double before_K = truth.key_points_K(std::max<Eigen::Index>(k - 1, 0), s);
      sensors_K[s] = k == 0
                         ? truth.key_points_K(k, s)
                         : correction::lag(sensors_K[s], before_K, truth.key_points_K(k, s), step_s, conditions.lag_s);
      truth.measured_K(k, s) = sensors_K[s] + offsets_K[s] + noise_K * normal(random);
    }
    const Eigen::VectorXd& nose = model.deformations.front().row_m_per_K;
    truth.nose_m[k] = expansion * (nose.dot(now_K) - nose.sum() * boundaries.reference_temperature_K);
    truth.touch_off_m[k] = truth.nose_m[k] + touch_off_m * normal(random);
    truth.rotor_K[k] = now_K(rotor->dofs).maxCoeff();

    if (std::fmod(time_s, friction_update_s) == 0.0 || k == 0 ||
        read.speed_rpm != truth.read[static_cast<std::size_t>(k - 1)].speed_rpm) {
      rises_K = model.source_distribution.transpose() * now_K;
      rises_K.array() -= boundaries.reference_temperature_K;
    }
    for (Eigen::Index i = 0; i < parameters.count(); ++i) {
      if (parameters.list()[static_cast<std::size_t>(i)].kind == correction::ParameterKind::contact) {
        theta[i] = truth.theta[i] + drift(conditions, time_s);
      }
    }
    parameters.apply(theta, operating.speed_rpm, rises_K, factors, bias_K);
    // The true law is a straight line, where the twin's is an exponential.
    for (Eigen::Index i = 0; i < rises_K.size(); ++i) {
      if (!parameters.is_friction(i)) continue;
      factors.heat[i] *= std::max(0.1, 1.0 - friction_per_K * rises_K[i]) / std::exp(-friction_per_K * rises_K[i]);
    }
    rom::evaluate_boundaries(boundaries, operating, factors, values);
    stepper.advance(step_s, step_s, values);
  }
  return truth;
}

}  // namespace spindle_twin::bench
