#include "host_tools/commands/offline/report/csv_table.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <string_view>

#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

std::vector<std::string> split(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  std::vector<std::string> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.emplace_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

double number(const std::string& cell, const std::string& column, const rom::SourceLine& where) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || stop != cell.data() + cell.size()) {
    throw rom::InputError(where, column, "'" + cell + "' is not a number");
  }
  return value;
}

}  // namespace

bool CsvTable::has(const std::string& name) const { return std::find(names.begin(), names.end(), name) != names.end(); }

const std::vector<double>& CsvTable::column(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw rom::InputError({file, 1}, name, "missing column");
  return columns[static_cast<std::size_t>(found - names.begin())];
}

CsvTable read_csv_table(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw rom::InputError({path, 0}, "", "cannot be opened for reading");
  CsvTable table;
  table.file = path;
  rom::SourceLine where{path, 0};
  std::string line;
  while (std::getline(file, line)) {
    ++where.line;
    const bool cut = file.eof();
    const std::vector<std::string> cells = split(line);
    if (table.names.empty()) {
      table.names = cells;
      table.columns.resize(cells.size());
      continue;
    }
    if (cut) break;
    if (cells.size() != table.names.size()) {
      throw rom::InputError(where, "",
                            std::to_string(cells.size()) + " values, but the header names " +
                                std::to_string(table.names.size()) + " columns");
    }
    for (std::size_t c = 0; c < cells.size(); ++c) table.columns[c].push_back(number(cells[c], table.names[c], where));
  }
  if (table.rows() == 0) throw rom::InputError({path, 0}, "", "holds no row");
  return table;
}

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::lower_bound(x.begin(), x.end(), at);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(above - x.begin());
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

}  // namespace spindle_twin::host_tools
