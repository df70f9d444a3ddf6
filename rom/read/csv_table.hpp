#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {

/// A table of numbers with named columns; an empty cell is NaN, every other number is finite.
struct CsvTable {
  std::string file;
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  int header_line = 1;
  std::vector<int> lines;  ///< where each row stands in the file

  std::size_t rows() const { return lines.size(); }
  SourceLine where(std::size_t row) const { return {file, lines[row]}; }
  SourceLine header() const { return {file, header_line}; }
  bool has(const std::string& name) const;
  /// Throws InputError naming the file and the column if it is missing.
  const std::vector<double>& column(const std::string& name) const;
};

/// What a last line without an end says: all of it, or how far a writer came that was stopped; that one is dropped.
enum class LastLine { whole, may_be_cut };

/// Comma-separated, header first; blanks around a cell, empty lines, a byte order mark and CR LF are of no account.
/// Throws InputError with file, line and column for a cell that is no finite number with a decimal point, a line of
/// another length, a column given twice, another separator than the comma, and for a file without a row.
CsvTable read_csv_table(const std::string& path, LastLine last);

/// Value of `y` over `x` at `at`, linear between rows and held beyond the ends; `x` rises.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at);

}  // namespace spindle_twin::rom
