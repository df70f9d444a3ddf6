#include "firmware/config/read_devices.hpp"

#include <algorithm>
#include <string>

#include "firmware/acquire/drivers.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

using rom::TomlTable;

DevicePlan read_device(const TomlTable& table, double clock_rate) {
  DevicePlan device;
  device.driver = read_driver(table);
  device.poll_s = 0.0;
  if (device.driver->polls()) device.poll_s = table.number_or("poll_s", 1.0, rom::between(0.01, 3600.0)) / clock_rate;
  device.delay_s = table.number_or("delay_s", device.delay_s, rom::between(0.0, 60.0));
  device.retry_s = table.number_or("retry_s", device.retry_s, rom::between(0.05, 60.0));
  device.retry_most_s = table.number_or("retry_most_s", std::max(device.retry_most_s, device.retry_s),
                                        rom::between(device.retry_s, 3600.0));
  return device;
}

/// The only device may go without being named.
std::size_t device_of(const TomlTable& table, const std::vector<DevicePlan>& devices) {
  if (devices.size() == 1 && !table.has("device")) return 0;
  const std::string name = table.string("device");
  const auto found =
      std::find_if(devices.begin(), devices.end(), [&](const DevicePlan& device) { return device.name == name; });
  if (found != devices.end()) return static_cast<std::size_t>(found - devices.begin());
  std::string names;
  for (const DevicePlan& device : devices) names += (names.empty() ? "" : ", ") + device.name;
  table.fail("device", "there is no device \"" + name + "\"; there is " + names);
}

Conversion read_conversion(const TomlTable& table, Unit unit, double scale) {
  Conversion conversion;
  const std::string kind = table.choice_or("conversion", "linear", {"linear", "pt100", "4-20mA"});
  if (kind == "pt100") {
    conversion.kind = ConversionKind::pt100;
    if (unit.shift != rom::zero_degC_K) table.fail("conversion", "\"pt100\" is of temperatures only");
  } else if (kind == "4-20mA") {
    conversion.kind = ConversionKind::ma_4_20;
    conversion.at_4mA = table.number("at_4mA");
    conversion.at_20mA = table.number("at_20mA");
    if (conversion.at_20mA == conversion.at_4mA) table.fail("at_20mA", "must differ from at_4mA");
  }
  conversion.scale = table.number_or("scale", scale);
  if (conversion.scale == 0.0) table.fail("scale", "must not be 0: every reading would be the same");
  conversion.offset = table.number_or("offset", 0.0);
  conversion.unit = unit;
  return conversion;
}

FilterPlan read_filter(const TomlTable& table, double clock_rate) {
  const rom::Range time_s = rom::between(1e-3, 3600.0);
  if (table.has("mean_s") && table.has("low_pass_s")) table.fail("low_pass_s", "either this or mean_s is possible");
  if (table.has("mean_s")) return {FilterPlan::Kind::mean, table.number("mean_s", time_s) / clock_rate};
  if (table.has("low_pass_s")) return {FilterPlan::Kind::low_pass, table.number("low_pass_s", time_s) / clock_rate};
  return {};
}

}  // namespace

std::vector<DevicePlan> read_devices(const TomlTable& root, double clock_rate, Listeners& listeners) {
  std::vector<DevicePlan> devices;
  if (root.has("device") && root.is_table("device")) {
    const TomlTable table = root.table("device");
    devices.push_back(read_device(table, clock_rate));
    if (const auto place = devices.back().driver->listens()) listeners.add("[device]", *place, table);
    return devices;
  }
  for (const TomlTable& table : root.tables_or_empty("device")) {
    const std::string name = table.name();
    for (const DevicePlan& other : devices) {
      if (other.name == name) table.fail("name", "there is a device \"" + name + "\" already");
    }
    if (devices.size() == slots::devices) {
      table.fail("name", "there may be " + std::to_string(slots::devices) + " devices at most");
    }
    devices.push_back(read_device(table, clock_rate));
    devices.back().name = name;
    if (const auto place = devices.back().driver->listens()) listeners.add("device \"" + name + "\"", *place, table);
  }
  return devices;
}

ConfiguredChannel read_channel(const TomlTable& table, Unit unit, double clock_rate, std::vector<DevicePlan>& devices) {
  ConfiguredChannel channel;
  channel.device = device_of(table, devices);
  DevicePlan& device = devices[channel.device];
  const ChannelSource source = device.driver->add_channel(table);
  channel.number = device.channels.size();
  channel.place = source.place;
  device.channels.emplace_back();
  channel.conversion = read_conversion(table, unit, source.scale);
  channel.filter = read_filter(table, clock_rate);
  if (source.is_counted) channel.step = step_of(channel.conversion);
  return channel;
}

}  // namespace spindle_twin::firmware
