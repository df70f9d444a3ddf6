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

TEST(CsvTable, names_are_known_and_lines_counted_also_behind_empty_ones) {
  const CsvTable table = table_of("\n \t\ntime_s,a\n\n0,1\n\n\n1,2\n");
  EXPECT_TRUE(table.has("a"));
  EXPECT_TRUE(table.has("time_s"));
  EXPECT_FALSE(table.has("b"));
  EXPECT_EQ(table.header().line, 3);
  EXPECT_EQ(table.where(0).line, 5);
  EXPECT_EQ(table.where(1).line, 8);
  EXPECT_EQ(refusal_of_table("\n\ntime_s,a,a\n0,1,1\n"), ":3: a: column given twice");
  EXPECT_EQ(CsvTable{}.header_line, 1);
  EXPECT_EQ(CsvTable{}.rows(), 0U);
}

TEST(CsvTable, a_byte_order_mark_stands_at_the_beginning_only) {
  EXPECT_EQ(table_of("\xEF\xBB\xBFtime_s\n7\n").column("time_s")[0], 7.0);
  EXPECT_NE(refusal_of_table("time_s\n\xEF\xBB\xBF"
                             "7\n"),
            "no error");
}

TEST(CsvTable, other_separators_are_told_where_there_is_one_column_only) {
  for (const char* separator : {";", "|", "\t"}) {
    EXPECT_EQ(refusal_of_table(std::string("time_s") + separator + "a\n0\n"),
              ":1: columns must be separated by commas");
  }
  EXPECT_EQ(table_of("time_s,a;b\n0,1\n").column("a;b")[0], 1.0);
  EXPECT_EQ(table_of("time_s\n0\n").rows(), 1U) << "one column alone is a table";
}

TEST(CsvTable, a_cell_is_a_number_from_its_first_character_to_its_last) {
  for (const char* bad : {"1 2", "1,5x", "x1", "1.5.2", "--1", "nan", "1e999", "0x10"}) {
    EXPECT_NE(refusal_of_table(std::string("a,b\n0,") + bad + "\n"), "no error") << bad;
  }
  EXPECT_EQ(table_of("a,b\n0, -2.5e-3\t\n").column("b")[0], -2.5e-3);
}

TEST(Interpolate, meets_every_row_and_needs_no_more_than_one) {
  const std::vector<double> x = {-1.0, 2.0, 2.5, 10.0}, y = {5.0, -1.0, 7.0, 7.5};
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_EQ(interpolate(x, y, x[i]), y[i]);
  EXPECT_NEAR(interpolate(x, y, 2.4), 5.4, 1e-12);
  EXPECT_NEAR(interpolate(x, y, 0.0), 3.0, 1e-12);
  for (const double at : {-3.0, 4.0, 9.0}) EXPECT_EQ(interpolate({4.0}, {6.0}, at), 6.0);
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
