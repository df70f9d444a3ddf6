#include "firmware/show/metrics.hpp"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include "firmware/show/shown_values.hpp"

namespace spindle_twin::firmware {
namespace {

/// What a number in `unit` is multiplied by to stand in Prometheus' base unit, and how that is called.
struct MetricUnit {
  std::string_view unit;
  std::string_view name;
  double factor;
};
constexpr std::array<MetricUnit, 16> units{{{"", "", 1.0},
                                            {"s", "seconds", 1.0},
                                            {"h", "seconds", 3600.0},
                                            {"min", "seconds", 60.0},
                                            {"um", "meters", 1e-6},
                                            {"mm", "meters", 1e-3},
                                            {"um/m", "ratio", 1e-6},
                                            {"degC", "celsius", 1.0},
                                            {"K", "kelvins", 1.0},
                                            {"K2", "kelvins_squared", 1.0},
                                            {"rpm", "revolutions_per_minute", 1.0},
                                            {"%", "ratio", 0.01},
                                            {"g/s", "grams_per_second", 1.0},
                                            {"A", "amperes", 1.0},
                                            {"W", "watts", 1.0},
                                            {"kW", "watts", 1000.0}}};

constexpr const MetricUnit* find_unit(std::string_view unit) {
  for (const MetricUnit& each : units) {
    if (each.unit == unit) return &each;
  }
  return nullptr;
}

static_assert(std::all_of(register_entries.begin(), register_entries.end(),
                          [](const RegisterEntry& entry) { return find_unit(entry.unit) != nullptr; }),
              "a register has a unit that `units` above does not name");

/// The label of one of the slots: key_points has the label key_point.
std::string label_of(std::string_view slot_names) {
  return slot_names.empty() ? "slot" : std::string(slot_names.substr(0, slot_names.size() - 1));
}

/// A label's value: backslash, quote and end of line are escaped.
std::string escaped(std::string_view text) {
  std::string out;
  for (const char each : text) {
    if (each == '\\' || each == '"') out += '\\';
    out += each == '\n' ? "\\n" : std::string(1, each);
  }
  return out;
}

struct Sample {
  std::string labels;  ///< without braces
  double value;
};

void write(std::string& out, const std::string& name, const char* type, std::string_view help,
           const std::vector<Sample>& samples) {
  if (samples.empty()) return;
  fmt::format_to(std::back_inserter(out), "# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  for (const Sample& sample : samples) {
    out += name;
    if (!sample.labels.empty()) out += "{" + sample.labels + "}";
    fmt::format_to(std::back_inserter(out), " {:.10g}\n", sample.value);
  }
}

/// Labels with a comma between them.
std::string joined(const std::string& one, const std::string& other) {
  return one.empty() || other.empty() ? one + other : one + "," + other;
}

std::string name_label(std::string_view name) {
  return name.empty() ? "" : fmt::format("spindle_name=\"{}\"", escaped(name));
}

void add_samples(const ShownRegisters& spindle, Register which, std::vector<Sample>& samples) {
  const RegisterEntry& entry = entry_of(which);
  const double factor = find_unit(entry.unit)->factor;
  for (const ShownValue& shown : shown_values(which, spindle.names)) {
    const double value = shown_value(spindle.image, shown);
    if (std::isnan(value)) continue;
    std::string labels = name_label(spindle.name);
    if (entry.slots > 1) {
      labels = joined(labels,
                      fmt::format("{}=\"{}\"", label_of(entry.slot_names),
                                  shown.slot_name != nullptr ? escaped(*shown.slot_name) : std::to_string(shown.slot)));
    }
    if (shown.bit != nullptr) labels = joined(labels, fmt::format("bit=\"{}\"", shown.bit->name));
    samples.push_back({labels, factor * value});
  }
}

void add_counts(std::string& out, const HttpCounts& counts) {
  std::vector<Sample> answers;
  for (const auto& [status, count] : counts.answers) {
    answers.push_back({fmt::format("code=\"{}\"", status), static_cast<double>(count)});
  }
  write(out, "spindle_twin_http_requests_total", "counter", "requests that the HTTP port has answered, by status",
        answers);
  write(out, "spindle_twin_http_dropped_total", "counter", "HTTP clients that were too slow, or made room for others",
        {{"", static_cast<double>(counts.dropped)}});
  write(out, "spindle_twin_http_connections", "gauge", "open HTTP connections",
        {{"", static_cast<double>(counts.connections)}});
  write(out, "spindle_twin_http_viewers", "gauge", "open event streams", {{"", static_cast<double>(counts.viewers)}});
}

void add_counts(std::string& out, const PlantCounts& counts) {
  const auto one = [](const auto& count) { return std::vector<Sample>{{"", static_cast<double>(count.load())}}; };
  write(out, "spindle_twin_plant_published_total", "counter", "samples that the plant's broker has read",
        one(counts.published));
  write(out, "spindle_twin_plant_dropped_total", "counter", "samples that the queue to the plant had no room for",
        one(counts.dropped));
  write(out, "spindle_twin_plant_waiting", "gauge", "samples in the queue to the plant", one(counts.waiting));
  write(out, "spindle_twin_plant_connected", "gauge", "1 while the plant's broker is connected", one(counts.connected));
}

}  // namespace

std::string metric_name(const RegisterEntry& entry) {
  std::string name = shown_name(entry);
  constexpr std::string_view count = "_count";
  if (name.ends_with(count)) name.replace(name.size() - count.size(), count.size(), "s");
  const std::string_view unit = find_unit(entry.unit)->name;
  if (!unit.empty()) name.append("_").append(unit);
  return "spindle_twin_" + name + (entry.metric == Metric::counter ? "_total" : "");
}

std::string metrics_text(const std::vector<ShownRegisters>& spindles, const HttpCounts& counts,
                         const PlantCounts* plant) {
  std::string out;
  std::vector<Sample> samples;
  for (const ShownRegisters& spindle : spindles) {
    const std::string what =
        fmt::format("version=\"{}\",spindle=\"{}\"", SPINDLE_TWIN_VERSION, escaped(spindle.names.spindle));
    samples.push_back({joined(name_label(spindle.name), what), 1.0});
  }
  write(out, "spindle_twin_build_info", "gauge", "always 1; which program, and which spindle", samples);
  for (std::size_t r = 0; r < register_entries.size(); ++r) {
    const RegisterEntry& entry = register_entries[r];
    if (!is_shown(entry)) continue;
    const char* type = entry.metric == Metric::counter ? "counter" : "gauge";
    samples.clear();
    for (const ShownRegisters& spindle : spindles) add_samples(spindle, static_cast<Register>(r), samples);
    write(out, metric_name(entry), type, entry.doc, samples);
  }
  add_counts(out, counts);
  if (plant != nullptr) add_counts(out, *plant);
  return out;
}

}  // namespace spindle_twin::firmware
