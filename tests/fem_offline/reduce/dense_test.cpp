// Dense products and factors on OpenBLAS against Eigen's, and the factor of a model with coolant circuits.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <set>
#include <vector>

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
  const Eigen::MatrixXf single = product(a.cast<float>(), b.cast<float>());
  EXPECT_LT((single.cast<double>() - a * b).norm(), 1e-4);
}

TEST(DenseProducts, with_the_transposed_one_is_symmetric_to_the_bit) {
  const Eigen::MatrixXd a = random_matrix(40, 31, 4);
  const Eigen::MatrixXd square = product_with_transposed(a.middleRows(3, 20));
  EXPECT_LT((square - a.middleRows(3, 20) * a.middleRows(3, 20).transpose()).norm(), 1e-12);
  EXPECT_EQ(square, square.transpose());
  EXPECT_EQ(product_with_transposed(a.leftCols(0)), Eigen::MatrixXd::Zero(40, 40));
}

TEST(DivideByUpper, times_the_triangle_gives_the_matrix_back) {
  const Eigen::MatrixXd before = random_matrix(23, 9, 5), upper = random_definite(9, 6);
  Eigen::MatrixXd x = before;
  divide_by_upper(x, upper);  // what stands below the diagonal does not count
  EXPECT_LT((x * Eigen::MatrixXd(upper.triangularView<Eigen::Upper>()) - before).norm(), 1e-12);
}

TEST(PackedTerms, keep_lower_triangles_and_add_them_up_by_their_weights) {
  PackedTerms terms(7, 3);
  std::vector<Eigen::MatrixXd> whole;
  for (Eigen::Index j = 0; j < 3; ++j) {
    whole.push_back(random_definite(7, static_cast<unsigned>(11 + j)));
    Eigen::MatrixXd spoilt_above = whole.back();
    spoilt_above.triangularView<Eigen::StrictlyUpper>().setConstant(-1.0);
    terms.set(j, spoilt_above);
  }
  for (Eigen::Index c = 0; c < 7; ++c) {
    EXPECT_EQ(Eigen::VectorXd(terms.column(1, c)), whole[1].col(c).tail(7 - c)) << c;
  }
  Eigen::MatrixXd weights(3, 2);
  weights << 1.0, 0.0, -2.0, 0.5, 3.0, 4.0;
  const PackedTerms sums = terms.sums(weights);
  ASSERT_EQ(sums.count(), 2);
  for (Eigen::Index i = 0; i < 2; ++i) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Constant(7, 7, 10.0), wanted = sum;
    sums.add_to_lower(i, sum);
    for (Eigen::Index j = 0; j < 3; ++j) wanted += weights(j, i) * whole[static_cast<std::size_t>(j)];
    wanted.triangularView<Eigen::StrictlyUpper>().setConstant(10.0);
    EXPECT_LT((sum - wanted).cwiseAbs().maxCoeff(), 1e-13) << i;
  }
  EXPECT_EQ(PackedTerms(7, 0).sums(Eigen::MatrixXd(0, 2)).count(), 2);
}

TEST(FirstStates, are_the_model_projected_on_the_first_columns_of_its_basis) {
  DenseModel model;
  model.capacity = random_definite(7, 21);
  model.conduction = random_definite(7, 22);
  model.walls_m2 = random_matrix(7, 2, 23);
  model.source_distribution = random_matrix(7, 3, 24);
  model.uniform = random_matrix(7, 1, 25);
  model.conductance_terms = PackedTerms(7, 2);
  const std::vector<Eigen::MatrixXd> terms = {random_definite(7, 26), random_definite(7, 27)};
  for (Eigen::Index j = 0; j < 2; ++j) model.conductance_terms.set(j, terms[static_cast<std::size_t>(j)]);
  const DenseModel first = first_states(model, 4);
  EXPECT_EQ(first.capacity, model.capacity.topLeftCorner(4, 4));
  EXPECT_EQ(first.conduction, model.conduction.topLeftCorner(4, 4));
  EXPECT_EQ(first.walls_m2, model.walls_m2.topRows(4));
  EXPECT_EQ(first.source_distribution, model.source_distribution.topRows(4));
  EXPECT_EQ(first.uniform, model.uniform.head(4));
  ASSERT_EQ(first.conductance_terms.count(), 2);
  for (Eigen::Index j = 0; j < 2; ++j) {
    for (Eigen::Index c = 0; c < 4; ++c) {
      const Eigen::VectorXd whole = terms[static_cast<std::size_t>(j)].col(c);
      EXPECT_EQ(Eigen::VectorXd(first.conductance_terms.column(j, c)), whole.segment(c, 4 - c)) << j << c;
    }
  }
}

