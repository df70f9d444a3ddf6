#include "firmware/cycle/correct.hpp"

#include "correction/boundaries/evaluate_boundaries.hpp"

namespace spindle_twin::firmware {

Corrector make_corrector(const rom::Network& network, const CyclePlan& plan, const MakeStepper& make_stepper) {
  Corrector corrector;
  corrector.none = correction::no_correction(network.boundaries);
  const auto key_points = static_cast<Eigen::Index>(network.key_points.size());
  corrector.measured_K = Eigen::VectorXd::Constant(key_points, not_a_value);
  corrector.valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(key_points, false);
  corrector.enabled = plan.correction_enabled && plan.paper.has_value();
  if (plan.paper) corrector.law.emplace(network, *plan.paper, [&] { return make_stepper(network); });
  return corrector;
}

const rom::CorrectionFactors& correct(const SensedInputs& sensed, const Judgement& judgement,
                                      const rom::OperatingState& operating, double time_s, double advance_s,
                                      Model& model, Corrector& corrector) {
  if (!corrector.law) return corrector.none;
  if (!corrector.enabled) {
    corrector.law->stand_by(time_s, model.stepper->temperatures_K(), operating, advance_s);
    return corrector.law->factors();
  }
  for (Eigen::Index k = 0; k < corrector.measured_K.size(); ++k) {
    const auto sensor = static_cast<std::size_t>(k);
    corrector.measured_K[k] = sensed.sensors[sensor].value;
    corrector.valid[k] = judgement.sensors[sensor] == SensorQuality::good;
  }
  const correction::PaperStep step =
      corrector.law->step({time_s, corrector.measured_K, corrector.valid, model.outputs.key_points_K,
                           model.stepper->temperatures_K(), operating},
                          advance_s);
  if (step.corrected) ++corrector.corrections;
  if (step.state_rescaled) model.stepper->set_temperatures(corrector.law->rescaled_nodes_K());
  return corrector.law->factors();
}

}  // namespace spindle_twin::firmware
