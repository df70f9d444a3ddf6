#include "rom/read/csv_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <string_view>

namespace spindle_twin::rom {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string> split(std::string_view line) {
  std::vector<std::string> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.emplace_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// Independent of the locale, and the whole cell must be the number.
double number(const std::string& cell, const std::string& column, const SourceLine& where) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0.0;
  const char* end = cell.data() + cell.size();
  const auto [stop, error] = std::from_chars(cell.data(), end, value);
  if (error != std::errc() || stop != end || !std::isfinite(value)) {
    throw InputError(where, column, "'" + cell + "' is not a finite number with a decimal point");
  }
  return value;
}

/// Bytes of UTF-8 as far as their pattern goes, and no control character: else this is a file in UTF-16, of a Latin-1
/// editor, or no text at all, and what it holds cannot be named in a message.
bool is_text(std::string_view line) {
  int continued = 0;
  for (const char c : line) {
    const auto byte = static_cast<unsigned char>(c);
    const bool continues = (byte & 0xC0U) == 0x80U;
    if (continues != (continued > 0) || (byte < 0x20U && byte != '\t' && byte != '\r')) return false;
    continued = continues ? continued - 1 : byte >= 0xF0U ? 3 : byte >= 0xE0U ? 2 : byte >= 0xC0U ? 1 : 0;
  }
  return continued == 0;
}

void read_header(const std::string& line, const SourceLine& where, CsvTable& table) {
  table.names = split(line);
  table.header_line = where.line;
  if (table.names.size() == 1 && table.names.front().find_first_of(";\t|") != std::string::npos) {
    throw InputError(where, "", "columns must be separated by commas");
  }
  for (auto name = table.names.begin(); name != table.names.end(); ++name) {
    if (std::find(table.names.begin(), name, *name) != name) throw InputError(where, *name, "column given twice");
  }
  table.columns.resize(table.names.size());
}

void read_row(const std::string& line, const SourceLine& where, CsvTable& table) {
  const std::vector<std::string> cells = split(line);
  if (cells.size() != table.names.size()) {
    throw InputError(where, "",
                     std::to_string(cells.size()) + " values, but the header names " +
                         std::to_string(table.names.size()) + " columns");
  }
  for (std::size_t c = 0; c < cells.size(); ++c) table.columns[c].push_back(number(cells[c], table.names[c], where));
  table.lines.push_back(where.line);
}

}  // namespace

bool CsvTable::has(const std::string& name) const { return std::find(names.begin(), names.end(), name) != names.end(); }

const std::vector<double>& CsvTable::column(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw InputError(header(), name, "missing column");
  return columns[static_cast<std::size_t>(found - names.begin())];
}

CsvTable read_csv_table(const std::string& path, LastLine last) {
  std::ifstream file(path);
  if (!file) throw InputError({path, 0}, "", "cannot be opened for reading");
  CsvTable table;
  table.file = path;
  SourceLine where{path, 0};
  std::string line;
  while (std::getline(file, line)) {
    ++where.line;
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (where.line == 1 && line.starts_with(byte_order_mark)) line.erase(0, byte_order_mark.size());
    if (!is_text(line)) throw InputError(where, "", "is no text in UTF-8, as which a CSV must be saved");
    if (trimmed(line).empty()) continue;
    if (table.names.empty()) {
      read_header(line, where, table);
    } else if (!file.eof() || last == LastLine::whole) {
      read_row(line, where, table);
    }
  }
  if (file.bad()) throw InputError(where, "", "reading failed");
  if (table.names.empty()) throw InputError({path, 0}, "", "empty; a header with the names of the columns is needed");
  if (table.rows() == 0) throw InputError({path, 0}, "", "holds no row");
  return table;
}

double interpolate(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto above = std::lower_bound(x.begin(), x.end(), at);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const auto i = static_cast<std::size_t>(above - x.begin());
  return y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / (x[i] - x[i - 1]);
}

}  // namespace spindle_twin::rom
