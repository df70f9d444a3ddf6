#include "host_tools/thermal_report/thermal_record.hpp"

#include <algorithm>
#include <cmath>

#include "rom/read/csv_table.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr double same_speed_share = 0.01;
constexpr double same_speed_rpm = 5.0;

/// "nose" of "measured.nose_um"; empty where the column is no such.
std::string measured_name(const std::string& column, const std::string& unit) {
  const std::string begin = "measured.";
  if (!column.starts_with(begin) || !column.ends_with(unit)) return "";
  return column.substr(begin.size(), column.size() - begin.size() - unit.size());
}

Course course_of(const std::string& name, const std::vector<double>& time_s, const std::vector<double>& values) {
  Course course{name, {}, {}};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    course.time_s.push_back(time_s[i]);
    course.value.push_back(values[i]);
  }
  return course;
}

void add_course(Course course, std::vector<Course>& courses) {
  if (!course.value.empty()) courses.push_back(std::move(course));
}

const std::vector<double>& full(const rom::CsvTable& table, const std::string& name) {
  const std::vector<double>& values = table.column(name);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) throw rom::InputError(table.where(i), name, "must not be empty");
  }
  return values;
}

}  // namespace

ThermalRecord read_thermal_record(const std::string& path) {
  const rom::CsvTable table = rom::read_csv_table(path, rom::LastLine::may_be_cut);
  ThermalRecord record;
  record.file = path;
  record.time_s = full(table, "time_s");
  record.speed_rpm = full(table, "speed_rpm");
  for (std::size_t i = 1; i < record.time_s.size(); ++i) {
    if (record.time_s[i] <= record.time_s[i - 1]) {
      throw rom::InputError(table.where(i), "time_s", "times must rise from row to row");
    }
  }
  for (std::size_t c = 0; c < table.names.size(); ++c) {
    const std::string& column = table.names[c];
    const std::string length = measured_name(column, "_um"), temperature = measured_name(column, "_degC");
    if (!length.empty()) {
      add_course(course_of(length, record.time_s, table.columns[c]), record.lengths);
    } else if (!temperature.empty()) {
      add_course(course_of(temperature, record.time_s, table.columns[c]), record.temperatures);
    } else if (column == "ambient_degC" || column == "coolant_degC") {
      const std::string name = column.substr(0, column.find('_'));
      add_course(course_of(name, record.time_s, table.columns[c]), record.surroundings);
    } else if (column != "time_s" && column != "speed_rpm") {
      record.unused.push_back(column);
    }
  }
  if (record.lengths.empty()) {
    throw rom::InputError(table.header(), "measured.<name>_um", "a thermal test needs a measured displacement");
  }
  return record;
}

std::vector<Phase> phases_of(const ThermalRecord& record) {
  double top_rpm = 0.0;
  for (const double speed : record.speed_rpm) top_rpm = std::max(top_rpm, std::abs(speed));
  const double same_rpm = std::max(same_speed_rpm, same_speed_share * top_rpm);
  std::vector<Phase> phases;
  double first_rpm = 0.0, sum_rpm = 0.0, rows = 0.0;
  for (std::size_t i = 0; i < record.time_s.size(); ++i) {
    const double speed_rpm = std::abs(record.speed_rpm[i]) < same_speed_rpm ? 0.0 : std::abs(record.speed_rpm[i]);
    const bool stands = speed_rpm == 0.0;
    const bool same = !phases.empty() && std::abs(speed_rpm - first_rpm) <= same_rpm && stands == (first_rpm == 0.0);
    if (!same) {
      if (!phases.empty()) phases.back().until_s = record.time_s[i];
      phases.push_back({record.time_s[i], record.time_s[i], speed_rpm});
      first_rpm = speed_rpm;
      sum_rpm = rows = 0.0;
    }
    sum_rpm += speed_rpm;
    rows += 1.0;
    phases.back().speed_rpm = sum_rpm / rows;
    phases.back().until_s = record.time_s[i];
  }
  return phases;
}

}  // namespace spindle_twin::host_tools
