#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <sstream>
#include <string>
#include <vector>

#include "firmware/acquire/modbus_device.hpp"
#include "firmware/acquire/stream_device.hpp"
#include "firmware/config/config.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/support/recorded.hpp"
#include "tests/support/texts.hpp"

/// What the daemon takes where a configuration says nothing: each key's default by name, as it was when this was
/// recorded.
namespace spindle_twin::firmware {
namespace config_recorded_defaults_test {

constexpr tests::Tolerance tolerance{1e-11};

/// Every table, and in each only what is required.
const char* const least = R"([network]
file = "x.rom"
[serve]
[http]
[plant]
host = "broker"
node = "mill"
[[device]]
name = "cabinet"
address = "127.0.0.1"
[[device]]
name = "node"
driver = "stream"
port = 1504
[[sensor]]
key_point = "point 0"
device = "cabinet"
register = 0
[[displacement]]
output = "nose"
device = "cabinet"
register = 10
sd_um = 1.0
[signals]
speed = { source = "plc" }
load = { source = "device", device = "cabinet", register = 6 }
coolant = { source = "device", device = "cabinet", register = 8 }
ambient = { source = "constant", value = 22.0 }
[correction]
[health]
[health.tare]
[output]
[compensation]
[start]
[history]
path = "history.csv"
[checkpoint]
path = "twin.checkpoint"
)";

/// Lines "name value", or "name value value..." where there are several. Options of corrections and of health have
/// their range behind the value: least, most, and whether these ends are excluded.
class Lines {
 public:
  template <class... Values>
  void add(const std::string& name, const Values&... values) {
    text_ += name;
    (append(values), ...);
    text_ += '\n';
  }
  const std::string& text() const { return text_; }

