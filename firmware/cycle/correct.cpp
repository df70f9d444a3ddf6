#include "firmware/cycle/correct.hpp"

#include <cmath>
#include <utility>

#include "correction/growth/growth_reading.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::firmware {
namespace {

static_assert(bits(CorrectionFreeze::too_few_sensors) == bits(correction::Freeze::too_few_sensors));
static_assert(bits(CorrectionFreeze::base_failed) == bits(correction::Freeze::base_failed));

constexpr double reading_slack_s = 1e-3;

void add_estimator(const rom::Network& network, const CyclePlan& plan,
                   std::shared_ptr<const rom::NetworkOperator> shared, Corrector& corrector) {
  correction::EstimatorOptions options = *plan.estimator;
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    const SensorPlan& sensor = plan.sensors[k];
    if (!sensor.configured) continue;
    const rom::KeyPoint& point = network.key_points[k];
    options.sensors.push_back({point.name, point.row, sensor.noise_K, sensor.offset_deviation_K, sensor.lag_s});
    corrector.channels.push_back({k, sensor.interval_s, k, false, 0});
  }
  if (options.sensors.empty() && network.key_points.empty()) return;  // nowhere to look at
  corrector.estimator.emplace(network, std::move(options), std::move(shared));
}

/// A reading that was taken before, or is a repeat of one, would count twice.
bool is_new(const CorrectorChannel& channel, double clock_rate, const Sensed& reading) {
  if (reading.time_ns == channel.taken_ns) return false;
  if (channel.taken_ns == 0) return true;
  return 1e-9 * static_cast<double>(reading.time_ns - channel.taken_ns) * clock_rate >=
         channel.interval_s - reading_slack_s;
}

void take_readings(const SensedInputs& sensed, const Judgement& judgement, Corrector& corrector) {
  for (std::size_t c = 0; c < corrector.channels.size(); ++c) {
    CorrectorChannel& channel = corrector.channels[c];
    const Sensed& reading = sensed.sensors[channel.reader];
    const bool is_own = channel.reader == channel.key_point;
    const bool good = is_own ? judgement.sensors[channel.key_point] == SensorQuality::good : channel.reads;
    const bool take = good && is_new(channel, corrector.clock_rate, reading);
    const auto row = static_cast<Eigen::Index>(c);
    corrector.measured.valid[row] = take;
    corrector.measured.value_K[row] = reading.value;
    if (take) channel.taken_ns = reading.time_ns;
  }
}

CorrectionFreeze freeze_of(const correction::EstimatorCorrection& estimator, std::size_t channels) {
  if (estimator.updates() == 0) return CorrectionFreeze::waiting;
  for (std::size_t c = 0; c < channels; ++c) {
    if (estimator.record(static_cast<Eigen::Index>(c)).fused) return CorrectionFreeze::none;
  }
  return CorrectionFreeze::too_few_sensors;
}

CorrectedInputs run_estimator(const SensedInputs& sensed, const Judgement& judgement,
                              const rom::OperatingState& operating, const Period& period, Model& model,
                              Corrector& corrector) {
  correction::EstimatorCorrection& estimator = *corrector.estimator;
  if (!corrector.enabled) {
    estimator.stand_by(period.start_s, model.stepper->temperatures_K(), operating, period.advance_s);
    corrector.freeze = bits(CorrectionFreeze::waiting);
    return {estimator.factors(), operating};
  }
  take_readings(sensed, judgement, corrector);
  const long updates = estimator.updates();
  const correction::EstimatorStep step =
      estimator.step({period.start_s, corrector.measured.value_K, corrector.measured.valid,
                      model.stepper->temperatures_K(), operating},
                     period.advance_s);
  if (step.corrected) ++corrector.corrections;
  if (step.state_corrected) model.stepper->set_temperatures(estimator.corrected_nodes_K());
  if (estimator.updates() != updates) corrector.freeze = bits(freeze_of(estimator, corrector.channels.size()));
  return {estimator.factors(), with_biases(operating, corrector)};
}

CorrectedInputs run_paper(const SensedInputs& sensed, const Judgement& judgement, const rom::OperatingState& operating,
                          const Period& period, Model& model, Corrector& corrector) {
  if (!corrector.enabled) {
    corrector.paper->stand_by(period.start_s, model.stepper->temperatures_K(), operating, period.advance_s);
    corrector.freeze = bits(CorrectionFreeze::waiting);
    return {corrector.paper->factors(), operating};
  }
  for (Eigen::Index k = 0; k < corrector.measured.value_K.size(); ++k) {
    const auto sensor = static_cast<std::size_t>(k);
    corrector.measured.value_K[k] = sensed.sensors[sensor].value;
    corrector.measured.valid[k] = judgement.sensors[sensor] == SensorQuality::good;
  }
  const correction::PaperStep step =
      corrector.paper->step({period.start_s, corrector.measured.value_K, corrector.measured.valid,
                             model.outputs.key_points_K, model.stepper->temperatures_K(), operating},
                            period.advance_s);
  if (step.corrected) ++corrector.corrections;
  if (step.state_rescaled) model.stepper->set_temperatures(corrector.paper->rescaled_nodes_K());
  corrector.freeze = static_cast<std::uint16_t>(corrector.paper->freeze(0));
  return {corrector.paper->factors(), operating};
}

}  // namespace

