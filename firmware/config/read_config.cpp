#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "firmware/acquire/read_address.hpp"
#include "firmware/config/config.hpp"
#include "firmware/config/read_compensation.hpp"
#include "firmware/config/read_correction.hpp"
#include "firmware/config/read_exchange.hpp"
#include "firmware/config/read_files.hpp"
#include "firmware/config/read_health.hpp"
#include "firmware/config/read_served.hpp"
#include "rom/read/strict_toml.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

using rom::TomlTable;

constexpr double coldest_degC = -50.0;
constexpr double hottest_degC = 300.0;
using rom::m_per_um;
constexpr Unit celsius{1.0, zero_degC_K};

/// How old the device's delay and the channel's filter make a reading at most; model time.
double added_age_s(const ConfiguredChannel& channel, const Config& config) {
  constexpr double of_a_mean = 1.5;  // from the middle of a window to the end of the next
  const double share = channel.filter.kind == FilterPlan::Kind::mean ? of_a_mean : 1.0;
  return config.cycle.clock_rate * (config.devices[channel.device].delay_s + share * channel.filter.time_s);
}

/// How long a reading may stay the newest that there is; model time. A device that is not polled sends when it likes.
double between_readings_s(const ConfiguredChannel& channel, const Config& config) {
  return config.cycle.clock_rate * config.devices[channel.device].poll_s;
}

/// `stale_after_s` of a channel, 0 where `range` has it: never. Not given, three times what lies between its readings,
/// at least `least_s`.
double read_stale_after(const TomlTable& table, const ConfiguredChannel& channel, double least_s,
                        const rom::Range& range, const Config& config) {
  const double between_s = between_readings_s(channel, config);
  const double stale_after_s =
      table.number_or("stale_after_s", std::max(least_s, 3.0 * between_s) + added_age_s(channel, config), range);
  constexpr double rounding = 1e-9;  // of poll_s / clock_rate * clock_rate
  const bool never = stale_after_s == 0.0;
  if (!never && stale_after_s < between_s * (1.0 - rounding)) {
    table.fail("stale_after_s", "must be at least the " + rom::printed(between_s) +
                                    " s between two readings of its device (poll_s), or none is fresh to the end; is " +
                                    rom::printed(stale_after_s));
  }
  return stale_after_s;
}

/// Two of one kind that read one place are one cable written down twice.
template <typename Configured>
void refuse_same_place(const TomlTable& table, const char* key, const std::optional<ConfiguredChannel>& channel,
                       const std::vector<Configured>& others, std::string Configured::*name) {
  const std::string own = table.string(key);
  for (const Configured& other : others) {
    const std::optional<ConfiguredChannel> taken = other.channel;
    if (own == other.*name) continue;  // said where names are bound
    if (!channel || !taken || channel->device != taken->device || channel->place != taken->place) continue;
    table.fail(key, channel->place + " is read for \"" + other.*name + "\" already; each needs its own");
  }
}

struct SignalRules {
  double first;  ///< used until the first good reading, in the configuration's unit; NaN: not known until then
  double min;
  double max;
  Unit unit;
};

ConfiguredSignal read_signal(const TomlTable& signals, const std::string& name, const SignalRules& rules,
                             Config& config) {
  const TomlTable table = signals.table(name);
  ConfiguredSignal signal;
  signal.where = signals.where(name);
  signal.field = signals.path(name);
  signal.has_first = table.has("first") || table.has("value");
  const std::string from = table.choice("source", {"device", "plc", "constant"});
  double first = 0.0;
  if (from == "constant") {
    signal.plan.source = SignalSource::constant;
    first = table.number("value", rom::between(rules.min, rules.max));
  } else {
    signal.plan.source = from == "device" ? SignalSource::device : SignalSource::plc;
    if (from == "device") {
      if (config.devices.empty()) table.fail("source", "is \"device\", but there is no [[device]] table");
      signal.channel = read_channel(table, rules.unit, config.cycle.clock_rate, config.devices);
      signal.plan.stale_after_s = read_stale_after(table, *signal.channel, 3.0, rom::not_negative, config);
    } else {
      signal.plan.stale_after_s = table.number_or("stale_after_s", 0.0, rom::not_negative);
    }
    first = table.number_or("first", rules.first, rom::between(rules.min, rules.max));
  }
  const auto si = [&](double value) { return value * rules.unit.factor + rules.unit.shift; };
  if (from != "constant") {
    signal.min = table.optional_number("min", rom::between(rules.min, rules.max));
    signal.max = table.optional_number("max", rom::between(rules.min, rules.max));
    if (signal.min && signal.max && *signal.max <= *signal.min) table.fail("max", "must be above min");
    if (table.has("first") && (first < signal.min.value_or(first) || first > signal.max.value_or(first))) {
      table.fail("first", "must lie from min to max, is " + rom::printed(first));
    }
    signal.most_per_s = table.optional_number("max_per_s", rom::positive);
    if (signal.min) signal.min = si(*signal.min);
    if (signal.max) signal.max = si(*signal.max);
    if (signal.most_per_s) *signal.most_per_s *= rules.unit.factor;
  }
  signal.plan.value = si(first);
  signal.plan.min = si(rules.min);
  signal.plan.max = si(rules.max);
  return signal;
}

