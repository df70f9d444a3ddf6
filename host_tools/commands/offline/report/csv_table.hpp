#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace spindle_twin::host_tools {

/// A table of numbers with named columns; an empty cell is NaN.
struct CsvTable {
  std::string file;
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;

  std::size_t rows() const { return columns.empty() ? 0 : columns.front().size(); }
  /// Throws rom::InputError naming the file and the column if it is missing.
  const std::vector<double>& column(const std::string& name) const;
  bool has(const std::string& name) const;
};

/// Comma-separated, header first. A cut last line (a writer that was stopped) is dropped. Throws rom::InputError with
/// file, line and column for a cell that is no number and a line of another length.
CsvTable read_csv_table(const std::string& path);

/// Value of `y` over `x` at `at`, linear between rows and held beyond the ends; `x` rises.
double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at);

}  // namespace spindle_twin::host_tools
