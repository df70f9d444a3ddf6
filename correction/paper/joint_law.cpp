#include "correction/paper/joint_law.hpp"

#include <algorithm>
#include <cmath>

#include "rom/laws/interference_fit.hpp"

namespace spindle_twin::correction {

double joint_resistance_ratio(const rom::JointFit& fit, double inner_rise_K, double outer_rise_K, double exponent,
                              double minimum, double maximum) {
  const double pressure_change_Pa =
      fit.pressure_per_inner_rise_Pa_per_K * inner_rise_K - fit.pressure_per_outer_rise_Pa_per_K * outer_rise_K;
  const double pressure_ratio = 1.0 + pressure_change_Pa / fit.assembly_pressure_Pa;
  if (pressure_ratio <= 0.0) return maximum;
  const auto ratio = rom::pressure_resistance_ratio(rom::LawMode::as_published, pressure_ratio, 1.0, exponent);
  return std::clamp(ratio.value, minimum, maximum);
}

JointLaw::JointLaw(const rom::Network& network)
    : network_(&network),
      part_shift_K_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.parts.size()))),
      part_sensors_(Eigen::VectorXi::Zero(part_shift_K_.size())) {
  for (const rom::KeyPoint& point : network.key_points) {
    const auto part = std::find_if(network.parts.begin(), network.parts.end(),
                                   [&](const rom::PartOutput& output) { return output.name == point.part; });
    part_of_key_point_.push_back(part == network.parts.end() ? -1 : static_cast<int>(part - network.parts.begin()));
  }
}

bool JointLaw::correct(const PaperOptions& options, const MeasuringWindow& window, const Eigen::VectorXd& nodes_K,
                       rom::CorrectionFactors& factors) {
  const PaperGuards& guards = options.guards;
  shift_parts_by_sensors(window);
  bool moved = false;
  const auto& conductances = network_->boundaries.conductances;
  for (std::size_t j = 0; j < conductances.size(); ++j) {
    const rom::Conductance& joint = conductances[j];
    if (!joint.fit || joint.part_a < 0 || joint.part_b < 0) continue;
    const double wanted =
        1.0 / joint_resistance_ratio(*joint.fit, rise_K(joint.part_a, nodes_K), rise_K(joint.part_b, nodes_K),
                                     options.joint_exponent, guards.resistance_minimum, guards.resistance_maximum);
    double& factor = factors.conductance[static_cast<Eigen::Index>(j)];
    const double limited = std::clamp(wanted, factor / guards.resistance_step, factor * guards.resistance_step);
    if (!std::isfinite(limited) || limited == factor) continue;
    factor = limited;
    moved = true;
  }
  return moved;
}

void JointLaw::shift_parts_by_sensors(const MeasuringWindow& window) {
  part_shift_K_.setZero();
  part_sensors_.setZero();
  for (std::size_t k = 0; k < part_of_key_point_.size(); ++k) {
    const auto key_point = static_cast<Eigen::Index>(k);
    const int part = part_of_key_point_[k];
    if (part < 0 || !window.is_complete(key_point)) continue;
    part_shift_K_[part] += window.residual_K(key_point);
    ++part_sensors_[part];
  }
  part_shift_K_.array() /= part_sensors_.array().max(1).cast<double>();
}

double JointLaw::rise_K(int part, const Eigen::VectorXd& nodes_K) const {
  return network_->parts[static_cast<std::size_t>(part)].mean_row.dot(nodes_K) + part_shift_K_[part] -
         network_->boundaries.reference_temperature_K;
}

}  // namespace spindle_twin::correction
