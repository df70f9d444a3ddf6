#include "firmware/show/metrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace show_metrics_test {

std::string metrics_of(const Snapshot& snapshot, ShownNames names = names_of(tests::small_network())) {
  RegisterImage image{};
  fill_image(snapshot, 0, image);
  return metrics_text({{image, names}}, {});
}

TEST(Metrics, names_are_prometheus_names_and_none_stands_twice) {
  std::set<std::string> seen;
  for (const RegisterEntry& entry : register_entries) {
    if (entry.command || entry.metric == Metric::none) continue;
    const std::string name = metric_name(entry);
    EXPECT_TRUE(seen.insert(name).second) << name;
    for (const char each : name) EXPECT_TRUE(std::islower(each) || std::isdigit(each) || each == '_') << name;
    EXPECT_EQ(name.ends_with("_total"), entry.metric == Metric::counter) << name;
    EXPECT_FALSE(name.ends_with("_count")) << name;
  }
}

TEST(Metrics, what_a_register_repeats_in_another_form_is_given_once) {
  for (const RegisterEntry& entry : register_entries) {
    const std::string doc = entry.doc;
    const bool repeats = doc == "the same" || doc.starts_with("the same,") || doc.starts_with("the same plus");
    if (repeats && entry.type != RegisterType::float32) {
      EXPECT_EQ(entry.metric, Metric::none) << entry.name;
    }
  }
}

TEST(Metrics, lengths_are_in_meters_ratios_without_percent_and_power_in_watts) {
  Snapshot snapshot = first_snapshot(tests::small_network());
  snapshot.nose_m = 12.5e-6;
  snapshot.signals[static_cast<std::size_t>(Signal::load)] = 0.5;
  snapshot.signals[static_cast<std::size_t>(Signal::power)] = 2500.0;
  const std::string text = metrics_of(snapshot);
  EXPECT_NE(text.find("\nspindle_twin_nose_meters 1.25e-05\n"), std::string::npos);
  EXPECT_NE(text.find("\nspindle_twin_load_ratio 0.5\n"), std::string::npos);
  EXPECT_NE(text.find("\nspindle_twin_motor_power_watts 2500\n"), std::string::npos);
}

TEST(Metrics, what_is_not_present_has_no_sample_and_bits_have_one_each) {
  Snapshot snapshot = first_snapshot(tests::small_network());
  snapshot.fault = bits(Fault::orders_lost);
  const std::string text = metrics_of(snapshot);
  EXPECT_EQ(text.find("spindle_twin_motor_current"), std::string::npos);
  EXPECT_NE(text.find("\nspindle_twin_fault{bit=\"orders_lost\"} 1\n"), std::string::npos);
  EXPECT_NE(text.find("\nspindle_twin_fault{bit=\"history_lost\"} 0\n"), std::string::npos);
}

TEST(Metrics, a_name_with_quotes_backslashes_and_line_ends_is_escaped) {
  Snapshot snapshot = first_snapshot(tests::small_network());
  snapshot.predicted_K[0] = 300.0;
  ShownNames names = names_of(tests::small_network());
  names.key_points[0] = "a\"b\\c\nd";
  EXPECT_NE(metrics_of(snapshot, names).find("{key_point=\"a\\\"b\\\\c\\nd\"}"), std::string::npos);
}

TEST(Metrics, of_several_spindles_stand_together_with_a_label_each) {
  Snapshot one = first_snapshot(tests::small_network()), other = one;
  one.nose_m = 1e-6;
  other.nose_m = 2e-6;
  other.fault = bits(Fault::orders_lost);
  const ShownNames names = names_of(tests::small_network());
  RegisterImage one_image{}, other_image{};
  fill_image(one, 0, one_image);
  fill_image(other, 0, other_image);
  const std::string text = metrics_text({{one_image, names, "left"}, {other_image, names, "right"}}, {});
  EXPECT_NE(text.find("spindle_twin_nose_meters{spindle_name=\"left\"} 1e-06\n"
                      "spindle_twin_nose_meters{spindle_name=\"right\"} 2e-06\n"),
            std::string::npos);
  EXPECT_NE(text.find("spindle_twin_fault{spindle_name=\"right\",bit=\"orders_lost\"} 1\n"), std::string::npos);
  EXPECT_EQ(text.find("# TYPE spindle_twin_nose_meters"), text.rfind("# TYPE spindle_twin_nose_meters"));
}

