#include "fem_offline/reduce/nodal.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace spindle_twin::fem_offline {
namespace {

constexpr double largest_entry = 1.2;
constexpr int most_swaps = 500;

/// Largest over smallest singular value, from the eigenvalues of the square: nothing beyond 1/sqrt(epsilon) is told
/// apart.
double condition_of(const Eigen::MatrixXd& matrix) {
  const Eigen::MatrixXd square = matrix.transpose() * matrix;
  const Eigen::VectorXd eigenvalues =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(square, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = eigenvalues[eigenvalues.size() - 1];
  return std::sqrt(largest / std::max(eigenvalues[0], std::numeric_limits<double>::epsilon() * largest));
}

}  // namespace

NodalCoordinates choose_nodes(const Eigen::MatrixXd& orthonormal_basis) {
  const Eigen::Index count = orthonormal_basis.cols();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivoted(orthonormal_basis.transpose());
  const auto& order = pivoted.colsPermutation().indices();
  NodalCoordinates nodal;
  nodal.nodes.assign(order.data(), order.data() + count);

  const auto interpolate = [&] {
    const Eigen::MatrixXd at_nodes = orthonormal_basis(nodal.nodes, Eigen::all);
    return Eigen::MatrixXd(at_nodes.transpose().partialPivLu().solve(orthonormal_basis.transpose()).transpose());
  };
  nodal.interpolant = interpolate();
  for (int swap = 0; swap < most_swaps; ++swap) {
    Eigen::Index row = 0, column = 0;
    const double largest = nodal.interpolant.cwiseAbs().maxCoeff(&row, &column);
    if (largest <= largest_entry) break;
    // Rank-one exchange of node `column` for unknown `row`.
    const Eigen::VectorXd old_column = nodal.interpolant.col(column);
    Eigen::RowVectorXd change = nodal.interpolant.row(row);
    const double pivot = change[column];
    change[column] -= 1.0;
    nodal.interpolant.noalias() -= old_column * (change / pivot);
    nodal.nodes[static_cast<std::size_t>(column)] = static_cast<int>(row);
  }
  std::sort(nodal.nodes.begin(), nodal.nodes.end());
  nodal.interpolant = interpolate();
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
