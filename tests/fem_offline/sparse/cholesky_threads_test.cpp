#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {
namespace sparse_cholesky_threads_test {

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

// On both sides of the size from which the BLAS is used: long strips stay below it, squares do not.
TEST(CholeskyThreads, several_threads_factorise_at_once_without_a_wrong_answer) {
  constexpr int factors = 12;
  constexpr std::size_t threads = 4;
  for (const auto& [side, rows] : {std::pair{20, 200}, std::pair{200, 200}}) {
    const SparseMatrix lower = grid_matrix(side, rows);
    const Eigen::VectorXd load = Eigen::VectorXd::LinSpaced(lower.rows(), -1.0, 2.0);
    std::atomic<int> wrong{0};
    const auto work = [&] {
      try {
        const CholeskyAnalysis pattern(lower);
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
    std::vector<std::jthread> running;
    for (std::size_t i = 0; i < threads; ++i) running.emplace_back(work);
    running.clear();
    EXPECT_EQ(wrong, 0) << "grid of " << side << " x " << rows;
  }
}

TEST(CholeskyThreads, all_columns_at_once_are_the_single_solutions) {
  const SparseMatrix lower = grid_matrix(30, 40);
  const Eigen::MatrixXd loads = Eigen::MatrixXd::NullaryExpr(
      lower.rows(), 7, [](Eigen::Index i, Eigen::Index j) { return std::sin(static_cast<double>(i * (j + 1))); });
  CholeskyFactor factor(lower);
  const Eigen::MatrixXd solutions = factor.solve(loads);
  Eigen::VectorXd single;
  for (Eigen::Index j = 0; j < loads.cols(); ++j) {
    factor.solve(loads.col(j), single);
    EXPECT_LE((solutions.col(j) - single).norm(), 1e-14 * single.norm());
  }
}

/// METIS, which orders by nested dissection, draws from the random numbers that all threads share.
TEST(CholeskyThreads, orderings_of_several_threads_are_those_of_one) {
  const SparseMatrix lower = grid_matrix(60, 60);
  const Eigen::VectorXd load = Eigen::VectorXd::LinSpaced(lower.rows(), -1.0, 2.0);
  const auto solution = [&] {
    Eigen::VectorXd result;
    CholeskyFactor(lower, Solutions::of_many_factors).solve(load, result);
    return result;
  };
  const Eigen::VectorXd alone = solution();
  std::atomic<int> others{0};
  {
    std::vector<std::jthread> running;
    for (int i = 0; i < 4; ++i) {
      running.emplace_back([&] {
        for (int again = 0; again < 10; ++again) others += solution() == alone ? 0 : 1;
      });
    }
  }
  EXPECT_EQ(others, 0) << "of 40";
}

/// By columns and block by block; the small one is made by columns in either case.
TEST(CholeskyThreads, a_factor_for_few_solutions_gives_those_of_one_for_many) {
  for (const auto& [side, rows] : {std::pair{20, 20}, std::pair{200, 200}}) {
    const SparseMatrix lower = grid_matrix(side, rows);
    const Eigen::VectorXd load = Eigen::VectorXd::LinSpaced(lower.rows(), -1.0, 2.0);
    CholeskyFactor many(lower), few(lower, Solutions::few);
    Eigen::VectorXd of_many, of_few;
    many.solve(load, of_many);
    few.solve(load, of_few);
    EXPECT_LE((of_few - of_many).norm(), 1e-12 * of_many.norm()) << side << " x " << rows;
  }
}

TEST(CholeskyThreads, a_matrix_that_is_not_positive_definite_is_an_error_for_small_and_large) {
  for (const auto& [side, rows] : {std::pair{20, 20}, std::pair{200, 200}}) {
    SparseMatrix lower = grid_matrix(side, rows);
    lower.coeffRef(lower.rows() / 2, lower.rows() / 2) = -5.0;
    EXPECT_THROW(CholeskyFactor{lower}, std::runtime_error) << side << " x " << rows;
    EXPECT_THROW(CholeskyFactor(lower, Solutions::few), std::runtime_error) << side << " x " << rows;
  }
}

}  // namespace sparse_cholesky_threads_test
}  // namespace spindle_twin::fem_offline