/// One table per coolant circuit, by its name.
std::vector<ConfiguredFlow> read_flows(const TomlTable& table, Config& config) {
  constexpr double most_kg_per_s = 10.0;
  std::vector<ConfiguredFlow> flows;
  for (const std::string& circuit : table.free_keys()) {
    constexpr SignalRules rules{0.0, -most_kg_per_s, most_kg_per_s, {}};
    flows.push_back({circuit, read_signal(table, circuit, rules, config)});
  }
  return flows;
}

/// One table per measured heat, by its name.
std::vector<ConfiguredHeat> read_heats(const TomlTable& table, Config& config) {
  constexpr double most_W = 1e6;
  std::vector<ConfiguredHeat> heats;
  for (const std::string& heat : table.free_keys()) {
    const SignalRules rules{not_a_value, -most_W, most_W, {}};
    heats.push_back({heat, read_signal(table, heat, rules, config)});
  }
  return heats;
}

/// `temperature_degC` as a table: one key per node.
std::vector<ConfiguredStart> read_start(const TomlTable& start) {
  const TomlTable table = start.table("temperature_degC");
  std::vector<ConfiguredStart> nodes;
  for (const std::string& node : table.free_keys()) {
    const double kelvin = table.number(node, rom::between(coldest_degC, hottest_degC)) + zero_degC_K;
    nodes.push_back({node, kelvin, table.where(node), table.path(node)});
  }
  if (nodes.empty()) start.fail("temperature_degC", "must give at least one node its temperature");
  return nodes;
}

/// `limit_um` as one number or as a table: one key per deformation output.
std::vector<ConfiguredLimit> read_limits(const TomlTable& output) {
  constexpr rom::Range limit_um{0.0, 1e4, true, false};
  std::vector<ConfiguredLimit> limits;
  const auto add = [&](const TomlTable& table, const std::string& key, const std::string& name) {
    limits.push_back({name, m_per_um * table.number(key, limit_um), table.where(key), table.path(key)});
  };
  if (!output.is_table("limit_um")) {
    if (output.has("limit_um")) add(output, "limit_um", "");
    return limits;
  }
  const TomlTable table = output.table("limit_um");
  for (const std::string& name : table.free_keys()) add(table, name, name);
  return limits;
}

ConfiguredSensor read_sensor(const TomlTable& table, Config& config) {
  ConfiguredSensor sensor;
  sensor.key_point = table.string("key_point");
  sensor.where = table.where("key_point");
  sensor.field = table.path("key_point");
  sensor.channel = read_channel(table, celsius, config.cycle.clock_rate, config.devices);
  sensor.min_degC = table.number_or("min_degC", sensor.min_degC, rom::between(coldest_degC, hottest_degC));
  sensor.max_degC = table.number_or("max_degC", sensor.max_degC, rom::between(coldest_degC, hottest_degC));
  if (sensor.max_degC <= sensor.min_degC) table.fail("max_degC", "must be above min_degC");
  sensor.interval_s = table.number_or("interval_s", sensor.interval_s, rom::between(0.0, 3600.0));
  sensor.stale_after_s = read_stale_after(
      table, *sensor.channel, std::max(sensor.stale_after_s, 3.0 * sensor.interval_s), rom::positive, config);
  sensor.noise_K = table.optional_number("noise_K", correction::noise_range_K);
  sensor.offset_deviation_K = table.optional_number("offset_K", correction::offset_range_K);
  sensor.lag_s = table.optional_number("lag_s", correction::lag_range_s);
  sensor.resolution_K = table.optional_number("resolution_K", resolution_range_K);
  return sensor;
}

