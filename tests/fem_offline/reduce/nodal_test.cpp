#include "fem_offline/reduce/nodal.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>

namespace spindle_twin::fem_offline {
namespace reduce_nodal_test {

/// Orthonormal basis of cosines on a line of points; column 0 is the constant.
Eigen::MatrixXd cosine_basis(int points, int columns) {
  Eigen::MatrixXd basis(points, columns);
  for (int i = 0; i < points; ++i) {
    for (int k = 0; k < columns; ++k) basis(i, k) = std::cos(M_PI * k * (i + 0.5) / points);
  }
  basis.colwise().normalize();
  return basis;
}

TEST(NodalCoordinates, state_is_the_field_at_the_node_for_every_field_of_the_span) {
  const Eigen::MatrixXd basis = cosine_basis(400, 25);
  const NodalCoordinates nodal = choose_nodes(basis, 2);
  const Eigen::VectorXd field = basis * Eigen::VectorXd::LinSpaced(25, -3.0, 8.0);
  const Eigen::VectorXd states = field(nodal.nodes);
  EXPECT_LE((nodal.interpolant * states - field).cwiseAbs().maxCoeff(), 1e-12 * field.cwiseAbs().maxCoeff());
  EXPECT_EQ(nodal.interpolant(nodal.nodes, Eigen::all), Eigen::MatrixXd::Identity(25, 25));
}

TEST(NodalCoordinates, constant_is_exact_and_nothing_is_amplified) {
  const NodalCoordinates nodal = choose_nodes(cosine_basis(400, 25), 1);
  EXPECT_LE((nodal.interpolant.rowwise().sum().array() - 1.0).abs().maxCoeff(), 4e-15);
  EXPECT_LE(nodal.interpolant.cwiseAbs().maxCoeff(), 1.2 + 1e-9);
  EXPECT_LT(nodal.condition, 100.0);
}

TEST(NodalCoordinates, are_the_same_to_the_bit_on_any_number_of_threads) {
  const Eigen::MatrixXd basis = cosine_basis(3000, 40);
  const NodalCoordinates one = choose_nodes(basis, 1), three = choose_nodes(basis, 3);
  EXPECT_EQ(one.nodes, three.nodes);
  EXPECT_EQ(one.interpolant, three.interpolant);
}

}  // namespace reduce_nodal_test
}  // namespace spindle_twin::fem_offline
