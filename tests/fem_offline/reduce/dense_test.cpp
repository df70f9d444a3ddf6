// Dense products and factors on OpenBLAS against Eigen's, and the factor of a model with coolant circuits.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <set>

#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/dense_model.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_dense_test {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::srand(seed);
  return Eigen::MatrixXd::Random(rows, columns);
}

Eigen::MatrixXd random_definite(Eigen::Index size, unsigned seed) {
  const Eigen::MatrixXd root = random_matrix(size, size, seed);
  return root * root.transpose() + Eigen::MatrixXd::Identity(size, size);
}

TEST(DenseProducts, are_those_of_eigen_also_of_blocks_and_of_nothing) {
  const Eigen::MatrixXd a = random_matrix(40, 31, 1), b = random_matrix(31, 17, 2), c = random_matrix(40, 9, 3);
  EXPECT_LT((product(a, b) - a * b).norm(), 1e-12);
  EXPECT_LT((transposed_product(a, c) - a.transpose() * c).norm(), 1e-12);
  EXPECT_LT((product(a.middleRows(5, 20), b.leftCols(4)) - a.middleRows(5, 20) * b.leftCols(4)).norm(), 1e-12);
  EXPECT_EQ(product(a.leftCols(0), b.topRows(0)), Eigen::MatrixXd::Zero(40, 17));
  EXPECT_EQ(transposed_product(a.leftCols(0), c).rows(), 0);
}

TEST(PackedSymmetric, gives_back_the_matrix_whose_lower_triangle_it_has_kept) {
  const Eigen::MatrixXd matrix = random_definite(7, 11);
  Eigen::MatrixXd spoilt_above = matrix;
  spoilt_above.triangularView<Eigen::StrictlyUpper>().setConstant(-1.0);
  const PackedSymmetric packed(spoilt_above);
  const Eigen::MatrixXd lower = matrix.triangularView<Eigen::Lower>();
  EXPECT_EQ(packed.whole(), Eigen::MatrixXd(lower.selfadjointView<Eigen::Lower>()));
  for (Eigen::Index c = 0; c < 7; ++c) EXPECT_EQ(Eigen::VectorXd(packed.column(c)), lower.col(c).tail(7 - c)) << c;
  EXPECT_EQ(PackedSymmetric(Eigen::MatrixXd(0, 0)).whole().size(), 0);
}

TEST(DenseCholesky, solves_and_refuses_what_is_not_definite) {
  const Eigen::MatrixXd matrix = random_definite(60, 4), loads = random_matrix(60, 5, 5);
  EXPECT_LT((matrix * DenseCholesky(matrix, "it").solve(loads) - loads).norm(), 1e-9);
  Eigen::MatrixXd indefinite = matrix;
  indefinite(30, 30) = -1.0;
  EXPECT_THROW(DenseCholesky(indefinite, "it"), std::runtime_error);
}

TEST(PivotRows, are_distinct_and_independent) {
  const Eigen::MatrixXd columns = random_matrix(200, 12, 6);
  const Eigen::VectorXi rows = pivot_rows(columns);
  EXPECT_EQ(std::set<int>(rows.begin(), rows.end()).size(), 12u);
  const Eigen::MatrixXd interpolant = columns * Eigen::MatrixXd(columns(rows, Eigen::all)).inverse();
  EXPECT_LT(interpolant.cwiseAbs().maxCoeff(), 20.0);
}

TEST(ShiftedModel, solves_with_what_the_coolant_carries_and_with_its_transpose) {
  DenseModel model;
  model.capacity = random_definite(30, 7);
  HeldModel held{random_definite(30, 8), random_matrix(30, 3, 9), random_matrix(30, 3, 10), {}, {}};
  const double rate_per_s = 0.3;
  const Eigen::MatrixXd whole = held.conduction + rate_per_s * model.capacity - held.carried * held.walls.transpose();
  const ShiftedModel shifted(model, held, rate_per_s);
  const Eigen::MatrixXd loads = random_matrix(30, 4, 11);
  EXPECT_LT((whole * shifted.solve(loads.col(0)) - loads.col(0)).norm(), 1e-9);
  EXPECT_LT((whole.transpose() * shifted.solve_transposed(loads) - loads).norm(), 1e-9);
}

}  // namespace reduce_dense_test
}  // namespace spindle_twin::fem_offline
