#include "fem_offline/sparse/symmetric_product.hpp"

#include <stdexcept>

#include "fem_offline/sparse/cholmod_view.hpp"

namespace spindle_twin::fem_offline {

Eigen::MatrixXd symmetric_product(const SparseMatrix& lower, const Eigen::MatrixXd& columns) {
  if (columns.cols() < 2) return lower.selfadjointView<Eigen::Lower>() * columns;
  // CHOLMOD reads the matrix once for four columns, Eigen for each.
  Eigen::MatrixXd result(columns.rows(), columns.cols());
  cholmod_sparse matrix = view_of(lower);
  cholmod_dense given = view_of(columns.data(), columns.rows(), columns.cols());
  cholmod_dense wanted = view_of(result.data(), result.rows(), result.cols());
  double one[] = {1.0, 0.0}, zero[] = {0.0, 0.0};
  cholmod_common settings;
  cholmod_start(&settings);
  settings.print = 0;
  const bool done = cholmod_sdmult(&matrix, 0, one, zero, &given, &wanted, &settings) != 0;
  cholmod_finish(&settings);
  if (!done) throw std::runtime_error("CHOLMOD could not multiply: no memory");
  return result;
}

}  // namespace spindle_twin::fem_offline
