#include "fem_offline/reduce/most_independent.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Of a squared length: below it, what is left of a column is rounding.
constexpr double least_left = 1e-15;
constexpr Eigen::Index columns_of_a_product = 128;
constexpr std::size_t columns_made_at_once = 24;

/// The rows of a matrix, in the place of columns.
struct RowsAsColumns {
  const Eigen::MatrixXd& matrix;
  Eigen::Index cols() const { return matrix.rows(); }
};

Eigen::MatrixXd block_of(const ColumnStore<float>& columns, Eigen::Index first, Eigen::Index count) {
  return columns.block(first, count);
}
Eigen::MatrixXd block_of(const RowsAsColumns& columns, Eigen::Index first, Eigen::Index count) {
  return columns.matrix.middleRows(first, count).transpose();
}
Eigen::MatrixXd chosen_of(const ColumnStore<float>& columns, const std::vector<int>& indices) {
  return columns.chosen(indices);
}
Eigen::MatrixXd chosen_of(const RowsAsColumns& columns, const std::vector<int>& indices) {
  return columns.matrix(indices, Eigen::all).transpose();
}

/// Columns of XᵀX without what a Cholesky factor of some of its columns has of them, made a few at a time when they are
/// asked for.
template <typename Columns>
class GramColumns {
 public:
  GramColumns(const Columns& columns, int threads)
      : columns_(columns), threads_(threads), place_(static_cast<std::size_t>(columns.cols()), -1) {}

  bool has(int index) const { return place_[static_cast<std::size_t>(index)] >= 0; }

  /// At most columns_made_at_once of them, without what the factor's first `steps` columns have.
  void make(const std::vector<int>& indices, const Eigen::MatrixXd& factor, Eigen::Index steps) {
    const Eigen::MatrixXd asked = chosen_of(columns_, indices);
    const Eigen::MatrixXd known = factor(indices, Eigen::seqN(0, steps)).transpose();
    for (const int index : indices) {
      place_[static_cast<std::size_t>(index)] = static_cast<int>(made_.size());
      made_.push_back({Eigen::VectorXd(columns_.cols()), steps});
    }
    const std::size_t first_made = made_.size() - indices.size();
    const auto tiles = static_cast<int>((columns_.cols() + columns_of_a_product - 1) / columns_of_a_product);
    for_each_index(tiles, threads_, [&](int tile, int) {
      const Eigen::Index first = tile * columns_of_a_product;
      const Eigen::Index count = std::min(columns_of_a_product, columns_.cols() - first);
      const Eigen::MatrixXd own = block_of(columns_, first, count);
      Eigen::MatrixXd part = transposed_product(own, asked);
      if (steps > 0) part -= product(factor.block(first, 0, count, steps), known);
      for (std::size_t i = 0; i < indices.size(); ++i) {
        made_[first_made + i].column.segment(first, count) = part.col(static_cast<Eigen::Index>(i));
      }
    });
  }

  /// Gives one of them without what the factor's first `steps` columns have; it cannot be taken again.
  Eigen::VectorXd take(int index, const Eigen::MatrixXd& factor, Eigen::Index steps) {
    Made& made = made_[static_cast<std::size_t>(place_[static_cast<std::size_t>(index)])];
    Eigen::VectorXd column = std::move(made.column);
    const Eigen::Index since = steps - made.steps;
    column.noalias() -= factor.middleCols(made.steps, since) * factor.row(index).segment(made.steps, since).transpose();
    return column;
  }

 private:
  struct Made {
    Eigen::VectorXd column;  ///< empty once taken
    Eigen::Index steps;      ///< of the factor, without which it is
  };
  const Columns& columns_;
  int threads_;
  std::vector<int> place_;  ///< -1: not made
  std::vector<Made> made_;
};

/// The columns of which most is left, longest first, that are not made yet.
template <typename Columns>
std::vector<int> next_candidates(const Eigen::VectorXd& left, double stop_below, const GramColumns<Columns>& gram) {
  std::vector<int> candidates;
  for (int i = 0; i < static_cast<int>(left.size()); ++i) {
    if (left[i] > stop_below && !gram.has(i)) candidates.push_back(i);
  }
  const auto count = static_cast<std::ptrdiff_t>(std::min(columns_made_at_once, candidates.size()));
  std::partial_sort(candidates.begin(), candidates.begin() + count, candidates.end(),
                    [&](int a, int b) { return left[a] != left[b] ? left[a] > left[b] : a < b; });
  candidates.resize(static_cast<std::size_t>(count));
  return candidates;
}

template <typename Columns>
std::vector<int> choose(const Columns& columns, Eigen::Index most, int threads) {
  GramColumns<Columns> gram(columns, threads);
  Eigen::VectorXd left(columns.cols());  // squared length of what is not in the span of the chosen
  for (Eigen::Index first = 0; first < columns.cols(); first += columns_of_a_product) {
    const Eigen::Index count = std::min(columns_of_a_product, columns.cols() - first);
    left.segment(first, count) = block_of(columns, first, count).colwise().squaredNorm().transpose();
  }
  const double stop_below = least_left * left.maxCoeff();
  if (!(stop_below > 0.0)) throw std::runtime_error("all columns to choose from are zero");
  std::vector<int> chosen;
  Eigen::MatrixXd factor(columns.cols(), std::min(most, columns.cols()));
  for (Eigen::Index step = 0; step < factor.cols(); ++step) {
    // 1. the farthest column
    Eigen::Index pivot = 0;
    if (const double farthest = left.maxCoeff(&pivot); !(farthest > stop_below)) break;
    // 2. its column of the Gram matrix, with others that may soon be the farthest, without what the factor has of it
    if (!gram.has(static_cast<int>(pivot))) gram.make(next_candidates(left, stop_below, gram), factor, step);
    factor.col(step) = gram.take(static_cast<int>(pivot), factor, step) / std::sqrt(left[pivot]);
    // 3. what is left of all others
    left.array() -= factor.col(step).array().square();
    left[pivot] = 0.0;
    chosen.push_back(static_cast<int>(pivot));
  }
  return chosen;
}

}  // namespace

std::vector<int> most_independent(const ColumnStore<float>& columns, Eigen::Index most, int threads) {
  return choose(columns, most, threads);
}

std::vector<int> most_independent_rows(const Eigen::MatrixXd& matrix, Eigen::Index most, int threads) {
  return choose(RowsAsColumns{matrix}, most, threads);
}

}  // namespace spindle_twin::fem_offline
