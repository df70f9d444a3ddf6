#include "rom/integrate/outputs.hpp"

#include <algorithm>

namespace spindle_twin::rom {

NetworkOutputs make_network_outputs(const Network& network) {
  const auto parts = static_cast<Eigen::Index>(network.parts.size());
  Eigen::Index candidates = 0;
  for (const PartOutput& part : network.parts) candidates = std::max(candidates, part.candidate_rows.rows());
  NetworkOutputs outputs;
  outputs.key_points_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.key_points.size()));
  outputs.part_mean_K = outputs.part_maximum_K = outputs.part_minimum_K = Eigen::VectorXd::Zero(parts);
  outputs.deformations_m = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.deformations.size()));
  outputs.contact_pressures_Pa = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.contact_pressures.size()));
  outputs.candidates_K = Eigen::VectorXd::Zero(candidates);
  return outputs;
}

void evaluate_outputs(const Network& network, const Eigen::VectorXd& temperatures_K, NetworkOutputs& outputs,
                      double expansion) {
  for (Eigen::Index i = 0; i < outputs.key_points_K.size(); ++i) {
    outputs.key_points_K[i] = network.key_points[static_cast<std::size_t>(i)].row.dot(temperatures_K);
  }
  for (Eigen::Index i = 0; i < outputs.part_mean_K.size(); ++i) {
    const PartOutput& part = network.parts[static_cast<std::size_t>(i)];
    outputs.part_mean_K[i] = part.mean_row.dot(temperatures_K);
    auto candidates = outputs.candidates_K.head(part.candidate_rows.rows());
    candidates.noalias() = part.candidate_rows * temperatures_K;
    outputs.part_maximum_K[i] = candidates.maxCoeff();
    outputs.part_minimum_K[i] = candidates.minCoeff();
  }
  for (Eigen::Index i = 0; i < outputs.deformations_m.size(); ++i) {
    const Eigen::VectorXd& row = network.deformations[static_cast<std::size_t>(i)].row_m_per_K;
    outputs.deformations_m[i] =
        expansion * (row.dot(temperatures_K) - row.sum() * network.boundaries.reference_temperature_K);
  }
  for (Eigen::Index i = 0; i < outputs.contact_pressures_Pa.size(); ++i) {
    const ContactPressureOutput& output = network.contact_pressures[static_cast<std::size_t>(i)];
    outputs.contact_pressures_Pa[i] = output.assembly_pressure_Pa + output.row_Pa_per_K.dot(temperatures_K) -
                                      output.row_Pa_per_K.sum() * network.boundaries.reference_temperature_K;
  }
}

}  // namespace spindle_twin::rom
