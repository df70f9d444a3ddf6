#include <spdlog/fmt/fmt.h>

#include <array>
#include <charconv>
#include <cmath>
#include <ctime>
#include <fstream>
#include <optional>
#include <sstream>
#include <utility>

#include "host_tools/evaluate/growth_reading.hpp"
#include "rom/read/input_error.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

std::string trimmed(const std::string& text) {
  constexpr const char* blanks = " \t\r";
  const std::size_t first = text.find_first_not_of(blanks);
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream parts(line);
  for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(trimmed(cell));
  if (line.ends_with(',')) cells.emplace_back();
  return cells;
}

std::optional<double> unix_time_of(const std::string& text) {
  for (const char* form : {"%Y-%m-%d %H:%M:%S", "%Y-%m-%dT%H:%M:%S", "%Y-%m-%d %H:%M", "%Y-%m-%dT%H:%M"}) {
    std::tm time{};
    const char* end = strptime(text.c_str(), form, &time);
    if (end == nullptr || (*end != '\0' && std::string(end) != "Z")) continue;
    const std::tm asked = time;
    const std::time_t found = timegm(&time);
    if (time.tm_mday != asked.tm_mday || time.tm_mon != asked.tm_mon) return std::nullopt;  // 30 February
    return static_cast<double>(found);
  }
  return std::nullopt;
}

/// With or without a plus, as in the column's own description: + = spindle longer.
std::optional<double> number_of(const std::string& text) {
  double value = 0.0;
  const bool has_plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const auto [end, error] = std::from_chars(text.data() + (has_plus ? 1 : 0), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

struct Columns {
  std::optional<std::size_t> time, growth, compensated;
  std::size_t count = 0;
};

Columns columns_of(const std::vector<std::string>& names, const rom::SourceLine& where) {
  Columns columns;
  columns.count = names.size();
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::optional<std::size_t>* const column = names[i] == "time_utc"      ? &columns.time
                                               : names[i] == "growth_um"   ? &columns.growth
                                               : names[i] == "compensated" ? &columns.compensated
                                                                           : nullptr;
    if (column == nullptr || *column) {
      throw rom::InputError(where, names[i], "unknown or given twice; allowed: time_utc, growth_um, compensated");
    }
    *column = i;
  }
  for (const auto& [column, name] : {std::pair(columns.time, "time_utc"), std::pair(columns.growth, "growth_um")}) {
    if (!column) throw rom::InputError(where, name, "this column is required");
  }
  return columns;
}

HandReading reading_of(const std::vector<std::string>& cells, const Columns& columns, const rom::SourceLine& where) {
  if (cells.size() != columns.count) {
    throw rom::InputError(where, "", fmt::format("{} cells, the header has {}", cells.size(), columns.count));
  }
  HandReading reading;
  reading.line = where.line;
  const auto time = unix_time_of(cells[*columns.time]);
  if (!time) throw rom::InputError(where, "time_utc", "must be a time like 2026-11-22 14:05 or 2026-11-22 14:05:30");
  reading.unix_s = *time;
  const auto growth_um = number_of(cells[*columns.growth]);
  if (!growth_um || std::abs(*growth_um) > correction::largest_growth_um) {
    throw rom::InputError(where, "growth_um", "must be a number from -10000 to 10000");
  }
  reading.growth_m = *growth_um * rom::m_per_um;
  if (columns.compensated) {
    const std::string& cell = cells[*columns.compensated];
    if (cell != "0" && cell != "1") throw rom::InputError(where, "compensated", "must be 0 or 1");
    reading.compensated = cell == "1";
  }
  return reading;
}

}  // namespace

std::vector<HandReading> read_hand_readings(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw rom::InputError({path, 0}, "", "cannot be read");
  std::vector<HandReading> readings;
  std::optional<Columns> columns;
  rom::SourceLine where{path, 0};
  for (std::string line; std::getline(file, line);) {
    ++where.line;
    if (where.line == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    if (trimmed(line).empty()) continue;
    const std::vector<std::string> cells = cells_of(line);
    if (!columns) {
      columns = columns_of(cells, where);
    } else {
      readings.push_back(reading_of(cells, *columns, where));
    }
  }
  if (readings.empty()) throw rom::InputError({path, 0}, "", "has no row");
  return readings;
}

}  // namespace spindle_twin::host_tools
