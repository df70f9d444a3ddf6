#include "fem_offline/reduce/most_independent.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/parallel.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Of a squared length: below it, what is left of a column is rounding.
constexpr double least_left = 1e-15;
constexpr Eigen::Index columns_of_a_product = 256;  ///< converted to double at once
constexpr std::size_t columns_made_at_once = 24;

/// Columns of XᵀX, made in small groups when they are asked for.
class GramColumns {
 public:
  GramColumns(const Eigen::MatrixXf& columns, int threads)
      : columns_(columns), threads_(threads), place_(static_cast<std::size_t>(columns.cols()), -1) {}

  bool has(int index) const { return place_[static_cast<std::size_t>(index)] >= 0; }
  auto operator[](int index) const {
    const auto at = static_cast<std::size_t>(place_[static_cast<std::size_t>(index)]);
    return groups_[at / columns_made_at_once].col(static_cast<Eigen::Index>(at % columns_made_at_once));
  }
  /// At most columns_made_at_once of them.
  void make(const std::vector<int>& indices) {
    const Eigen::MatrixXd asked = columns_(Eigen::all, indices).cast<double>();
    Eigen::MatrixXd group(columns_.cols(), asked.cols());
    const auto tiles = static_cast<int>((columns_.cols() + columns_of_a_product - 1) / columns_of_a_product);
    for_each_index(tiles, threads_, [&](int tile, int) {
      const Eigen::Index first = tile * columns_of_a_product;
      const Eigen::Index count = std::min(columns_of_a_product, columns_.cols() - first);
      const Eigen::MatrixXd own = columns_.middleCols(first, count).cast<double>();
      group.middleRows(first, count) = transposed_product(own, asked);
    });
    for (std::size_t i = 0; i < indices.size(); ++i) {
      place_[static_cast<std::size_t>(indices[i])] = static_cast<int>(groups_.size() * columns_made_at_once + i);
    }
    groups_.push_back(std::move(group));
  }

 private:
  const Eigen::MatrixXf& columns_;
  int threads_;
  std::vector<int> place_;  ///< group and column in it; -1: not made
  std::vector<Eigen::MatrixXd> groups_;
};

/// The columns of which most is left, longest first, that are not made yet.
std::vector<int> next_candidates(const Eigen::VectorXd& left, double stop_below, const GramColumns& gram) {
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

}  // namespace

std::vector<int> most_independent(const Eigen::MatrixXf& columns, Eigen::Index most, int threads) {
  GramColumns gram(columns, threads);
  Eigen::VectorXd left(columns.cols());  // squared length of what is not in the span of the chosen
  for (Eigen::Index i = 0; i < columns.cols(); ++i) left[i] = columns.col(i).cast<double>().squaredNorm();
  const double stop_below = least_left * left.maxCoeff();
  if (!(stop_below > 0.0)) throw std::runtime_error("the FE snapshots span nothing");
  std::vector<int> chosen;
  Eigen::MatrixXd factor(columns.cols(), std::min(most, columns.cols()));
  for (Eigen::Index step = 0; step < factor.cols(); ++step) {
    // 1. the farthest column
    Eigen::Index pivot = 0;
    if (const double farthest = left.maxCoeff(&pivot); !(farthest > stop_below)) break;
    // 2. its column of the Gram matrix, with others that may soon be the farthest
    if (!gram.has(static_cast<int>(pivot))) gram.make(next_candidates(left, stop_below, gram));
    // 3. without what the factor has of it already
    auto column = factor.col(step);
    column = gram[static_cast<int>(pivot)];
    column.noalias() -= factor.leftCols(step) * factor.row(pivot).head(step).transpose();
    column /= std::sqrt(left[pivot]);
    // 4. what is left of all others
    left.array() -= column.array().square();
    left[pivot] = 0.0;
    chosen.push_back(static_cast<int>(pivot));
  }
  return chosen;
}

}  // namespace spindle_twin::fem_offline