ConfiguredProbe read_probe(const TomlTable& table, Config& config) {
  const rom::Range limits_um = rom::between(-1e4, 1e4);
  ConfiguredProbe probe;
  probe.output = table.string("output");
  probe.where = table.where("output");
  probe.field = table.path("output");
  probe.channel = read_channel(table, {m_per_um, 0.0}, config.cycle.clock_rate, config.devices);
  ProbePlan& plan = probe.plan;
  plan.configured = true;
  plan.deviation_m = m_per_um * table.number("sd_um", rom::between(1e-3, 1e3));
  plan.min_m = m_per_um * table.number_or("min_um", plan.min_m / m_per_um, limits_um);
  plan.max_m = m_per_um * table.number_or("max_um", plan.max_m / m_per_um, limits_um);
  if (plan.max_m <= plan.min_m) table.fail("max_um", "must be above min_um");
  plan.interval_s = table.number_or("interval_s", plan.interval_s, rom::between(1.0, 86400.0));
  plan.stale_after_s = table.number_or("stale_after_s", plan.stale_after_s, rom::positive);
  return probe;
}

rom::PublicKey read_trusted_key(const TomlTable& table, const std::string& text, const std::string& path) {
  rom::PublicKey key{};
  if (rom::parse_public_key(text, key)) return key;
  if (text.ends_with(".pub")) return rom::read_public_key(beside(path, text));
  table.fail("trusted_keys", "every entry must be 64 hex digits or a .pub file, is \"" + text + "\"");
}

/// `network = "x.rom"`, or a table where more is to be said than the file's name.
ConfiguredNetwork read_network_table(const TomlTable& root, const std::string& path) {
  ConfiguredNetwork network;
  network.where = root.where("network");
  network.field = root.path("network");
  if (!root.is_table("network")) {
    network.path = beside(path, root.string("network"));
    return network;
  }
  const TomlTable table = root.table("network");
  network.where = table.where("file");
  network.path = beside(path, table.string("file"));
  network.allow_uncertified = table.boolean_or("allow_uncertified", false);
  network.require_signature = table.boolean_or("require_signature", false);
  for (const std::string& text : table.strings_or_empty("trusted_keys")) {
    network.trusted_keys.push_back(read_trusted_key(table, text, path));
    if (text.ends_with(".pub")) network.key_files.push_back(beside(path, text));
  }
  if (network.require_signature && network.trusted_keys.empty()) {
    table.fail("trusted_keys", "at least one key is needed where require_signature is true");
  }
  return network;
}

/// [cycle]: the period and how fast the clock runs.
void read_cycle(const TomlTable& root, CyclePlan& plan) {
  const auto cycle = root.optional_table("cycle");
  if (!cycle) return;
  plan.period_s = cycle->number_or("period_s", plan.period_s, rom::between(0.01, 60.0));
  plan.clock_rate = cycle->number_or("clock_rate", plan.clock_rate, rom::between(0.1, 1000.0));
  plan.compare_uncorrected = cycle->boolean_or("compare_uncorrected", plan.compare_uncorrected);
  const double period_s = plan.period_s / plan.clock_rate;
  if (period_s < 0.001) {
    cycle->fail("clock_rate", "period_s / clock_rate must be at least 0.001 s, is " + std::to_string(period_s));
  }
}

/// [[device]] and what is read from them: [[sensor]] and [[displacement]].
void read_inputs(const TomlTable& root, Config& config, Listeners& listeners) {
  config.devices = read_devices(root, config.cycle.clock_rate, listeners);
  for (const TomlTable& table : root.tables_or_empty("sensor")) {
    if (config.devices.empty()) table.fail("key_point", "sensors need a [[device]] table");
    ConfiguredSensor sensor = read_sensor(table, config);
    refuse_same_place(table, "key_point", sensor.channel, config.sensors, &ConfiguredSensor::key_point);
    config.sensors.push_back(std::move(sensor));
  }
  for (const TomlTable& table : root.tables_or_empty("displacement")) {
    if (config.devices.empty()) table.fail("output", "displacement probes need a [[device]] table");
    ConfiguredProbe probe = read_probe(table, config);
    refuse_same_place(table, "output", probe.channel, config.probes, &ConfiguredProbe::output);
    config.probes.push_back(std::move(probe));
  }
}

/// [signals]: what the machine is doing.
void read_signals(const TomlTable& root, Config& config) {
  const TomlTable signals = root.table("signals");
  config.signals_where = root.where("signals");
  struct NamedRules {
    const char* name;
    SignalRules rules;
  };
  const std::array<NamedRules, first_flow_signal> named{{{"speed", {0.0, -200000.0, 200000.0, {}}},
                                                         {"load", {0.0, -10.0, 10.0, {}}},
                                                         {"coolant", {20.0, coldest_degC, hottest_degC, celsius}},
                                                         {"ambient", {20.0, coldest_degC, hottest_degC, celsius}},
                                                         {"current", {not_a_value, -1e4, 1e4, {}}},
                                                         {"power", {not_a_value, -1e6, 1e6, {}}}}};
  for (std::size_t s = 0; s < named.size(); ++s) {
    if (s >= first_optional_signal && !signals.has(named[s].name)) continue;
    config.signals[s] = read_signal(signals, named[s].name, named[s].rules, config);
  }
  if (const auto flows = signals.optional_table("flow")) config.flows = read_flows(*flows, config);
  if (const auto heats = signals.optional_table("heat")) config.heats = read_heats(*heats, config);
}

