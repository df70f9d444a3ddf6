#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "firmware/config/config.hpp"
#include "rom/read/input_error.hpp"

/// Every number of the configuration is taken up to the ends of its range, and refused beyond with its name.
namespace spindle_twin::firmware {
namespace config_ranges_test {

constexpr double other_key = std::numeric_limits<double>::quiet_NaN();  ///< an end that another key sets

struct Bounds {
  const char* section;  ///< as in `sections`
  const char* key;
  double lowest, highest;  ///< both allowed
  bool whole = false;
};

struct Section {
  const char* name;
  const char* header;
  const char* keys;  ///< that it needs besides the one in question
};

constexpr Section sections[] = {
    {"cycle", "[cycle]", ""},
    {"serve", "[serve]", ""},
    {"http", "[http]", ""},
    {"plant", "[plant]", "host = \"h\"\nnode = \"n\"\n"},
    {"device", "[[device]]", "name = \"d\"\n"},
    {"stream", "[[device]]", "name = \"s\"\ndriver = \"stream\"\n"},
    {"sensor", "[[sensor]]", "key_point = \"k\"\ndevice = \"d\"\n"},
    {"displacement", "[[displacement]]", "output = \"o\"\ndevice = \"d\"\n"},
    {"health", "[health]", ""},
    {"output", "[output]", ""},
    {"compensation", "[compensation]", ""},
    {"start", "[start]", ""},
    {"history", "[history]", "path = \"h.sqlite\"\n"},
    {"checkpoint", "[checkpoint]", "path = \"c\"\n"},
    {"signals.speed", "[signals.speed]", "source = \"constant\"\n"},
    {"signals.load", "[signals.load]", "source = \"constant\"\n"},
    {"signals.coolant", "[signals.coolant]", "source = \"constant\"\n"},
    {"signals.ambient", "[signals.ambient]", "source = \"constant\"\n"},
    {"signals.current", "[signals.current]", "source = \"constant\"\n"},
    {"signals.power", "[signals.power]", "source = \"constant\"\n"},
    {"signals.flow.jacket", "[signals.flow.jacket]", "source = \"constant\"\n"},
    {"signals.heat.motor", "[signals.heat.motor]", "source = \"constant\"\n"},
};

/// What a key gets where it is not in question, because its table would be refused without.
std::string needed(const std::string& section, const std::string& asked) {
  std::string keys;
  const auto add = [&](const std::string& of, const std::string& key, const std::string& value) {
    if (section == of && key != asked) keys.append(key).append(" = ").append(value).append("\n");
  };
  add("stream", "port", "1504");
  add("sensor", "register", "0");
  add("displacement", "register", "4");
  add("displacement", "sd_um", "1.0");
  if (section.starts_with("signals.")) add(section, "value", "1.0");
  return keys;
}

std::string error_with(const Bounds& bounds, const std::string& value) {
  std::string text = "network = \"x.rom\"\n";
  for (const Section& section : sections) {
    const bool asked = std::string(section.name) == bounds.section;
    text.append(section.header).append("\n").append(section.keys);
    text.append(needed(section.name, asked ? bounds.key : ""));
    if (asked) text.append(bounds.key).append(" = ").append(value).append("\n");
  }
  try {
    parse_config(text, "/etc/twin.toml");
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "";
}

std::string written(double value, bool whole) {
  char text[64];
  std::snprintf(text, sizeof text, whole ? "%.0f" : "%.12e", value);
  return text;
}

const std::vector<Bounds> all_bounds = {
    {"cycle", "period_s", 0.01, 60.0},
    {"cycle", "clock_rate", 0.1, 1000.0},
    {"serve", "port", 1, 65535, true},
    {"serve", "connections", 1, 256, true},
    {"serve", "connections_per_host", 1, 256, true},
    {"serve", "idle_s", 1.0, 86400.0},
    {"serve", "frame_deadline_s", 0.05, 60.0},
    {"serve", "plc_timeout_s", 0.0, 86400.0},
    {"http", "port", 1, 65535, true},
    {"plant", "port", 1, 65535, true},
    {"plant", "period_s", 0.1, 3600.0},
    {"plant", "queue", 1, 10000, true},
    {"device", "port", 1, 65535, true},
    {"device", "unit", 0, 255, true},
    {"device", "timeout_s", 0.01, 10.0},
    {"device", "poll_s", 0.01, 3600.0},
    {"device", "delay_s", 0.0, 60.0},
    {"device", "retry_s", 0.05, 60.0},
    {"device", "retry_most_s", other_key, 3600.0},
    {"stream", "port", 1, 65535, true},
    {"stream", "connections", 1, 64, true},
    {"stream", "idle_s", 0.1, 86400.0},
    {"stream", "frame_deadline_s", 0.05, 60.0},
    {"sensor", "register", 0, 65534, true},
    {"sensor", "min_degC", -50.0, other_key},
    {"sensor", "max_degC", other_key, 300.0},
    {"sensor", "interval_s", 0.0, 3600.0},
    {"sensor", "mean_s", 1e-3, 3600.0},
    {"sensor", "low_pass_s", 1e-3, 3600.0},
    {"displacement", "sd_um", 1e-3, 1e3},
    {"displacement", "interval_s", 1.0, 86400.0},
    {"compensation", "reference_mm", -1e5, 1e5},
    {"compensation", "step_um", 0.0, 100.0},
    {"compensation", "hold_min", 0.0, 10080.0},
    {"compensation", "decay_min", 0.1, 10080.0},
    {"start", "temperature_degC", -50.0, 300.0},
    {"history", "most_days", 0.01, 36500.0},
    {"history", "most_MiB", 16.0, 1e7},
    {"checkpoint", "interval_s", 1.0, 86400.0},
    {"checkpoint", "max_age_h", 0.0, 8760.0},
    {"signals.speed", "value", -200000.0, 200000.0},
    {"signals.load", "value", -10.0, 10.0},
    {"signals.coolant", "value", -50.0, 300.0},
    {"signals.ambient", "value", -50.0, 300.0},
    {"signals.current", "value", -1e4, 1e4},
    {"signals.power", "value", -1e6, 1e6},
    {"signals.flow.jacket", "value", -10.0, 10.0},
    {"signals.heat.motor", "value", -1e6, 1e6},
};

TEST(Ranges, every_number_is_taken_up_to_its_ends_and_refused_beyond) {
  for (const Bounds& bounds : all_bounds) {
    SCOPED_TRACE(std::string(bounds.section) + "." + bounds.key);
    for (const auto& [end, outwards] : {std::pair{bounds.lowest, -1.0}, {bounds.highest, 1.0}}) {
      if (std::isnan(end)) continue;
      EXPECT_EQ(error_with(bounds, written(end, bounds.whole)), "");
      const double beyond = end + outwards * (bounds.whole ? 1.0 : 1e-6 * std::max(1e-3, std::abs(end)));
      const std::string error = error_with(bounds, written(beyond, bounds.whole));
      EXPECT_NE(error.find(std::string(bounds.key) + ": "), std::string::npos) << written(beyond, false) << error;
    }
  }
}

TEST(Ranges, of_lengths_that_must_not_be_zero_end_at_ten_millimetres) {
  for (const Bounds& bounds :
       {Bounds{"output", "limit_um", 0.0, 1e4}, Bounds{"compensation", "limit_um", 0.0, 1e4},
        Bounds{"compensation", "warning_um", 0.0, 1e4}, Bounds{"compensation", "settled_um", 0.0, 1e4}}) {
    SCOPED_TRACE(std::string(bounds.section) + "." + bounds.key);
    EXPECT_NE(error_with(bounds, "0.0"), "");
    EXPECT_EQ(error_with(bounds, "0.001"), "");
    EXPECT_EQ(error_with(bounds, "10000.0"), "");
    EXPECT_NE(error_with(bounds, "10000.1"), "");
  }
}

TEST(Ranges, the_compensations_sign_is_one_or_minus_one) {
  for (const char* sign : {"-2", "0", "2"}) EXPECT_NE(error_with({"compensation", "sign", -1, 1, true}, sign), "");
  for (const char* sign : {"-1", "1"}) EXPECT_EQ(error_with({"compensation", "sign", -1, 1, true}, sign), "");
}

}  // namespace config_ranges_test
}  // namespace spindle_twin::firmware