Corrector make_corrector(const rom::Network& network, const CyclePlan& plan, const MakeStepper& make_stepper,
                         std::shared_ptr<const rom::NetworkOperator> shared) {
  Corrector corrector;
  corrector.none = rom::no_correction(network.boundaries);
  corrector.operating = network.boundaries.operating;
  corrector.clock_rate = plan.clock_rate;
  corrector.freeze = bits(CorrectionFreeze::waiting);
  auto readings = static_cast<Eigen::Index>(network.key_points.size());
  if (plan.paper) {
    corrector.paper.emplace(network, *plan.paper, [&] { return make_stepper(network); });
  } else if (plan.estimator) {
    add_estimator(network, plan, std::move(shared), corrector);
    // Of the same sizes as the estimator's, so that switching it off and on allocates nothing.
    if (corrector.estimator) corrector.none = corrector.estimator->parameters().make_factors(network);
    if (corrector.estimator) readings = static_cast<Eigen::Index>(corrector.estimator->sensors().size());
  }
  corrector.measured.value_K = Eigen::VectorXd::Constant(readings, not_a_value);
  corrector.measured.valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(readings, false);
  corrector.corrects = corrector.paper || (corrector.estimator && plan.estimator_corrects);
  corrector.enabled = corrector.corrects && plan.correction_enabled;
  return corrector;
}

CorrectedInputs correct(const SensedInputs& sensed, const Judgement& judgement, const rom::OperatingState& operating,
                        const Period& period, Model& model, Corrector& corrector) {
  if (corrector.paper) return run_paper(sensed, judgement, operating, period, model, corrector);
  if (corrector.estimator) return run_estimator(sensed, judgement, operating, period, model, corrector);
  return {corrector.none, operating};
}

const rom::OperatingState& with_biases(const rom::OperatingState& operating, Corrector& corrector) {
  corrector.operating = operating;
  corrector.operating.environment_K += corrector.estimator->environment_bias_K();
  return corrector.operating;
}

bool take_displacement(int index, double value_m, double deviation_m, Corrector& corrector) {
  if (!corrector.estimator || !corrector.enabled) return false;
  const bool exists = index >= 0 && index < corrector.estimator->deviations().deformations_m.size();
  if (!exists || !correction::is_growth(value_m, deviation_m)) return false;
  corrector.estimator->note_displacement(index, value_m, deviation_m);
  ++corrector.displacements.count;
  corrector.displacements.due = corrector.estimator->updates() + 1;
  return true;
}

bool is_estimate_in_doubt(const Corrector& corrector) {
  if (!corrector.estimator || !corrector.enabled) return false;
  constexpr double most_K = 5.0;  // 25 deviations of a class A PT100 without a tare
  const correction::EstimatorCorrection& estimator = *corrector.estimator;
  for (std::size_t s = 0; s < estimator.sensors().size(); ++s) {
    if (std::abs(estimator.record(static_cast<Eigen::Index>(s)).offset_K) > most_K) return true;
  }
  return estimator.is_beyond_belief() || estimator.consistency().in_doubt();
}

bool waits_for_update(const Corrector& corrector) {
  return corrector.estimator && corrector.enabled && corrector.estimator->updates() < corrector.displacements.due;
}

void take_probes(const CyclePlan& plan, const SensedInputs& sensed, double tare_m, Corrector& corrector) {
  if (!corrector.estimator || !corrector.enabled || waits_for_update(corrector)) return;
  constexpr std::size_t none = slots::deformations;
  std::size_t next = none;  // of those that are due the one that has waited longest
  for (std::size_t d = 0; d < plan.probes.size(); ++d) {
    const ProbePlan& probe = plan.probes[d];
    const Sensed& reading = sensed.displacements[d];
    const std::int64_t probed_ns = corrector.displacements.probed_ns[d];
    if (!probe.configured) continue;
    const double since_s = 1e-9 * static_cast<double>(reading.time_ns - probed_ns) * plan.clock_rate;
    const bool due = probed_ns == 0 || since_s >= probe.interval_s - reading_slack_s;
    const bool good = reading.value >= probe.min_m && reading.value <= probe.max_m &&
                      reading.age_s <= probe.stale_after_s && reading.time_ns != probed_ns;
    if (due && good && (next == none || probed_ns < corrector.displacements.probed_ns[next])) next = d;
  }
  if (next == none) return;
  const Sensed& reading = sensed.displacements[next];
  corrector.displacements.probed_ns[next] = reading.time_ns;
  const double elongation_m = reading.value + (next == 0 ? tare_m : 0.0);
  take_displacement(static_cast<int>(next), elongation_m, plan.probes[next].deviation_m, corrector);
}

}  // namespace spindle_twin::firmware
