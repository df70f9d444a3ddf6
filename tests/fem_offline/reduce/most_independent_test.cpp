#include "fem_offline/reduce/most_independent.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

namespace spindle_twin::fem_offline {
namespace most_independent_test {

/// Columns of lengths from 1 down to 1e-3 that fill `rank` directions.
Eigen::MatrixXf random_columns(Eigen::Index rows, Eigen::Index count, Eigen::Index rank, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto matrix = [&](Eigen::Index height, Eigen::Index width) {
    return Eigen::MatrixXd::NullaryExpr(height, width, [&] { return normal(random); }).eval();
  };
  Eigen::MatrixXd columns = matrix(rows, rank) * matrix(rank, count);
  for (Eigen::Index i = 0; i < count; ++i) columns.col(i) *= std::pow(10.0, -3.0 * static_cast<double>(i % 17) / 16.0);
  return columns.cast<float>();
}

/// Of columns that are stored as the snapshots are.
std::vector<int> stored_most_independent(const Eigen::MatrixXf& columns, Eigen::Index most, int threads) {
  ColumnStore<float> store(columns.rows(), columns.cols());
  store.write(0, columns.cast<double>());
  return most_independent(store, most, threads);
}

/// Distance of every column from the span of those chosen.
Eigen::VectorXd distances(const Eigen::MatrixXf& columns, const std::vector<int>& chosen) {
  const Eigen::MatrixXd all = columns.cast<double>();
  if (chosen.empty()) return all.colwise().norm();
  const Eigen::HouseholderQR<Eigen::MatrixXd> factor(all(Eigen::all, chosen));
  const Eigen::MatrixXd span = factor.householderQ() * Eigen::MatrixXd::Identity(all.rows(), std::ssize(chosen));
  return (all - span * (span.transpose() * all)).colwise().norm();
}

TEST(MostIndependent, each_is_the_farthest_from_the_span_of_those_before_it) {
  const Eigen::MatrixXf columns = random_columns(120, 700, 120, 5);
  const std::vector<int> chosen = stored_most_independent(columns, 60, 1);
  ASSERT_EQ(chosen.size(), 60U);
  std::vector<int> before;
  for (const int index : chosen) {
    const Eigen::VectorXd distance = distances(columns, before);
    EXPECT_GE(distance[index], distance.maxCoeff() * (1.0 - 1e-9)) << "after " << before.size();
    before.push_back(index);
  }
}

TEST(MostIndependent, rows_come_in_the_order_of_pivoted_qr_of_the_transposed_matrix) {
  const Eigen::MatrixXd columns = random_columns(90, 800, 90, 8).cast<double>();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivoted(columns);
  const auto& order = pivoted.colsPermutation().indices();
  EXPECT_EQ(most_independent_rows(columns.transpose(), 90, 2), std::vector<int>(order.data(), order.data() + 90));
}

TEST(MostIndependent, are_no_more_than_the_columns_have_directions) {
  // Rounding to single precision leaves a little beside the nine directions.
  const Eigen::MatrixXf columns = random_columns(80, 300, 9, 6);
  const std::vector<int> chosen = stored_most_independent(columns, 9, 1);
  ASSERT_EQ(chosen.size(), 9U);
  EXPECT_LT(distances(columns, chosen).maxCoeff(), 1e-5 * distances(columns, {}).maxCoeff());
  EXPECT_EQ(stored_most_independent(columns.leftCols(4), 9, 1).size(), 4U);
  Eigen::MatrixXf exact = Eigen::MatrixXf::Zero(20, 40);
  for (Eigen::Index i = 0; i < exact.cols(); ++i) exact(i % 5, i) = static_cast<float>(i + 1);
  EXPECT_EQ(stored_most_independent(exact, 20, 1).size(), 5U);
}

TEST(MostIndependent, are_the_same_on_any_number_of_threads) {
  const Eigen::MatrixXf columns = random_columns(150, 900, 150, 7);
  EXPECT_EQ(stored_most_independent(columns, 100, 1), stored_most_independent(columns, 100, 3));
}

TEST(MostIndependent, are_refused_where_there_are_none) {
  EXPECT_THROW(stored_most_independent(Eigen::MatrixXf::Zero(10, 3), 2, 1), std::runtime_error);
}

}  // namespace most_independent_test
}  // namespace spindle_twin::fem_offline
