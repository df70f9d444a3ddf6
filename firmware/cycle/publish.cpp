#include "firmware/cycle/publish.hpp"

#include <algorithm>

#include "rom/integrate/output_uncertainty.hpp"

namespace spindle_twin::firmware {
namespace {

template <std::size_t room>
void copy(const Eigen::VectorXd& from, std::array<double, room>& to) {
  std::copy_n(from.data(), std::min(static_cast<std::size_t>(from.size()), room), to.begin());
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
  const Eigen::VectorXd sd_m = rom::output_uncertainty(network).deformations_m;
  if (sd_m.size() > 0) snapshot.nose_network_sd_m = sd_m[0];
  snapshot.signals.fill(not_a_value);
  snapshot.measured_K.fill(not_a_value);
  snapshot.sensor_quality.fill(SensorQuality::not_configured);
  snapshot.predicted_K.fill(not_a_value);
  snapshot.uncorrected_K.fill(not_a_value);
  snapshot.part_maximum_K.fill(not_a_value);
  snapshot.deformation_m.fill(not_a_value);
  snapshot.heat_factor.fill(not_a_value);
  snapshot.conductance_factor.fill(not_a_value);
  return snapshot;
}

void publish_inputs(const SensedInputs& sensed, const Judgement& judgement, Snapshot& snapshot) {
  snapshot.data_age_s = judgement.data_age_s;
  snapshot.sensor_quality = judgement.sensors;
  snapshot.signals = judgement.signals;
  for (std::size_t k = 0; k < snapshot.key_points; ++k) {
    const bool configured = judgement.sensors[k] != SensorQuality::not_configured;
    snapshot.measured_K[k] = configured ? sensed.sensors[k].value : not_a_value;
  }
}

void publish_corrected(const Model& model, Snapshot& snapshot) {
  copy(model.outputs.key_points_K, snapshot.predicted_K);
  copy(model.outputs.part_maximum_K, snapshot.part_maximum_K);
  copy(model.outputs.deformations_m, snapshot.deformation_m);
  snapshot.nose_m = snapshot.deformation_m[0] - snapshot.tare_m;
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
  snapshot.correction_configured = corrector.law.has_value();
  snapshot.correction_enabled = corrector.law.has_value() && corrector.enabled;
  snapshot.correction_count = corrector.corrections;
  snapshot.correction_freeze = corrector.law ? static_cast<std::uint16_t>(corrector.law->freeze(0)) : std::uint16_t{0};
}

}  // namespace spindle_twin::firmware
