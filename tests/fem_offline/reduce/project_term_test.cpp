// Terms of the FE model on a basis, and factors of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "fem_offline/reduce/basis.hpp"
#include "grid_model.hpp"

namespace spindle_twin::fem_offline {
namespace reduce_project_term_test {

Eigen::MatrixXd random_basis(const AffineModel& model, Eigen::Index columns) {
  std::srand(5);
  return Eigen::MatrixXd::Random(model.capacity_J_per_K.rows(), columns);
}

Eigen::MatrixXd dense_product(const SparseMatrix& term, const Eigen::MatrixXd& basis) {
  return basis.transpose() * Eigen::MatrixXd(term) * basis;
}

int touched(const SparseMatrix& term) {
  int count = 0;
  for (int column = 0; column < term.outerSize(); ++column) {
    if (SparseMatrix::InnerIterator(term, column)) ++count;
  }
  return count;
}

TEST(ProjectTerm, is_the_dense_product_and_symmetric_to_the_bit) {
  const AffineModel model = make_grid_model();
  const Eigen::MatrixXd basis = random_basis(model, 70);
  for (const SparseMatrix* term :
       {&model.capacity_J_per_K, &model.conduction_W_per_K, &model.conductance_terms_m2[0]}) {
    const Eigen::MatrixXd projected = project_term(*term, basis), expected = dense_product(*term, basis);
    EXPECT_LT((projected - expected).norm(), 1e-12 * expected.norm());
    EXPECT_EQ(projected, Eigen::MatrixXd(projected.transpose()));
  }
}

TEST(ProjectTerm, factor_times_its_transposed_is_the_term_where_it_touches_fewer_unknowns_than_nodes_and_more) {
  const AffineModel model = make_grid_model();
  for (const Eigen::Index columns : {5, 70}) {
    const Eigen::MatrixXd basis = random_basis(model, columns);
    int fewer = 0, more = 0;
    for (const SparseMatrix& term : model.conductance_terms_m2) {
      ++(touched(term) < columns ? fewer : more);
      const Eigen::MatrixXd factor = project_term_factor(term, basis), expected = dense_product(term, basis);
      EXPECT_LT((factor * factor.transpose() - expected).norm(), 1e-11 * expected.norm());
      EXPECT_LE(factor.cols(), std::min<Eigen::Index>(touched(term), columns));
    }
    EXPECT_GT(columns == 5 ? more : fewer, 0);
  }
}

}  // namespace reduce_project_term_test
}  // namespace spindle_twin::fem_offline
