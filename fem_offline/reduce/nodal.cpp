#include "fem_offline/reduce/nodal.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace spindle_twin::fem_offline {
namespace {

constexpr double largest_entry = 1.2;
constexpr int most_swaps = 500;

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
  const Eigen::VectorXd singular = Eigen::BDCSVD<Eigen::MatrixXd>(nodal.at_nodes).singularValues();
  nodal.condition = singular[0] / singular[count - 1];

  // Rounding, a few 1e-15: without it a uniform temperature would not be uniform to the last digit.
  nodal.interpolant.array().colwise() /= nodal.interpolant.rowwise().sum().array().eval();
  for (Eigen::Index i = 0; i < count; ++i) {
    nodal.interpolant.row(nodal.nodes[static_cast<std::size_t>(i)]) = Eigen::RowVectorXd::Unit(count, i);
  }
  return nodal;
}

}  // namespace spindle_twin::fem_offline
