#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "fem_offline/solve/cholesky.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Lower triangle of the five-point Laplacian on a grid, plus one on the diagonal.
SparseMatrix grid_matrix(int side, int rows) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < side; ++i) {
      const int at = j * side + i;
      entries.emplace_back(at, at, 5.0);
      if (i + 1 < side) entries.emplace_back(at + 1, at, -1.0);
      if (j + 1 < rows) entries.emplace_back(at + side, at, -1.0);
    }
  }
  SparseMatrix lower(side * rows, side * rows);
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

// 200 factors on each of two threads, on both sides of the size from which the BLAS is used.
TEST(CholeskyThreads, two_threads_factorise_at_once_without_a_wrong_answer) {
  constexpr int factors = 200;
  constexpr int side = 20;
  for (const int rows : {200, 2600}) {
    const SparseMatrix lower = grid_matrix(side, rows);
    const Eigen::VectorXd load = Eigen::VectorXd::LinSpaced(lower.rows(), -1.0, 2.0);
    std::atomic<int> wrong{0};
    const auto work = [&] {
      try {
        const CholeskyFactor pattern(lower);
        Eigen::VectorXd solution;
        for (int k = 0; k < factors; ++k) {
          CholeskyFactor factor(pattern, lower);
          factor.solve(load, solution);
          const double residual = (lower.selfadjointView<Eigen::Lower>() * solution - load).norm();
          if (!(residual < 1e-11 * load.norm())) ++wrong;
        }
      } catch (const std::exception&) {
        ++wrong;
      }
    };
    std::thread first(work), second(work);
    first.join();
    second.join();
    EXPECT_EQ(wrong, 0) << "grid of " << side << " x " << rows;
  }
}

}  // namespace
}  // namespace spindle_twin::fem_offline
