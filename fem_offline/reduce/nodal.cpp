#include "fem_offline/reduce/nodal.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/most_independent.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double largest_entry = 1.2;
constexpr int most_swaps = 500;

/// Largest over smallest singular value, from the eigenvalues of the square: nothing beyond 1/sqrt(epsilon) is told
/// apart.
double condition_of(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd eigenvalues = symmetric_modes(transposed_product(matrix, matrix)).values;
  const double largest = eigenvalues[eigenvalues.size() - 1];
  return std::sqrt(largest / std::max(eigenvalues[0], std::numeric_limits<double>::epsilon() * largest));
}

/// V · (rows of V at the nodes)⁻¹, by blocks of rows.
Eigen::MatrixXd interpolant_of(const Eigen::MatrixXd& basis, const std::vector<int>& nodes, int threads) {
  constexpr Eigen::Index rows_per_block = 1024;
  const Eigen::MatrixXd from_nodes = Eigen::MatrixXd(basis(nodes, Eigen::all)).inverse();
  Eigen::MatrixXd interpolant(basis.rows(), basis.cols());
  const int blocks = static_cast<int>((basis.rows() + rows_per_block - 1) / rows_per_block);
  for_each_index(blocks, threads, [&](int block, int) {
    const Eigen::Index first = block * rows_per_block, height = std::min(rows_per_block, basis.rows() - first);
    interpolant.middleRows(first, height) = product(basis.middleRows(first, height), from_nodes);
  });
  return interpolant;
}

/// Swaps nodes until no entry of the interpolant is above largest_entry, nor more than most_swaps times.
void swap_nodes(Eigen::MatrixXd& interpolant, std::vector<int>& nodes, int threads) {
  constexpr Eigen::Index columns_swapped_at_once = 16;
  const Eigen::Index count = interpolant.cols();
  const int blocks = static_cast<int>((count + columns_swapped_at_once - 1) / columns_swapped_at_once);
  Eigen::VectorXd largest = interpolant.cwiseAbs().colwise().maxCoeff().transpose();
  for (int swap = 0; swap < most_swaps; ++swap) {
    Eigen::Index row = 0, column = 0;
    if (largest.maxCoeff(&column) <= largest_entry) break;
    interpolant.col(column).cwiseAbs().maxCoeff(&row);
    // Rank-one exchange of node `column` for unknown `row`.
    const Eigen::VectorXd old_column = interpolant.col(column);
    Eigen::RowVectorXd change = interpolant.row(row);
    const double pivot = change[column];
    change[column] -= 1.0;
    change /= pivot;
    for_each_index(blocks, threads, [&](int block, int) {
      const Eigen::Index first = block * columns_swapped_at_once,
                         end = std::min(first + columns_swapped_at_once, count);
      for (Eigen::Index i = first; i < end; ++i) {
        interpolant.col(i) -= change[i] * old_column;
        largest[i] = interpolant.col(i).cwiseAbs().maxCoeff();
      }
    });
    nodes[static_cast<std::size_t>(column)] = static_cast<int>(row);
  }
}

}  // namespace

NodalCoordinates choose_nodes(const Eigen::MatrixXd& orthonormal_basis, int threads) {
  const Eigen::Index count = orthonormal_basis.cols();
  NodalCoordinates nodal;
  nodal.nodes = most_independent_rows(orthonormal_basis, count, threads);
  if (std::ssize(nodal.nodes) < count) throw std::runtime_error("the basis' columns are dependent");
  nodal.interpolant = interpolant_of(orthonormal_basis, nodal.nodes, threads);
  swap_nodes(nodal.interpolant, nodal.nodes, threads);
  std::sort(nodal.nodes.begin(), nodal.nodes.end());
  nodal.interpolant = interpolant_of(orthonormal_basis, nodal.nodes, threads);
  nodal.at_nodes = orthonormal_basis(nodal.nodes, Eigen::all);
  nodal.condition = condition_of(nodal.at_nodes);

  // Rounding, a few 1e-15: without it a uniform temperature would not be uniform to the last digit.
  nodal.interpolant.array().colwise() /= nodal.interpolant.rowwise().sum().array().eval();
  for (Eigen::Index i = 0; i < count; ++i) {
    nodal.interpolant.row(nodal.nodes[static_cast<std::size_t>(i)]) = Eigen::RowVectorXd::Unit(count, i);
  }
  return nodal;
}

}  // namespace spindle_twin::fem_offline