/// [output]: how fast and how far a published value may move.
void read_output(const TomlTable& root, Config& config) {
  const auto output = root.optional_table("output");
  if (!output) return;
  config.cycle.slew_m_per_s =
      m_per_um * output->number_or("slew_um_per_s", config.cycle.slew_m_per_s / m_per_um, rom::positive);
  config.output_limits = read_limits(*output);
}

/// [start]: the temperatures before the first reading; needed where no sensor tells them.
void read_start_temperature(const TomlTable& root, Config& config) {
  const auto start = root.optional_table("start");
  if (start && start->is_table("temperature_degC")) {
    config.start = read_start(*start);
  } else if (start && start->has("temperature_degC")) {
    config.cycle.start_temperature_K =
        start->number("temperature_degC", rom::between(coldest_degC, hottest_degC)) + zero_degC_K;
    config.start_where = start->where("temperature_degC");
  } else if (config.sensors.empty()) {
    root.fail("start", "temperature_degC is required here when there is no sensor to start from");
  }
  if (start) config.cycle.start_wait_s = start->number_or("wait_s", config.cycle.start_wait_s, rom::positive);
}

/// The tables that every spindle has, alone or among several.
void read_spindle(const TomlTable& root, Config& config, Listeners& listeners) {
  read_inputs(root, config, listeners);
  read_signals(root, config);
  read_correction(root.optional_table("correction"), config);
  read_health(root.optional_table("health"), config);
  read_output(root, config);
  read_compensation(root.optional_table("compensation"), config);
  read_start_temperature(root, config);
  read_files(root, config);
  read_exchange(root.optional_table("exchange"), config);
  root.finish();
}

constexpr double plc_timeout_s = 10.0;

void read_plc_timeout(const TomlTable& serve, Config& config) {
  config.cycle.plc_timeout_s = serve.number_or("plc_timeout_s", plc_timeout_s, rom::between(0.0, 86400.0));
}

Config read_root(const TomlTable& root, const std::string& path) {
  Config config;
  config.path = path;
  config.network = read_network_table(root, path);
  config.log_level = read_log_level(root);
  read_cycle(root, config.cycle);
  Listeners listeners;
  const TomlTable serve = root.table("serve");
  config.serve = read_serve(serve, path, listeners);
  read_plc_timeout(serve, config);
  config.show = read_http(root, path, listeners);
  config.plant = read_plant(root.optional_table("plant"), path);
  read_spindle(root, config, listeners);
  return config;
}

}  // namespace

Config read_config(const std::string& path) { return read_root(TomlTable::read(path), path); }

Config read_spindle_config(const std::string& path) {
  const TomlTable root = TomlTable::read(path);
  if (root.has("spindle")) root.fail("spindle", "this is a list of spindles; the file of one of them is wanted");
  const auto serve = root.optional_table("serve");
  bool is_one_of_several = true;
  if (serve) {
    for (const std::string& key : serve->free_keys()) is_one_of_several = is_one_of_several && key == "plc_timeout_s";
  }
  if (!is_one_of_several || root.has("http") || root.has("plant")) return read_config(path);
  Listeners listeners;
  return read_config_of_one(TomlTable::read(path), path, "the list of spindles", listeners);
}

Config parse_config(const std::string& text, const std::string& path) {
  return read_root(TomlTable::parse(text, path), path);
}

Config read_config_of_one(const TomlTable& root, const std::string& path, const std::string& list,
                          Listeners& listeners) {
  const auto of_all = [&](const TomlTable& table, const std::string& key) {
    table.fail(key, "is of all spindles and stands in " + list + " only");
  };
  for (const char* key : {"log_level", "http", "plant", "spindle"}) {
    if (root.has(key)) of_all(root, key);
  }
  Config config;
  config.path = path;
  config.network = read_network_table(root, path);
  read_cycle(root, config.cycle);
  config.cycle.plc_timeout_s = plc_timeout_s;
  if (const auto serve = root.optional_table("serve")) {
    read_plc_timeout(*serve, config);
    for (const std::string& key : serve->free_keys()) {
      if (key != "plc_timeout_s") of_all(*serve, key);
    }
  }
  read_spindle(root, config, listeners);
  return config;
}

}  // namespace spindle_twin::firmware
