#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Weighted sum of squares of the dual snapshots relative to that of the fields.
constexpr double dual_share = 0.15;
/// Of the mean square over all unknowns beside that over the points.
constexpr double weight_of_mean = 1.0;
constexpr int weight_rounds = 3;
constexpr double most_change_of_weight = 2.0;
/// Parts are balanced at the size at which fields err so much, as a root mean square over the points.
constexpr double balanced_at_K = 0.01;
/// Largest error of a part: what one field in so many exceeds. The very largest is chance.
constexpr Eigen::Index one_field_in = 500;
constexpr Eigen::Index columns_per_block = 500;

/// Calls body(first, width) for blocks of columns; every block writes to a place of its own.
template <typename Body>
void for_each_block(Eigen::Index columns, int threads, const Body& body) {
  const int blocks = static_cast<int>((columns + columns_per_block - 1) / columns_per_block);
  for_each_index(blocks, threads, [&](int block, int) {
    const Eigen::Index first = block * columns_per_block;
    body(block, first, std::min(columns_per_block, columns - first));
  });
}

/// XXᵀ; the same bits for any number of threads.
Eigen::MatrixXd moments_of(const Eigen::MatrixXd& snapshots, int threads) {
  const Eigen::Index states = snapshots.rows();
  std::vector<Eigen::MatrixXd> sums(static_cast<std::size_t>(snapshots.cols() / columns_per_block + 1));
  for_each_block(snapshots.cols(), threads, [&](int block, Eigen::Index first, Eigen::Index width) {
    Eigen::MatrixXd& sum = sums[static_cast<std::size_t>(block)];
    sum = product_with_transposed(snapshots.middleCols(first, width));
  });
  Eigen::MatrixXd total = Eigen::MatrixXd::Zero(states, states);
  for (const Eigen::MatrixXd& sum : sums) {
    if (sum.size() > 0) total += sum;
  }
  return total;
}

struct Modes {
  Eigen::MatrixXd columns;     ///< orthonormal in the plain sense, nested
  Eigen::VectorXd left_after;  ///< weighted sum of squares that the first i + 1 columns leave
};

/// Columns that span the first `fixed` unit vectors, then with them the eigenvectors of M, largest first, each in the
/// inner product G = LLᵀ: x = L⁻ᵀu with u an eigenvector of LᵀML beside the fixed ones.
Modes nested_modes(const Eigen::MatrixXd& moments, const Eigen::MatrixXd& inner_product, Eigen::Index fixed) {
  const Eigen::Index states = moments.rows(), others = states - fixed;
  const Eigen::LLT<Eigen::MatrixXd> factor(inner_product);
  if (factor.info() != Eigen::Success) throw std::runtime_error("the snapshots' inner product is not definite");
  const Eigen::MatrixXd lower = factor.matrixL();
  const Eigen::HouseholderQR<Eigen::MatrixXd> fixed_columns(Eigen::MatrixXd(lower.transpose().leftCols(fixed)));
  const Eigen::MatrixXd beside = Eigen::MatrixXd(fixed_columns.householderQ()).rightCols(others);
  const Eigen::MatrixXd to_modes = product(lower, beside);
  const SymmetricModes found = symmetric_modes(transposed_product(to_modes, product(moments, to_modes)));
  Eigen::MatrixXd columns = Eigen::MatrixXd::Identity(states, states);
  columns.rightCols(others) = lower.transpose().triangularView<Eigen::Upper>().solve(
      product(beside, Eigen::MatrixXd(found.vectors.rowwise().reverse())));
  Modes modes;
  modes.columns = Eigen::HouseholderQR<Eigen::MatrixXd>(columns).householderQ();
  // The reflections leave the fixed unit vectors where they are, but for rounding and sign.
  modes.columns.leftCols(fixed).setIdentity();
  modes.columns.topRightCorner(fixed, others).setZero();
  modes.left_after = Eigen::VectorXd::Constant(states, found.values.sum());
  for (Eigen::Index i = 0; i < others; ++i) {
    modes.left_after[fixed + i] = found.values.head(others - 1 - i).sum();
  }
  return modes;
}

/// Largest error of every part when fields are projected on the basis.
Eigen::VectorXd largest_part_errors_K(const RichModel& rich, const Eigen::MatrixXd& fields,
                                      const Eigen::MatrixXd& basis, int threads) {
  const Eigen::Index parts = 1 + *std::max_element(rich.part_of_point.begin(), rich.part_of_point.end());
  Eigen::MatrixXd errors_K = Eigen::MatrixXd::Zero(parts, fields.cols());
  for_each_block(fields.cols(), threads, [&](int, Eigen::Index first, Eigen::Index width) {
    Eigen::MatrixXd left = fields.middleCols(first, width);
    left -= product(basis, transposed_product(basis, left));
    const Eigen::MatrixXd at_points_K = product(rich.points, left).cwiseAbs();
    for (std::size_t i = 0; i < rich.part_of_point.size(); ++i) {
      auto own = errors_K.row(rich.part_of_point[i]).segment(first, width);
      own = own.cwiseMax(at_points_K.row(static_cast<Eigen::Index>(i)));
    }
  });
  Eigen::VectorXd largest_K(parts);
  for (Eigen::Index part = 0; part < parts; ++part) {
    std::vector<double> values(errors_K.row(part).begin(), errors_K.row(part).end());
    const auto rank = values.begin() + fields.cols() / one_field_in;
    std::nth_element(values.begin(), rank, values.end(), std::greater<>());
    largest_K[part] = *rank;
  }
  return largest_K;
}

}  // namespace

Eigen::MatrixXd network_basis(const RichModel& rich, const RichSnapshots& snapshots, int threads) {
  const Eigen::Index fixed = rich.bodies, count = rich.points.rows(), others = count - fixed;
  const Eigen::MatrixXd fields = moments_of(snapshots.fields, threads);
  const Eigen::MatrixXd& duals = snapshots.dual_moments;
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(count);
  Modes modes;
  for (int round = 0;; ++round) {
    Eigen::MatrixXd inner_product =
        transposed_product(rich.points, Eigen::MatrixXd(weights.asDiagonal() * rich.points));
    inner_product.diagonal().array() += weight_of_mean * weights.sum() / rich.dense.uniform.squaredNorm();
    const auto size_of = [&](const Eigen::MatrixXd& moments) {
      return (inner_product.bottomRightCorner(others, others).cwiseProduct(moments.bottomRightCorner(others, others)))
          .sum();
    };
    modes = nested_modes(fields + (dual_share * size_of(fields) / size_of(duals)) * duals, inner_product, fixed);
    if (round == weight_rounds) return modes.columns;

    const double balanced =
        balanced_at_K * balanced_at_K * weights.sum() * static_cast<double>(snapshots.fields.cols());
    Eigen::Index nodes = fixed;
    while (nodes < count && modes.left_after[nodes - 1] > balanced) ++nodes;
    const Eigen::VectorXd errors_K =
        largest_part_errors_K(rich, snapshots.fields, modes.columns.leftCols(nodes), threads);
    const double mean_K = errors_K.mean();
    if (!(mean_K > 0.0)) return modes.columns;
    for (std::size_t i = 0; i < rich.part_of_point.size(); ++i) {
      weights[static_cast<Eigen::Index>(i)] *=
          std::clamp(errors_K[rich.part_of_point[i]] / mean_K, 1.0 / most_change_of_weight, most_change_of_weight);
    }
  }
}

}  // namespace spindle_twin::fem_offline
