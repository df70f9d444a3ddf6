#include "host_tools/thermal_report/thermal_report.hpp"

#include <algorithm>
#include <cmath>

#include "host_tools/thermal_report/evaluate_course.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr double first_s = 15.0 * rom::seconds_per_minute;
constexpr double hour_s = rom::seconds_per_hour;
constexpr double least_phase_s = 10.0 * rom::seconds_per_minute;
constexpr std::size_t most_points = 3000;  // of a curve on the page

Json drift_json(const Course& course, double from_s, double until_s) {
  const auto drift = drift_between(course, from_s, until_s);
  if (!drift) return {};
  return {{"readings", drift->readings},
          {"range", drift->range},
          {"change", drift->change},
          {"rate_per_h", drift->rate_per_h}};
}

/// Null where the record ends before the window does, or readings leave out much of it.
Json window_json(const Course& course, const Phase& whole, double length_s) {
  if (whole.until_s - whole.from_s < length_s) return {};
  return drift_json(course, whole.from_s, whole.from_s + length_s);
}

Json steepest_json(const Course& course, const Phase& whole) {
  const auto steepest = steepest_per_h(course, whole.from_s, whole.until_s, first_s);
  return steepest ? Json(*steepest) : Json();
}

Json rotation_of(const Course& course, const Phase& whole) {
  return {{"first_15_min", window_json(course, whole, first_s)},
          {"first_60_min", window_json(course, whole, hour_s)},
          {"whole", drift_json(course, whole.from_s, whole.until_s)},
          {"steepest_15_min_per_h", steepest_json(course, whole)}};
}

Json named(const std::string& name, const char* unit, const Json& values) {
  Json json{{"name", name}, {"unit", unit}};
  json.update(values);
  return json;
}

Json drifts_of(const std::vector<Course>& courses, const char* unit, const Phase& phase) {
  Json list = Json::array();
  for (const Course& course : courses) {
    list.push_back(named(course.name, unit,
                         {{"whole", drift_json(course, phase.from_s, phase.until_s)},
                          {"steepest_15_min_per_h", steepest_json(course, phase)}}));
  }
  return list;
}

/// A standstill: displacement beside what the surroundings did.
Json standstill_json(const ThermalRecord& record, const Phase& phase) {
  return {{"from_s", phase.from_s},
          {"until_s", phase.until_s},
          {"lengths", drifts_of(record.lengths, "µm", phase)},
          {"surroundings", drifts_of(record.surroundings, "K", phase)}};
}

const Course* find_course(const std::vector<Course>& courses, const std::string& name) {
  const auto found =
      std::find_if(courses.begin(), courses.end(), [&](const Course& course) { return course.name == name; });
  return found == courses.end() ? nullptr : &*found;
}

Json rotation_json(const ThermalRecord& record, const Compensated& compensated, const std::vector<Phase>& turning) {
  if (turning.empty()) return {};
  const Phase whole{turning.front().from_s, turning.back().until_s, 0.0};
  bool one_speed = true;
  for (const Phase& phase : turning) {
    one_speed = one_speed && std::abs(phase.speed_rpm - turning.front().speed_rpm) <= 0.01 * turning.front().speed_rpm;
  }
  one_speed = one_speed && turning.size() == 1;
  Json json{{"from_s", whole.from_s},
            {"until_s", whole.until_s},
            {"kind", one_speed ? "constant speed" : "varying speed"},
            {"lengths", Json::array()},
            {"temperatures", Json::array()},
            {"surroundings", drifts_of(record.surroundings, "K", whole)}};
  for (const Course& course : record.lengths) {
    Json length = named(course.name, "µm", {{"measured", rotation_of(course, whole)}});
    const Course* left = find_course(compensated.left, course.name);
    length["compensated"] = left == nullptr ? Json() : rotation_of(*left, whole);
    json["lengths"].push_back(length);
  }
  for (const Course& course : record.temperatures) {
    json["temperatures"].push_back(named(course.name, "K", {{"measured", rotation_of(course, whole)}}));
  }
  return json;
}

