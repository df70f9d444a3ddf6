#include "rom/read/csv_table.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace spindle_twin::rom {
namespace csv_table_test {

CsvTable table_of(const std::string& text, LastLine last = LastLine::may_be_cut) {
  const spindle_twin::tests::TemporaryFolder folder;
  const std::string path = folder.write("table.csv", text);
  try {
    return read_csv_table(path, last);
  } catch (const InputError& error) {
    throw std::runtime_error(std::string(error.what()).substr(path.size()));
  }
}

std::string refusal_of_table(const std::string& text) {
  try {
    table_of(text);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST(CsvTable, reads_numbers_empty_cells_and_drops_a_cut_line_where_there_may_be_one) {
  const std::string text = "time_s,a\n0,1.5\n1,\n2,2e-3\n3,0.";
  const CsvTable table = table_of(text);
  ASSERT_EQ(table.rows(), 3U);
  EXPECT_EQ(table.column("a")[0], 1.5);
  EXPECT_TRUE(std::isnan(table.column("a")[1]));
  EXPECT_EQ(table.column("a")[2], 2e-3);
  EXPECT_EQ(table_of(text, LastLine::whole).rows(), 4U);
}

TEST(CsvTable, what_spreadsheets_add_is_of_no_account) {
  const CsvTable table = table_of("\xEF\xBB\xBFtime_s, a\r\n\r\n0 , 1\r\n1,2\r\n");
  EXPECT_EQ(table.names, (std::vector<std::string>{"time_s", "a"}));
  EXPECT_EQ(table.column("a"), (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(table.where(0).line, 3) << "rows know their line in the file";
}

TEST(CsvTable, bad_table_is_one_error_with_line_and_column) {
  EXPECT_EQ(refusal_of_table("time_s,a\n0,1\n1,one\n"), ":3: a: 'one' is not a finite number with a decimal point");
  EXPECT_EQ(refusal_of_table("time_s,a\n0,inf\n"), ":2: a: 'inf' is not a finite number with a decimal point");
  EXPECT_EQ(refusal_of_table("time_s,a\n0\n"), ":2: 1 values, but the header names 2 columns");
  EXPECT_EQ(refusal_of_table("time_s,a,a\n0,1,1\n"), ":1: a: column given twice");
  EXPECT_EQ(refusal_of_table("time_s\ta\n0\t1\n"), ":1: columns must be separated by commas");
  EXPECT_EQ(refusal_of_table("time_s\n"), ": holds no row");
  EXPECT_EQ(refusal_of_table("\n\n"), ": empty; a header with the names of the columns is needed");
  EXPECT_THROW(table_of("time_s\n0\n").column("nose"), InputError);
}

TEST(Interpolate, is_linear_inside_and_held_outside) {
  const std::vector<double> x = {0.0, 2.0, 4.0};
  const std::vector<double> y = {1.0, 3.0, -1.0};
  EXPECT_EQ(interpolate(x, y, 1.0), 2.0);
  EXPECT_EQ(interpolate(x, y, 3.0), 1.0);
  EXPECT_EQ(interpolate(x, y, -1.0), 1.0);
  EXPECT_EQ(interpolate(x, y, 9.0), -1.0);
}

}  // namespace csv_table_test
}  // namespace spindle_twin::rom
