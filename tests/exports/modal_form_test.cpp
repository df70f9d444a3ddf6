#include "host_tools/network_files/modal_form.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::host_tools::tests {
namespace modal_form_test {

Eigen::MatrixXd conduction_at(const rom::Network& network, const Eigen::VectorXd& conductance_W_per_m2K) {
  Eigen::MatrixXd conduction = network.conduction_W_per_K;
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    conduction +=
        conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * network.factors_m[j] * network.factors_m[j].transpose();
  }
  return conduction;
}

/// Rises of the key points one implicit step of `step_s` after heats of 1 W of every source set in on a cold spindle.
Eigen::VectorXd response_K(const rom::Network& network, const Eigen::MatrixXd& conduction, double step_s) {
  const Eigen::MatrixXd matrix = conduction + network.capacity_J_per_K / step_s;
  const Eigen::VectorXd states = matrix.lu().solve(network.source_distribution.rowwise().sum());
  Eigen::VectorXd rises(static_cast<Eigen::Index>(network.key_points.size()));
  for (Eigen::Index i = 0; i < rises.size(); ++i)
    rises[i] = network.key_points[static_cast<std::size_t>(i)].row.dot(states);
  return rises;
}

TEST(ModalForm, outputs_are_those_of_the_network_also_at_other_conductances) {
  const rom::Network network = rom::tests::make_synthetic_network({}, 5);
  Eigen::VectorXd mean(static_cast<Eigen::Index>(network.factors_m.size()));
  for (Eigen::Index j = 0; j < mean.size(); ++j) {
    mean[j] = network.boundaries.conductances[static_cast<std::size_t>(j)].nominal_W_per_m2K;
  }
  const ModalForm modal = modal_form(network, mean);
  Eigen::VectorXd other = mean;
  other[0] *= 3.0;
  for (const double step_s : {1.0, 100.0, 1e4}) {
    const Eigen::VectorXd wanted = response_K(network, conduction_at(network, other), step_s);
    // Of the modal form the matrix has the mean already.
    const Eigen::VectorXd given = response_K(modal.network, conduction_at(modal.network, other - mean), step_s);
    ASSERT_GT(wanted.norm(), 0.0);
    EXPECT_LT((given - wanted).norm(), 1e-9 * wanted.norm()) << step_s;
  }
}

TEST(ModalForm, a_uniform_field_stays_one_kelvin_at_every_output) {
  const rom::Network network = rom::tests::make_synthetic_network({}, 6);
  const ModalForm modal =
      modal_form(network, Eigen::VectorXd::Ones(static_cast<Eigen::Index>(network.factors_m.size())));
  for (const rom::KeyPoint& point : modal.network.key_points) EXPECT_NEAR(point.row.dot(modal.uniform), 1.0, 1e-9);
  EXPECT_NEAR(modal.uniform.squaredNorm(), network.capacity_J_per_K.sum(), 1e-9 * network.capacity_J_per_K.sum());
}

}  // namespace modal_form_test
}  // namespace spindle_twin::host_tools::tests