Json time_constants_json(const ThermalRecord& record, const std::vector<Phase>& phases, double from_s) {
  Json list = Json::array();
  for (const Phase& phase : phases) {
    if (phase.until_s - phase.from_s < least_phase_s || phase.from_s < from_s) continue;
    for (const Course& course : record.lengths) {
      const auto fitted = fit_time_constant(course, phase.from_s, phase.until_s);
      Json entry{
          {"name", course.name}, {"from_s", phase.from_s}, {"until_s", phase.until_s}, {"speed_rpm", phase.speed_rpm}};
      entry["time_constant_s"] = fitted ? Json(fitted->seconds) : Json();
      entry["swing_um"] = fitted ? Json(fitted->swing) : Json();
      entry["rms_um"] = fitted ? Json(fitted->rms) : Json();
      list.push_back(entry);
    }
  }
  return list;
}

/// The course at the instants that are drawn; null where it was not read.
Json drawn(const Course& course, const std::vector<double>& time_s, double zero) {
  Json list = Json::array();
  std::size_t next = 0;
  for (const double at_s : time_s) {
    while (next < course.time_s.size() && course.time_s[next] < at_s) ++next;
    const bool read = next < course.time_s.size() && course.time_s[next] == at_s;
    list.push_back(read ? Json(std::round(1e4 * (course.value[next] - zero)) / 1e4) : Json());
  }
  return list;
}

/// First reading from this instant on.
double zero_of(const Course& course, double from_s) {
  const auto first = std::lower_bound(course.time_s.begin(), course.time_s.end(), from_s);
  if (first == course.time_s.end()) return course.value.back();
  return course.value[static_cast<std::size_t>(first - course.time_s.begin())];
}

Json courses_json(const ThermalRecord& record, const Compensated& compensated, double zero_s) {
  std::vector<double> time_s, speed_rpm;
  const std::size_t every = record.time_s.size() / most_points + 1;
  for (std::size_t i = 0; i < record.time_s.size(); i += every) {
    time_s.push_back(record.time_s[i]);
    speed_rpm.push_back(record.speed_rpm[i]);
  }
  Json json{{"time_s", time_s}, {"speed_rpm", speed_rpm}};
  const auto add = [&](const char* key, const std::vector<Course>& courses, bool from_zero) {
    json[key] = Json::array();
    for (const Course& course : courses) {
      json[key].push_back(
          {{"name", course.name}, {"values", drawn(course, time_s, from_zero ? zero_of(course, zero_s) : 0.0)}});
    }
  };
  add("lengths", record.lengths, true);
  add("compensated", compensated.left, true);
  add("temperatures", record.temperatures, false);
  add("surroundings", record.surroundings, false);
  return json;
}

}  // namespace

Json thermal_report_json(const ThermalRecord& record, const Compensated& compensated, const SetUp& set_up) {
  const std::vector<Phase> phases = phases_of(record);
  std::vector<Phase> turning;
  Json phase_list = Json::array();
  for (const Phase& phase : phases) {
    if (phase.speed_rpm > 0.0) turning.push_back(phase);
    phase_list.push_back({{"from_s", phase.from_s}, {"until_s", phase.until_s}, {"speed_rpm", phase.speed_rpm}});
  }
  const bool stands_first = phases.front().speed_rpm == 0.0, stands_last = phases.back().speed_rpm == 0.0;
  const auto long_enough = [](const Phase& phase) { return phase.until_s - phase.from_s >= least_phase_s; };
  const double start_s = turning.empty() ? phases.front().from_s : turning.front().from_s;
  Json json{{"log", record.file}, {"set_up", Json::array()}, {"unused_columns", record.unused}};
  for (const auto& [name, text] : set_up) json["set_up"].push_back({{"name", name}, {"text", text}});
  json["compensation"] = compensated.by.empty() ? Json() : Json(compensated.by);
  json["from_s"] = record.time_s.front();
  json["until_s"] = record.time_s.back();
  json["rows"] = record.time_s.size();
  json["phases"] = phase_list;
  json["etve"] = stands_first && long_enough(phases.front()) ? standstill_json(record, phases.front()) : Json();
  json["rotation"] = rotation_json(record, compensated, turning);
  const bool cools = stands_last && !turning.empty() && long_enough(phases.back());
  json["cooling"] = cools ? standstill_json(record, phases.back()) : Json();
  json["time_constants"] = time_constants_json(record, phases, start_s);
  json["courses"] = courses_json(record, compensated, start_s);
  return json;
}

}  // namespace spindle_twin::host_tools
