#include "tests/bench/faults/follow.hpp"

#include <algorithm>
#include <cmath>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "rom/units.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double tolerance_K = 1e-4;
constexpr double noise_K = 0.03;
constexpr double offset_K = 0.02;
constexpr double moving_K = 0.25;
constexpr double moving_window_s = 120.0;
constexpr double slew_m_per_s = 5e-7;  // the daemon's default

/// Truth at any instant, and what its sensors say.
struct Sensors {
  Sensors(const Truth& the_truth, double the_resolution_K)
      : truth(the_truth), random(the_truth.seed), resolution_K(the_resolution_K) {
    offsets_K = Eigen::VectorXd::Zero(truth.key_points_K.cols());
    for (double& offset : offsets_K) offset = offset_K * normal(random);
    readings_K = offsets_K;
  }
  void read(double time_s) {
    const auto k = static_cast<Eigen::Index>(time_s / sample_s);
    const double share = time_s / sample_s - static_cast<double>(k);
    const Eigen::Index next = std::min(k + 1, truth.nose_m.size() - 1);
    nose_m = (1.0 - share) * truth.nose_m[k] + share * truth.nose_m[next];
    for (Eigen::Index s = 0; s < readings_K.size(); ++s) {
      const double true_K = (1.0 - share) * truth.key_points_K(k, s) + share * truth.key_points_K(next, s);
      readings_K[s] = true_K + offsets_K[s] + noise_K * normal(random);
    }
  }
  /// The truth changes by a quarter of a kelvin within the next two minutes.
  bool moves(double time_s, int sensor) const {
    const auto k = static_cast<Eigen::Index>(time_s / sample_s);
    const auto count = std::min<Eigen::Index>(std::lround(moving_window_s / sample_s) + 1, truth.nose_m.size() - k);
    const auto ahead = truth.key_points_K.col(sensor).segment(k, count);
    return count > 1 && ahead.maxCoeff() - ahead.minCoeff() >= moving_K;
  }
  void quantise() {
    for (double& reading_K : readings_K) reading_K = resolution_K * std::round(reading_K / resolution_K);
  }
  const Truth& truth;
  std::mt19937_64 random;
  std::normal_distribution<double> normal{0.0, 1.0};
  double resolution_K;
  Eigen::VectorXd offsets_K, readings_K;
  double nose_m = 0.0;
};

struct Twin {
  explicit Twin(const rom::Network& the_network)
      : network(the_network),
        outputs(rom::make_network_outputs(the_network)),
        values(rom::make_boundary_values(the_network.boundaries)) {
    rom::CvodeSettings settings;
    settings.tolerance_K = tolerance_K;
    stepper = rom::make_runtime_stepper(the_network, settings);
    evaluate();
  }
  void evaluate(double expansion = 1.0) {
    rom::evaluate_outputs(network, stepper->temperatures_K(), outputs, expansion);
  }
  void advance(const rom::OperatingState& operating, const rom::CorrectionFactors& factors, double period_s) {
    rom::evaluate_boundaries(network.boundaries, operating, factors, values);
    if (stepper->advance(period_s, values) != rom::StepStatus::ok) std::abort();
    evaluate(factors.expansion);
  }
  const rom::Network& network;
  std::unique_ptr<rom::FallbackStepper> stepper;
  rom::NetworkOutputs outputs;
  rom::BoundaryValues values;
};

}  // namespace

