#include "fem_offline/sparse/symmetric_product.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace spindle_twin::fem_offline {
namespace sparse_symmetric_product_test {

/// Lower triangle: a band, and a row that every column has an entry in.
SparseMatrix banded_matrix(int size) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < size; ++i) {
    entries.emplace_back(i, i, 4.0 + 0.1 * i);
    if (i + 3 < size) entries.emplace_back(i + 3, i, std::sin(i));
    if (i + 4 < size) entries.emplace_back(size - 1, i, 0.5);
  }
  SparseMatrix lower(size, size);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

TEST(SymmetricProduct, of_the_lower_triangle_is_that_of_the_whole_matrix) {
  const SparseMatrix lower = banded_matrix(141);
  const Eigen::MatrixXd whole = Eigen::MatrixXd(SparseMatrix(lower.selfadjointView<Eigen::Lower>()));
  for (const Eigen::Index columns : {0, 1, 2, 5}) {
    const Eigen::MatrixXd x = Eigen::MatrixXd::NullaryExpr(
        lower.rows(), columns, [](Eigen::Index i, Eigen::Index j) { return std::cos(static_cast<double>(i + 3 * j)); });
    EXPECT_LE((symmetric_product(lower, x) - whole * x).norm(), 1e-12) << columns;
  }
}

}  // namespace sparse_symmetric_product_test
}  // namespace spindle_twin::fem_offline
