// Columns in a file of their own.
#include "fem_offline/reduce/column_store.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

namespace spindle_twin::fem_offline {
namespace reduce_column_store_test {

Eigen::MatrixXd some_columns(Eigen::Index rows, Eigen::Index cols) {
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [](Eigen::Index r, Eigen::Index c) {
    return static_cast<double>(r + 1) / static_cast<double>(3 * c + 1);
  });
}

TEST(ColumnStore, gives_back_what_was_written_rounded_to_single_precision) {
  const Eigen::MatrixXd columns = some_columns(50, 9);
  const Eigen::MatrixXd rounded = columns.cast<float>().cast<double>();
  ColumnStore<float> store(50, 9);
  store.write(4, columns.rightCols(5));
  store.write(0, columns.leftCols(4));
  EXPECT_EQ(store.block(0, 9), rounded);
  EXPECT_EQ(store.block(3, 2), rounded.middleCols(3, 2));
  EXPECT_EQ(store.chosen({7, 0, 7}), rounded(Eigen::all, std::vector<int>{7, 0, 7}));
}

TEST(ColumnStore, of_doubles_gives_them_back_to_the_bit) {
  const Eigen::MatrixXd columns = some_columns(50, 9);
  ColumnStore<double> store(50, 9);
  store.write(0, columns);
  EXPECT_EQ(store.block(2, 5), columns.middleCols(2, 5));
  EXPECT_EQ(store.chosen({8, 1}), columns(Eigen::all, std::vector<int>{8, 1}));
}

TEST(ColumnStore, is_zero_where_nothing_was_written) {
  ColumnStore<float> store(20, 3);
  store.write(1, some_columns(20, 1));
  EXPECT_EQ(store.block(2, 1), Eigen::MatrixXd::Zero(20, 1));
}

TEST(ColumnStore, names_the_folder_in_which_it_finds_no_place) {
  const char* given = std::getenv("TMPDIR");
  const std::string before = given ? given : "";
  setenv("TMPDIR", "/no/such/folder", 1);
  try {
    const ColumnStore<float> store(2, 2);
    ADD_FAILURE() << "made";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "/no/such/folder: the file of columns cannot be made: No such file or directory; TMPDIR "
                 "names another folder");
  }
  given ? setenv("TMPDIR", before.c_str(), 1) : unsetenv("TMPDIR");
}

}  // namespace reduce_column_store_test
}  // namespace spindle_twin::fem_offline