TEST(HoldConductances, of_one_of_many_sums_is_what_hold_inputs_makes_of_a_model_without_inputs) {
  DenseModel model;
  model.capacity = model.conduction = random_definite(9, 14);
  model.conductance_terms = PackedTerms(9, 2);
  for (Eigen::Index j = 0; j < 2; ++j)
    model.conductance_terms.set(j, random_definite(9, static_cast<unsigned>(15 + j)));
  model.walls_m2 = random_matrix(9, 2, 17);
  model.source_distribution = random_matrix(9, 1, 18);
  rom::Boundaries boundaries;
  boundaries.conductances.resize(2);
  boundaries.conductances[1].environment = 0;
  rom::BoundaryValues values;
  values.heat_W = Eigen::VectorXd::Constant(1, 3.0);
  values.environment_K = Eigen::VectorXd::Constant(1, 295.0);
  const Eigen::MatrixXd conductances = random_matrix(2, 3, 19).cwiseAbs();
  const PackedTerms sums = model.conductance_terms.sums(conductances);
  for (Eigen::Index i = 0; i < 3; ++i) {
    values.conductance_W_per_m2K = conductances.col(i);
    HeldModel alone;
    hold_inputs(model, boundaries, {}, values, 293.0, alone);
    HeldModel held = hold_conductances(model, sums, i, conductances.col(i));
    hold_inputs(model, boundaries, {}, values, 293.0, held);
    const Eigen::MatrixXd difference = alone.conduction - held.conduction;
    EXPECT_LT(Eigen::MatrixXd(difference.triangularView<Eigen::Lower>()).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_EQ(alone.drive, held.drive);
    EXPECT_EQ(alone.contained_W_per_m2K, held.contained_W_per_m2K);
  }
}

TEST(SymmetricModes, give_the_matrix_back_smallest_value_first) {
  const Eigen::MatrixXd matrix = random_definite(40, 20);
  Eigen::MatrixXd spoilt_above = matrix;
  spoilt_above.triangularView<Eigen::StrictlyUpper>().setConstant(7.0);
  const SymmetricModes modes = symmetric_modes(spoilt_above);
  EXPECT_LT((modes.vectors * modes.values.asDiagonal() * modes.vectors.transpose() - matrix).norm(), 1e-11);
  EXPECT_LT((modes.vectors.transpose() * modes.vectors - Eigen::MatrixXd::Identity(40, 40)).norm(), 1e-12);
  EXPECT_TRUE(std::is_sorted(modes.values.begin(), modes.values.end()));
  EXPECT_EQ(symmetric_modes(Eigen::MatrixXd(0, 0)).values.size(), 0);
  Eigen::MatrixXd broken = matrix;
  broken(20, 10) = std::nan("");
  EXPECT_THROW(symmetric_modes(broken), std::runtime_error);
}

TEST(RealModes, of_a_turning_matrix_come_in_pairs_of_real_and_imaginary_part) {
  const Eigen::MatrixXd matrix = random_matrix(15, 15, 21);
  const RealModes modes = real_modes(matrix);
  int pairs = 0;
  for (Eigen::Index k = 0; k < 15; ++k) {
    if (modes.imaginary[k] == 0.0) {
      EXPECT_LT((matrix * modes.vectors.col(k) - modes.real[k] * modes.vectors.col(k)).norm(), 1e-12);
      continue;
    }
    const Eigen::VectorXcd vector = modes.vectors.col(k) + std::complex(0.0, 1.0) * modes.vectors.col(k + 1);
    const std::complex value(modes.real[k], modes.imaginary[k]);
    EXPECT_LT((matrix * vector - value * vector).norm(), 1e-12);
    ++pairs, ++k;
  }
  EXPECT_GT(pairs, 2);
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
