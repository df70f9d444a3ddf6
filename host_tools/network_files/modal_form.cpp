#include "host_tools/network_files/modal_form.hpp"

#include <Eigen/Eigenvalues>
#include <stdexcept>
#include <string>

namespace spindle_twin::host_tools {

ModalForm modal_form(const rom::Network& network, const Eigen::VectorXd& conductance_W_per_m2K) {
  Eigen::MatrixXd conduction = network.conduction_W_per_K;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    const Eigen::MatrixXd& factor = network.factors_m[j];
    conduction += conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * factor * factor.transpose();
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(conduction, network.capacity_J_per_K);
  if (modes.info() != Eigen::Success) throw std::runtime_error("the capacity matrix is not positive definite");
  const Eigen::MatrixXd& shapes = modes.eigenvectors();

  ModalForm form{network, modes.eigenvalues(), {}};
  const Eigen::Index count = form.rates_per_s.size();
  form.uniform = shapes.transpose() * network.capacity_J_per_K.rowwise().sum();
  rom::Network& modal = form.network;
  modal.capacity_J_per_K = Eigen::MatrixXd::Identity(count, count);
  modal.conduction_W_per_K = form.rates_per_s.asDiagonal();
  modal.source_distribution = shapes.transpose() * network.source_distribution;
  for (Eigen::MatrixXd& factor : modal.factors_m) factor = shapes.transpose() * factor;
  const auto in_modes = [&](Eigen::VectorXd& row) { row = shapes.transpose() * row; };
  for (rom::KeyPoint& point : modal.key_points) in_modes(point.row);
  for (rom::PartOutput& part : modal.parts) {
    in_modes(part.mean_row);
    part.candidate_rows = part.candidate_rows * shapes;
  }
  for (rom::DeformationOutput& output : modal.deformations) in_modes(output.row_m_per_K);
  for (rom::ContactPressureOutput& output : modal.contact_pressures) in_modes(output.row_Pa_per_K);
  for (Eigen::Index i = 0; i < count; ++i) {
    modal.nodes[static_cast<std::size_t>(i)] = {"mode " + std::to_string(i + 1), {}, 0.0, 0.0};
  }
  return form;
}

}  // namespace spindle_twin::host_tools