/// Each register says three of its steps, or 3.
TEST(Metrics, each_register_that_is_shown_stands_there_in_base_units_as_often_as_it_has_slots_with_a_name) {
  const std::map<std::string, double> base_units{
      {"", 1.0},  {"s", 1.0},  {"h", 3600.0}, {"min", 60.0}, {"um", 1e-6}, {"mm", 1e-3}, {"um/m", 1e-6}, {"degC", 1.0},
      {"K", 1.0}, {"K2", 1.0}, {"rpm", 1.0},  {"%", 0.01},   {"g/s", 1.0}, {"A", 1.0},   {"W", 1.0},     {"kW", 1e3}};
  const ShownNames names = names_of(tests::small_network());
  RegisterImage image{};
  const auto number = [](const RegisterEntry& entry) { return 3.0 * entry.resolution; };
  for (std::size_t r = 0; r < register_entries.size(); ++r) {
    const RegisterEntry& entry = register_entries[r];
    for (int slot = 0; slot < entry.slots; ++slot) put(image, static_cast<Register>(r), number(entry), slot);
  }
  std::multimap<std::string, double> samples;
  std::istringstream text(metrics_text({{image, names}}, {}));
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with('#')) continue;
    samples.emplace(line.substr(0, line.find_first_of("{ ")), std::stod(line.substr(line.rfind(' ') + 1)));
  }
  for (const RegisterEntry& entry : register_entries) {
    if (entry.command || entry.metric == Metric::none) continue;
    const auto [begin, end] = samples.equal_range(metric_name(entry));
    const std::vector<std::string>* slots = names.of(entry.slot_names);
    std::size_t wanted = slots != nullptr ? std::min<std::size_t>(slots->size(), entry.slots) : entry.slots;
    if (entry.codes_are_bits) wanted *= entry.codes.size();
    EXPECT_EQ(static_cast<std::size_t>(std::distance(begin, end)), wanted) << entry.name;
    for (auto each = begin; each != end && !entry.codes_are_bits; ++each) {
      EXPECT_NEAR(each->second / (base_units.at(entry.unit) * number(entry)), 1.0, 1e-6) << entry.name;
    }
  }
}

TEST(Metrics, counts_of_the_port_and_of_the_plant_stand_behind_the_registers) {
  RegisterImage image{};
  const ShownNames names = names_of(tests::small_network());
  HttpCounts counts;
  counts.answers = {{200, 7}, {404, 2}};
  counts.dropped = 3;
  counts.connections = 5;
  counts.viewers = 4;
  PlantCounts plant;
  plant.published = 11, plant.dropped = 12, plant.waiting = 13, plant.connected = 1;
  const std::string text = metrics_text({{image, names}}, counts, &plant);
  for (const char* line : {"http_requests_total{code=\"200\"} 7", "http_requests_total{code=\"404\"} 2",
                           "http_dropped_total 3", "http_connections 5", "http_viewers 4", "plant_published_total 11",
                           "plant_dropped_total 12", "plant_waiting 13", "plant_connected 1"}) {
    EXPECT_NE(text.find(std::string("\nspindle_twin_") + line + "\n"), std::string::npos) << line;
  }
  EXPECT_NE(text.find("spindle_twin_build_info{version=\"" SPINDLE_TWIN_VERSION "\",spindle=\"small\"} 1\n"),
            std::string::npos);
  EXPECT_EQ(metrics_text({{image, names}}, counts).find("spindle_twin_plant_"), std::string::npos);
}

}  // namespace show_metrics_test
}  // namespace spindle_twin::firmware
