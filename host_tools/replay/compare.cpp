#include "host_tools/replay/compare.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace spindle_twin::host_tools {
namespace {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// Gathers a misfit.
class MisfitSum {
 public:
  void add(double error, double time_s) {
    if (!std::isfinite(error)) return;
    ++misfit_.count;
    squares_ += error * error;
    if (std::abs(error) <= std::abs(misfit_.worst)) return;
    misfit_.worst = error;
    misfit_.worst_at_s = time_s;
  }
  Misfit result() const {
    Misfit misfit = misfit_;
    if (misfit.count > 0) misfit.rms = std::sqrt(squares_ / static_cast<double>(misfit.count));
    return misfit;
  }

 private:
  Misfit misfit_;
  double squares_ = 0.0;
};

using ReadingOfRow = std::function<double(const LogRow&)>;

std::optional<Misfit> error_of(const Log& log, const ReadingOfRow& reading, const PredictedCourses& courses,
                               const std::vector<double>& values) {
  MisfitSum sum;
  for (const LogRow& row : log.rows) sum.add(predicted_at(courses, values, row.time_s) - reading(row), row.time_s);
  if (sum.result().count == 0) return {};
  return sum.result();
}

ComparedOutput compared_output(const Log& log, const ReadingOfRow& reading, const ReplayedLog& first,
                               const PredictedCourse& of_first, const ReplayedLog& second,
                               const PredictedCourse& of_second) {
  ComparedOutput output;
  output.name = of_first.name;
  output.first = of_first.value;
  output.first_deviation = of_first.deviation;
  MisfitSum difference;
  std::size_t next = 0;
  for (std::size_t i = 0; i < first.courses.time_s.size(); ++i) {
    const double time_s = first.courses.time_s[i];
    output.second.push_back(predicted_at(second.courses, of_second.value, time_s));
    output.second_deviation.push_back(predicted_at(second.courses, of_second.deviation, time_s));
    difference.add(output.second.back() - output.first[i], time_s);
    double read = nothing, read_s = nothing;
    for (; next < log.rows.size() && log.rows[next].time_s <= time_s; ++next) {
      if (!std::isfinite(reading(log.rows[next]))) continue;
      read = reading(log.rows[next]);
      read_s = log.rows[next].time_s;
    }
    output.measured.push_back(read);
    output.first_off.push_back(predicted_at(first.courses, of_first.value, read_s) - read);
    output.second_off.push_back(predicted_at(second.courses, of_second.value, read_s) - read);
  }
  output.difference = difference.result();
  output.first_error = error_of(log, reading, first.courses, of_first.value);
  output.second_error = error_of(log, reading, second.courses, of_second.value);
  return output;
}

const PredictedCourse* find_output(const std::vector<PredictedCourse>& courses, const std::string& name) {
  const auto found =
      std::find_if(courses.begin(), courses.end(), [&](const PredictedCourse& course) { return course.name == name; });
  return found == courses.end() ? nullptr : &*found;
}

}  // namespace

Comparison compare(const rom::Network& network, const Log& log, const ReplayedLog& first, const ReplayedLog& second) {
  Comparison comparison;
  comparison.time_s = first.courses.time_s;
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    const PredictedCourse& of_first = first.courses.deformations[d];
    const PredictedCourse* of_second = find_output(second.courses.deformations, of_first.name);
    if (of_second == nullptr) continue;
    const ReadingOfRow reading = [&log, d](const LogRow& row) {
      return log.has_deformation[d] ? row.deformation_m[d] : nothing;
    };
    comparison.deformations.push_back(compared_output(log, reading, first, of_first, second, *of_second));
  }
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    const PredictedCourse& of_first = first.courses.key_points[k];
    const PredictedCourse* of_second = find_output(second.courses.key_points, of_first.name);
    if (of_second == nullptr) continue;
    const ReadingOfRow reading = [&log, k](const LogRow& row) {
      return log.has_sensor[k] ? row.measured_K[k] : nothing;
    };
    comparison.key_points.push_back(compared_output(log, reading, first, of_first, second, *of_second));
  }
  return comparison;
}

}  // namespace spindle_twin::host_tools
