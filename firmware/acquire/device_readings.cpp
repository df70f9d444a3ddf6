#include "firmware/acquire/device_readings.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

namespace spindle_twin::firmware {

DeviceReadings::DeviceReadings(std::string device, std::size_t number, const std::vector<Channel>& channels,
                               double delay_s)
    : device_(std::move(device)), number_(number), delay_ns_(static_cast<std::int64_t>(1e9 * delay_s)) {
  for (const Channel& channel : channels) lines_.push_back({channel, ChannelFilter(channel.filter)});
  state().used = true;
}

Reading& DeviceReadings::reading_of(const Channel& channel) {
  switch (channel.kind) {
    case Channel::Kind::sensor:
      return frame_.sensors[channel.index];
    case Channel::Kind::displacement:
      return frame_.displacements[channel.index];
    default:
      return frame_.signals[channel.index];
  }
}

void DeviceReadings::note(Line& line, WireFault fault, std::int64_t time_ns) {
  if (line.fault == fault) return;
  line.fault = fault;
  if (const auto before = changes_.pass(time_ns)) {
    const auto level = fault == WireFault::none ? spdlog::level::info : spdlog::level::warn;
    spdlog::log(level, "device {}: {} is {}{}", device_, line.channel.name, wire_fault_name(fault),
                LogLimit::also(*before));
  }
}

void DeviceReadings::take(std::size_t channel, double number, std::int64_t time_ns) {
  Line& line = lines_[channel];
  constexpr std::int64_t order_uncertainty_ns = 1'000'000'000;  // of a device's clock, as well as we know it
  const std::int64_t said_ns = std::max<std::int64_t>(1, time_ns - delay_ns_);
  if (said_ns + order_uncertainty_ns < line.last_ns) return;
  const std::int64_t measured_ns = std::max(said_ns, line.last_ns + 1);
  line.last_ns = measured_ns;
  const Converted converted = convert(line.channel.conversion, number);
  note(line, converted.fault, time_ns);
  const Reading sample{converted.value, measured_ns};
  if (converted.fault == WireFault::shorted || converted.fault == WireFault::open) {
    line.filter.clear();
    reading_of(line.channel) = sample;
  } else if (const auto reading = line.filter.take(sample)) {
    reading_of(line.channel) = *reading;
  }
}

}  // namespace spindle_twin::firmware