 private:
  void append(const std::string& value) { text_ += " \"" + value + "\""; }
  void append(const char* value) { append(std::string(value)); }
  void append(bool value) { text_ += value ? " yes" : " no"; }
  template <class Number>
  void append(Number value) {
    char number[40];
    std::snprintf(number, sizeof number, " %.12g", static_cast<double>(value));
    text_ += number;
  }
  std::string text_;
};

void add_ranges(const std::string& name, const std::vector<AddressRange>& ranges, Lines& lines) {
  for (const AddressRange& range : ranges) lines.add(name, range.address, range.mask);
}

void add_ports(const Config& config, Lines& lines) {
  const ServePlan& serve = config.serve;
  lines.add("serve", serve.address, serve.port);
  lines.add("serve.connections, _per_host", serve.connections, serve.connections_per_host);
  lines.add("serve.idle_s, frame_deadline_s", serve.idle_s, serve.frame_deadline_s);
  add_ranges("serve.allow", serve.allow, lines);
  add_ranges("serve.allow_write", serve.write, lines);
  const ShowPlan& show = config.show;
  lines.add("http", show.enabled, show.address, show.port, show.names.size());
  add_ranges("http.allow", show.allow, lines);
  const PlantPlan& plant = config.plant;
  lines.add("plant", plant.enabled, plant.port, plant.group, plant.period_s, plant.queue, plant.registers.size(),
            plant.tls.has_value());
}

void add_devices(const SpindlePlan& plan, Lines& lines) {
  for (const DevicePlan& device : plan.devices) {
    lines.add("device", device.name);
    lines.add("device.poll_s, delay_s", device.poll_s, device.delay_s);
    lines.add("device.retry_s, retry_most_s", device.retry_s, device.retry_most_s);
    for (const Channel& channel : device.channels) {
      const Conversion& conversion = channel.conversion;
      lines.add("device.channel", channel.name, static_cast<int>(conversion.kind), conversion.scale, conversion.offset,
                conversion.unit.factor, conversion.unit.shift, static_cast<int>(channel.filter.kind));
    }
    if (const auto* modbus = dynamic_cast<const ModbusPlan*>(device.driver.get())) {
      lines.add("device.modbus", modbus->address, modbus->port, modbus->unit, modbus->timeout_s);
      for (const RegisterSource& source : modbus->sources) {
        lines.add("device.modbus.channel", static_cast<int>(source.table), source.address,
                  static_cast<int>(source.type));
      }
    }
    if (const auto* stream = dynamic_cast<const StreamPlan*>(device.driver.get())) {
      lines.add("device.stream", stream->address, stream->connections, stream->idle_s, stream->frame_deadline_s);
      add_ranges("device.stream.allow", stream->allow, lines);
    }
  }
}

void add_inputs(const CyclePlan& plan, Lines& lines) {
  const SensorPlan& sensor = plan.sensors[0];
  lines.add("sensor.min, max in K", sensor.min_K, sensor.max_K);
  lines.add("sensor.stale_after_s, interval_s, lag_s", sensor.stale_after_s, sensor.interval_s, sensor.lag_s);
  lines.add("sensor.noise_K, offset_K, resolution_K", sensor.noise_K, sensor.offset_deviation_K, sensor.resolution_K);
  const ProbePlan& probe = plan.probes[0];
  lines.add("displacement.min, max, sd in um", 1e6 * probe.min_m, 1e6 * probe.max_m, 1e6 * probe.deviation_m);
  lines.add("displacement.interval_s, stale_after_s", probe.interval_s, probe.stale_after_s);
  for (std::size_t s = 0; s < plan.signals.size(); ++s) {
    const SignalPlan& signal = plan.signals[s];
    if (signal.source == SignalSource::none) continue;
    lines.add("signals." + std::to_string(s), static_cast<int>(signal.source), signal.value, signal.min, signal.max,
              signal.stale_after_s, signal.most_per_s);
  }
}

void add_laws(const CyclePlan& plan, Lines& lines) {
  lines.add("correction: enabled, estimator, paper, corrects", plan.correction_enabled, plan.estimator.has_value(),
            plan.paper.has_value(), plan.estimator_corrects);
  const auto of = [&](const std::string& table) {
    return [&lines, table](const rom::Option& option, auto value) {
      const rom::Range& range = option.range;
      lines.add(table + std::string(option.key), value, range.min, range.max, range.min_excluded, range.max_excluded);
    };
  };
  if (plan.estimator) {
    correction::EstimatorOptions::each(*plan.estimator, of("correction."));
    correction::EstimatorPriors::each(plan.estimator->priors, of("correction.prior."));
  }
  if (plan.paper) {
    correction::PaperOptions::each(*plan.paper, of("correction."));
    correction::PaperGuards::each(plan.paper->guards, of("correction.guards."));
  }
  lines.add("health.enabled", plan.health.has_value());
  if (plan.health) correction::HealthLimits::each(*plan.health, of("health."));
  lines.add("health.return_within_K", plan.return_within_K);
  correction::TareLimits::each(plan.tare, of("health.tare."));
  lines.add("health.tare: to the ambient", plan.tare_to_ambient);
}

void add_outputs(const CyclePlan& plan, Lines& lines) {
  lines.add("output.slew_um_per_s", 1e6 * plan.slew_m_per_s);
  lines.add("output.limit_um of the nose", 1e6 * plan.output_limit_m[0]);
  const CompensationPlan& compensation = plan.compensation;
  lines.add("compensation.enabled, sign", compensation.enabled, compensation.sign);
  lines.add("compensation.slew_um_per_s, step_um", 1e6 * compensation.slew_m_per_s, 1e6 * compensation.step_m);
  lines.add("compensation.limit_um, warning_um", 1e6 * compensation.limit_m, 1e6 * compensation.warning_m);
  lines.add("compensation.on_loss, hold in s, decay in s", static_cast<int>(compensation.on_loss), compensation.hold_s,
            compensation.decay_s);
  lines.add("compensation.other, distance in m, reference in m", compensation.other, compensation.distance_m,
            compensation.reference_m);
  lines.add("compensation.look_ahead in s, settled_um, every so many cycles", plan.forecast.ahead_s,
            1e6 * plan.forecast.settled_m, plan.forecast.every_cycles);
}

void add_files(const Config& config, Lines& lines) {
  lines.add("log_level", config.log_level);
  lines.add("network: allow_uncertified, require_signature, keys", config.network.allow_uncertified,
            config.network.require_signature, config.network.trusted_keys.size());
  const HistoryPlan& history = config.history;
  lines.add("history", history.path, history.segment_bytes, history.most_bytes, history.most_days);
  const KeepPlan& keep = config.keep;
  lines.add("checkpoint", keep.checkpoint_path, keep.interval_s, keep.max_age_s);
  lines.add("parameters", keep.parameters_path);
  lines.add("orders", keep.orders_path);
}

std::string defaults_of(const std::string& text) {
  const Config config = parse_config(text, "/etc/twin.toml");
  const SpindlePlan plan = bind_config(config, rom::tests::make_network_with_laws());
  Lines lines;
  add_files(config, lines);
  lines.add("cycle.period_s, clock_rate, compare_uncorrected", plan.cycle.period_s, plan.cycle.clock_rate,
            plan.cycle.compare_uncorrected);
  lines.add("serve.plc_timeout_s", plan.cycle.plc_timeout_s);
  lines.add("start: temperature, wait_s", plan.cycle.start_temperature_K.has_value(), plan.cycle.start_wait_s);
  add_ports(config, lines);
  add_devices(plan, lines);
  add_inputs(plan.cycle, lines);
  add_laws(plan.cycle, lines);
  add_outputs(plan.cycle, lines);
  return lines.text();
}

/// Lines of `variant` that `base` has not.
std::string other_lines(const std::string& base, const std::string& variant) {
  std::istringstream lines(variant);
  std::string other;
  for (std::string line; std::getline(lines, line);) {
    if (("\n" + base).find("\n" + line + "\n") == std::string::npos) other += "  " + line + "\n";
  }
  return other;
}

/// Each variant with what it changes in the defaults of other keys.
TEST(RecordedDefaults, of_a_configuration_that_says_the_least) {
  const std::string text = least;
  const std::string defaults = defaults_of(text);
  std::string now = defaults;
  const auto one_line = [](std::string lines) {
    std::replace(lines.begin(), lines.end(), '\n', ' ');
    return lines;
  };
  const auto vary = [&](const std::string& what, const std::string& instead) {
    now += "with " + (instead.empty() ? "nothing" : one_line(instead)) + " in place of " + one_line(what) + "\n" +
           other_lines(defaults, defaults_of(tests::with(text, what, instead)));
  };
  vary("[correction]", "[correction]\nlaw = \"paper\"");
  vary("[correction]", "[correction]\nlaw = \"none\"");
  vary("[health]", "[health]\nenabled = false");
  vary("[serve]", "[cycle]\nperiod_s = 30.0\n[serve]");
  vary("[serve]", "[cycle]\nclock_rate = 10.0\n[serve]");
  vary("register = 0", "register = 0\ninterval_s = 10.0");
  vary("register = 0", "register = 0\nmean_s = 4.0");
  vary("register = 0", "register = 0\ntype = \"float32\"");
  vary("[[device]]", "[[device]]\nretry_s = 20.0");
  vary("history.csv", "history.sqlite");
  vary("[checkpoint]\npath = \"twin.checkpoint\"", "");
  vary("[checkpoint]", "[orders]\npath = \"twin.orders\"\n[checkpoint]");
  tests::expect_as_recorded("configuration_defaults.txt", now, tolerance);
}

std::string history_of(const std::string& keys) {
  try {
    const HistoryPlan plan =
        parse_config(tests::with(least, "path = \"history.csv\"\n", keys), "/etc/twin.toml").history;
    Lines lines;
    lines.add("taken", plan.segment_bytes, plan.most_bytes, plan.most_days);
    return lines.text();
  } catch (const rom::InputError& error) {
    return std::string(error.what()) + "\n";
  }
}

/// Sizes and days of both kinds of history, which bound each other: at their limits and beyond.
TEST(RecordedDefaults, of_a_history_that_is_bounded) {
  std::string now;
  const auto add = [&](const std::string& kind, const std::string& keys) {
    now += kind + ", " + keys + " -> " + history_of("path = \"history." + kind + "\"\n" + keys + "\n");
  };
  for (const char* const keys :
       {"", "segment_MiB = 100.0", "segment_MiB = 512.0", "segment_MiB = 513.0", "segment_MiB = 0.01",
        "segment_MiB = 0.0099", "segment_MiB = 1e5", "segment_MiB = 100001.0", "most_MiB = 128.0", "most_MiB = 127.9",
        "most_MiB = 1e7", "most_MiB = 2e7", "most_days = 3.0"}) {
    add("csv", keys);
  }
  for (const char* const keys :
       {"", "most_MiB = 16.0", "most_MiB = 15.9", "most_MiB = 1e7", "most_MiB = 2e7", "most_days = 0.01",
        "most_days = 0.0099", "most_days = 36500.0", "most_days = 36501.0", "segment_MiB = 64.0"}) {
    add("sqlite", keys);
  }
  tests::expect_as_recorded("configuration_history.txt", now, tolerance);
}

}  // namespace config_recorded_defaults_test
}  // namespace spindle_twin::firmware