Followed follow(const rom::Network& network, const Truth& truth, const Fault& fault, const FollowOptions& options) {
  Followed result;
  result.fault = fault;
  Twin twin(network), uncorrected(network);
  const rom::CorrectionFactors none = rom::no_correction(network.boundaries);
  correction::EstimatorCorrection estimator(network, options.estimator);
  correction::LeaveOneOut bank(estimator);
  const auto sensors = static_cast<Eigen::Index>(estimator.sensors().size());
  const auto count = static_cast<std::size_t>(sensors);
  correction::SensorHealth health(
      std::vector<correction::HealthChannel>(count, {true, 253.15, 423.15, options.resolution_K}), options.limits);
  std::vector<correction::HealthSample> samples(count);
  std::vector<correction::HealthUpdate> judged_updates(count);
  std::vector<correction::HealthState> before(count, correction::HealthState::good);
  Sensors readings(truth, options.resolution_K);
  Saboteur saboteur(fault, truth.seed);
  Eigen::VectorXd corrected_K = twin.outputs.key_points_K;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(sensors, true);
  const long cycles = std::lround(run_s / options.cycle_s);
  double published_m = 0.0;
  long updates = 0, loosened = 0, relinearised = 0, judged = 0, before_found = 0, inside = 0;
  for (long cycle = 0; cycle <= cycles; ++cycle) {
    const double time_s = static_cast<double>(cycle) * options.cycle_s;
    rom::OperatingState operating = truth.read[static_cast<std::size_t>(time_s / sample_s)];
    readings.read(time_s);
    const double nose_before_m = twin.outputs.deformations_m[0];
    readings.quantise();
    saboteur.tamper(time_s, readings.readings_K);
    for (std::size_t s = 0; s < count; ++s) {
      const auto i = static_cast<Eigen::Index>(s);
      const double predicted_K = twin.outputs.key_points_K[i];
      samples[s] = {true,
                    readings.readings_K[i],
                    predicted_K,
                    predicted_K - corrected_K[i],
                    uncorrected.outputs.key_points_K[i],
                    estimator.filter().mean()[estimator.parameters().count() + i]};
    }
    health.step(samples, time_s, cycle == 0 ? 0.0 : options.cycle_s);
    for (std::size_t s = 0; s < count; ++s) {
      const correction::HealthRecord& record = health.record(s);
      const auto i = static_cast<Eigen::Index>(s);
      const bool withdrawn = fault.is_reference() && fault.concerns(static_cast<int>(s)) && fault.at(time_s);
      valid[i] = !withdrawn && (record.usable || !options.with_health);
      if (record.returned && options.with_health) {
        estimator.widen_offset(i, record.return_offset_deviation_K);
        bank.widen_offset(estimator, i, record.return_offset_deviation_K);
      }
    }
    const correction::EstimatorStep step = estimator.step(
        {time_s, readings.readings_K, valid, twin.stepper->temperatures_K(), operating}, options.cycle_s);
    if (step.state_corrected) {
      twin.stepper->set_temperatures(estimator.corrected_nodes_K());
      twin.evaluate(estimator.factors().expansion);
    }
    corrected_K = twin.outputs.key_points_K;
    if (estimator.updates() != updates) {
      updates = estimator.updates();
      if (estimator.loosened() != loosened) {
        loosened = estimator.loosened();
        bank.follow(estimator);
        health.note_restart();
      }
      if (estimator.relinearised() != relinearised) {
        relinearised = estimator.relinearised();
        bank.follow(estimator);  // this update's readings are in what it follows
      } else {
        bank.update(estimator);
      }
      for (std::size_t s = 0; s < count; ++s) {
        const correction::SensorRecord& record = estimator.record(static_cast<Eigen::Index>(s));
        const correction::Misfit& misfit = bank.misfit(static_cast<Eigen::Index>(s));
        judged_updates[s] = {record.fused || record.rejected,
                             misfit.evidence,
                             record.rejected_in_a_row,
                             record.observation_K,
                             misfit.misfit_K,
                             misfit.deviation_K};
      }
      const correction::HealthVerdict verdict =
          options.with_health ? health.note_update(judged_updates) : correction::HealthVerdict{};
      if (options.with_health) estimator.set_alternatives(bank.alternatives(estimator));
      if (verdict.loosen) estimator.note_contradiction();
      if (verdict.failed >= 0) {
        if (verdict.partner >= 0) {
          estimator.adopt(bank.before(estimator), operating);
          bank.follow(estimator);
        } else {
          estimator.adopt(bank.without(verdict.failed), operating);
          bank.settle_on(verdict.failed);
        }
        twin.stepper->set_temperatures(estimator.corrected_nodes_K());
        twin.evaluate(estimator.factors().expansion);
        corrected_K = twin.outputs.key_points_K;
      }
    }
    if (options.each) options.each(time_s, estimator, health, bank);

    for (std::size_t s = 0; s < count; ++s) {
      const correction::HealthRecord& record = health.record(s);
      const int sensor = static_cast<int>(s);
      const bool faulty = !fault.is_reference() && fault.concerns(sensor);
      const bool active = faulty && time_s >= fault.from_s;
      const bool fell = record.state == correction::HealthState::failed &&
                        before[s] != correction::HealthState::failed && before[s] != correction::HealthState::returning;
      if (fell && active && sensor == fault.sensor && result.delay_s < 0.0) {
        result.delay_s = time_s - fault.from_s;
        result.named = record.fault;
      }
      if (active && sensor == fault.sensor && result.withheld_s < 0.0 && !record.usable) {
        result.withheld_s = time_s - fault.from_s;
      }
      if (fell && !active && !(fault.is_reference() && fault.concerns(sensor))) ++result.false_alarms;
      if (active && result.moving_s < 0.0 && time_s >= fault.from_s && readings.moves(time_s, sensor)) {
        result.moving_s = time_s - fault.from_s;
      }
      if (!active && !record.usable) ++result.withheld;
      if (active && sensor == fault.sensor && time_s >= fault.until_s && record.returned) {
        result.returned_s = time_s - fault.until_s;
      }
      before[s] = record.state;
    }
    const double published_before_m = published_m;
    const double most_m = slew_m_per_s * options.cycle_s;
    published_m += std::clamp(twin.outputs.deformations_m[0] - published_m, -most_m, most_m);
    const double from_s = std::max(fault.from_s, judged_from_s);
    if (time_s >= from_s) {
      const double held_back_m = twin.outputs.deformations_m[0] - published_m;
      const double error_um = rom::um_per_m * (published_m - readings.nose_m);
      const double deviation_um = rom::um_per_m * std::hypot(estimator.deviations().deformations_m[0], held_back_m);
      result.error_um += error_um * error_um;
      result.deviation_um += deviation_um * deviation_um;
      result.largest_um = std::max(result.largest_um, std::abs(error_um));
      result.raw_step_um =
          std::max(result.raw_step_um, rom::um_per_m * std::abs(twin.outputs.deformations_m[0] - nose_before_m));
      result.step_um = std::max(result.step_um, rom::um_per_m * std::abs(published_m - published_before_m));
      ++judged;
      if (result.delay_s < 0.0) {
        ++before_found;
        inside += std::abs(error_um) <= 2.0 * deviation_um ? 1 : 0;
        result.largest_until_found = std::max(result.largest_until_found, std::abs(error_um) / deviation_um);
      }
    }
    uncorrected.advance(operating, none, options.cycle_s);
    operating.environment_K += estimator.environment_bias_K();
    twin.advance(operating, estimator.factors(), options.cycle_s);
  }
  result.error_um = std::sqrt(result.error_um / static_cast<double>(judged));
  result.deviation_um = std::sqrt(result.deviation_um / static_cast<double>(judged));
  if (before_found > 0) result.inside_until_found = static_cast<double>(inside) / static_cast<double>(before_found);
  return result;
}

}  // namespace spindle_twin::bench
