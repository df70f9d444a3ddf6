#include "firmware/cycle/publish.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "correction/estimator/factor_spread.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/integrate/output_uncertainty.hpp"

namespace spindle_twin::firmware {
namespace {

template <std::size_t room>
void copy(const Eigen::VectorXd& from, std::array<double, room>& to) {
  std::copy_n(from.data(), std::min(static_cast<std::size_t>(from.size()), room), to.begin());
}

/// Of a displacement the record's kelvin are metres. Before a channel's first update there is nothing to tell.
void copy(const correction::SensorRecord& from, ChannelUpdate& to) {
  to = {};
  if (from.variance_K2 == 0.0) return;
  to.observation = from.observation_K;
  to.variance = from.variance_K2;
  to.offset = from.offset_K;
  to.offset_deviation = from.offset_deviation_K;
  constexpr int most = std::numeric_limits<std::uint16_t>::max() - 1;
  to.rejected_in_a_row = static_cast<std::uint16_t>(std::min(from.rejected_in_a_row, most));
  if (std::isnan(from.observation_K)) return;
  to.innovation = from.innovation_K;
  to.test_ratio = from.test_ratio;
  if (from.fused) to.flags |= bits(Update::fused);
  if (from.rejected) to.flags |= bits(Update::rejected);
}

/// What is known of each factor.
void publish_bands(const Corrector& corrector, Snapshot& snapshot) {
  const correction::EstimatorCorrection& estimator = *corrector.estimator;
  const correction::FactorKnowledge known{estimator.parameters(), estimator.prior(), estimator.filter()};
  const bool is_in_use = corrector.corrects && corrector.enabled;
  const auto band = [&](const correction::FactorSpread& spread) {
    const auto deviation = static_cast<float>(is_in_use ? spread.deviation : not_a_value);
    return FactorBand{static_cast<float>(spread.prior_mean), static_cast<float>(spread.prior_deviation), deviation};
  };
  const double speed_rpm = snapshot.signals[static_cast<std::size_t>(Signal::speed)];
  for (std::size_t i = 0; i < snapshot.sources; ++i) {
    const auto source = static_cast<Eigen::Index>(i);
    snapshot.heat_band[i] = band(heat_spread(known, source, speed_rpm, estimator.source_rises_K()[source]));
  }
  for (std::size_t j = 0; j < snapshot.conductances; ++j) {
    snapshot.conductance_band[j] = band(conductance_spread(known, static_cast<Eigen::Index>(j)));
  }
}

}  // namespace

Snapshot first_snapshot(const rom::Network& network) {
  Snapshot snapshot;
  snapshot.key_points = network.key_points.size();
  snapshot.parts = network.parts.size();
  snapshot.sources = network.boundaries.sources.size();
  snapshot.conductances = network.boundaries.conductances.size();
  snapshot.deformations = network.deformations.size();
  snapshot.circuits = network.boundaries.circuits.size();
  snapshot.heats = rom::measured_heats(network.boundaries).size();
  const Eigen::VectorXd deviation_m = rom::output_uncertainty(network).deformations_m;
  if (deviation_m.size() > 0) snapshot.nose_network_deviation_m = deviation_m[0];
  return snapshot;
}

void publish_inputs(const SensedInputs& sensed, const Judgement& judgement, Snapshot& snapshot) {
  snapshot.data_age_s = judgement.data_age_s;
  snapshot.sensor_quality = judgement.sensors;
  snapshot.signals = judgement.signals;
  snapshot.signals_held = judgement.signals_held;
  snapshot.signals_implausible = judgement.signals_implausible;
  snapshot.devices = sensed.devices;
  for (std::size_t k = 0; k < snapshot.key_points; ++k) {
    const bool configured = judgement.sensors[k] != SensorQuality::not_configured;
    snapshot.measured_K[k] = configured ? sensed.sensors[k].value : not_a_value;
    snapshot.raw_K[k] = configured ? sensed.raw_K[k] : not_a_value;
    snapshot.measured_age_s[k] = configured ? sensed.sensors[k].age_s : not_a_value;
  }
  for (std::size_t d = 0; d < snapshot.deformations; ++d) {
    snapshot.probe_m[d] = sensed.displacements[d].value;
    snapshot.probe_age_s[d] = sensed.displacements[d].age_s;
  }
}

void publish_corrected(const Model& model, double most_m, const std::array<double, slots::deformations>& limit_m,
                       Snapshot& snapshot) {
  copy(model.outputs.key_points_K, snapshot.predicted_K);
  copy(model.outputs.part_maximum_K, snapshot.part_maximum_K);
  copy(model.outputs.deformations_m, snapshot.deformation_raw_m);
  snapshot.outputs_clamped = 0;
  const auto within = [&](double value_m, std::size_t i) {
    if (std::abs(value_m) > limit_m[i]) snapshot.outputs_clamped |= static_cast<std::uint16_t>(1U << i);
    return std::clamp(value_m, -limit_m[i], limit_m[i]);
  };
  for (std::size_t i = 0; i < snapshot.deformations; ++i) {
    double& published_m = snapshot.deformation_m[i];
    const double wanted_m = within(snapshot.deformation_raw_m[i], i);
    published_m = std::isnan(published_m) ? wanted_m : std::clamp(wanted_m, published_m - most_m, published_m + most_m);
    if (published_m != wanted_m) snapshot.quality |= bits(Quality::slewing);
  }
  snapshot.nose_m = within(snapshot.deformation_m[0] - snapshot.tare_m, 0);
  snapshot.fault &= static_cast<std::uint16_t>(~bits(Fault::output_clamped));
  if (snapshot.outputs_clamped != 0) snapshot.fault |= bits(Fault::output_clamped);
}

void publish_nose(double limit_m, Snapshot& snapshot) {
  snapshot.nose_m = std::clamp(snapshot.deformation_m[0] - snapshot.tare_m, -limit_m, limit_m);
}

bool tare(double limit_m, Snapshot& snapshot) {
  if (snapshot.deformations == 0) return false;
  snapshot.tare_m = std::clamp(snapshot.deformation_raw_m[0], -limit_m, limit_m);
  snapshot.deformation_m[0] = snapshot.tare_m;
  return true;
}

void publish_uncorrected(const Model& model, Snapshot& snapshot) {
  copy(model.outputs.key_points_K, snapshot.uncorrected_K);
  if (model.outputs.deformations_m.size() > 0) {
    snapshot.nose_uncorrected_m = model.outputs.deformations_m[0] - snapshot.tare_m;
  }
}

void publish_correction(const Corrector& corrector, const rom::CorrectionFactors& factors, Snapshot& snapshot) {
  copy(factors.heat, snapshot.heat_factor);
  copy(factors.conductance, snapshot.conductance_factor);
  snapshot.correction_configured = corrector.corrects;
  snapshot.correction_enabled = corrector.enabled;
  snapshot.correction_count = corrector.corrections;
  snapshot.correction_freeze = corrector.freeze;
}

void publish_estimate(const Corrector& corrector, Snapshot& snapshot) {
  if (!corrector.estimator) return;
  const correction::EstimatorCorrection& estimator = *corrector.estimator;
  const correction::OutputDeviations& deviations = estimator.deviations();
  copy(deviations.key_points_K, snapshot.predicted_deviation_K);
  copy(deviations.part_maximum_K, snapshot.part_maximum_deviation_K);
  for (std::size_t i = 0; i < snapshot.deformations; ++i) {
    snapshot.deformation_deviation_m[i] = std::hypot(deviations.deformations_m[static_cast<Eigen::Index>(i)],
                                                     snapshot.deformation_raw_m[i] - snapshot.deformation_m[i]);
  }
  publish_bands(corrector, snapshot);
  if (!corrector.corrects) return;
  if (is_estimate_in_doubt(corrector)) snapshot.quality |= bits(Quality::estimate_in_doubt);
  snapshot.updates = static_cast<std::uint32_t>(estimator.updates());
  const Eigen::Index parameters = estimator.parameters().count();
  snapshot.parameters = static_cast<std::uint16_t>(parameters);
  snapshot.parameters_determined = 0;
  for (Eigen::Index i = 0; i < parameters; ++i) {
    if (!estimator.estimate(i).undetermined()) ++snapshot.parameters_determined;
  }
  if (const correction::CalibratedPrior* calibrated = estimator.parameters().calibrated()) {
    snapshot.calibrated_unix_s = calibrated->made_unix_s;
    snapshot.calibration_promised_m = calibrated->promised_m;
  }
  const correction::FoundHeat heat = estimator.unexplained_heat();
  snapshot.unexplained_heat_group = static_cast<std::int16_t>(heat.group);
  snapshot.unexplained_heat_W = heat.group < 0 ? not_a_value : heat.heat_W;
  for (std::size_t c = 0; c < corrector.channels.size(); ++c) {
    const CorrectorChannel& channel = corrector.channels[c];
    ChannelUpdate& update = snapshot.sensor_update[channel.key_point];
    copy(estimator.record(static_cast<Eigen::Index>(c)), update);
    if (channel.reader != channel.key_point) update.flags |= bits(Update::by_partner);
  }
  snapshot.displacement_count = corrector.displacements.count;
  if (corrector.displacements.count > 0) copy(estimator.displacement_record(), snapshot.displacement_update);
}

void publish_forecast(const Forecast& forecast, const CompensationPlan& plan, Snapshot& snapshot) {
  const double nose_m = snapshot.deformation_raw_m[0] - snapshot.tare_m + forecast.change_m();
  snapshot.compensation.forecast_m = std::clamp(plan.sign * nose_m, -plan.limit_m, plan.limit_m);
  snapshot.compensation.settled_after_s = forecast.settled_after_s();
}

}  // namespace spindle_twin::firmware
