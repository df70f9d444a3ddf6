#include "firmware/plant/edge_node.hpp"

#include <cmath>
#include <utility>

namespace spindle_twin::firmware {
namespace {

const char* const rebirth_name = "Node Control/Rebirth";
const char* const death_name = "bdSeq";

PayloadMetric of_node(const char* name, DataType type, double value) {
  PayloadMetric metric;
  metric.name = name;
  metric.type = type;
  metric.value = value;
  return metric;
}

PayloadMetric text_metric(const char* name, std::string text) {
  PayloadMetric metric = of_node(name, DataType::string, 0.0);
  metric.text = std::move(text);
  return metric;
}

}  // namespace

EdgeNode::EdgeNode(std::string group, std::string node, std::vector<PlantDevice> devices, std::size_t queue)
    : group_(std::move(group)), node_(std::move(node)), queue_(queue * devices.size()) {
  std::uint64_t alias = 1;
  for (PlantDevice& device : devices) {
    const std::size_t count = device.metrics->all().size();
    Device each{std::move(device), alias};
    each.was_not_good.assign(count, false);
    devices_.push_back(std::move(each));
    alias += count;
  }
}

std::string EdgeNode::topic(const char* kind, const Device* device) const {
  return "spBv1.0/" + group_ + "/" + kind + "/" + node_ + (device != nullptr ? "/" + device->plan.name : "");
}

PlantMessage EdgeNode::will(std::uint64_t now_ms) {
  if (std::exchange(had_connection_, true)) ++death_;
  PayloadMessage message{now_ms};
  message.metrics.push_back(of_node(death_name, DataType::int64, death_));
  return {topic("NDEATH"), encode_payload(message)};
}

bool EdgeNode::asks_for_birth(std::span<const std::uint8_t> payload) const { return sets_true(payload, rebirth_name); }

std::vector<PlantMessage> EdgeNode::births(std::uint64_t now_ms) {
  std::vector<PlantMessage> messages;
  messages.push_back(node_birth(now_ms));
  for (Device& device : devices_) {
    device.is_born = false;
    if (!device.newest.values.numbers.empty() && !device.has_stopped) messages.push_back(device_birth(device, now_ms));
  }
  return messages;
}

PlantMessage EdgeNode::node_birth(std::uint64_t now_ms) {
  seq_ = 0;
  born_ms_ = now_ms;
  PayloadMessage message{now_ms, std::nullopt, next_seq()};
  message.metrics = {of_node(death_name, DataType::int64, death_), of_node(rebirth_name, DataType::boolean, 0.0),
                     text_metric("Properties/version", SPINDLE_TWIN_VERSION)};
  return {topic("NBIRTH"), encode_payload(message)};
}

PlantMessage EdgeNode::device_birth(Device& device, std::uint64_t now_ms) {
  device.is_born = true;
  PayloadMessage message{now_ms, device.newest.time_ms, next_seq()};
  message.metrics.push_back(text_metric("Properties/spindle", device.plan.metrics->spindle()));
  for (std::size_t m = 0; m < device.was_not_good.size(); ++m) {
    message.metrics.push_back(metric(device, m, device.newest, true));
  }
  return {topic("DBIRTH", &device), encode_payload(message)};
}

PlantMessage EdgeNode::device_data(Device& device, const PlantSample& sample, std::uint64_t now_ms) {
  PayloadMessage message{now_ms, sample.time_ms, next_seq()};
  for (std::size_t m = 0; m < device.was_not_good.size(); ++m) {
    message.metrics.push_back(metric(device, m, sample, false));
  }
  return {topic("DDATA", &device), encode_payload(message)};
}

PayloadMetric EdgeNode::metric(Device& device, std::size_t m, const PlantSample& sample, bool in_birth) const {
  const PlantMetric& of = device.plan.metrics->all()[m];
  PayloadMetric metric;
  metric.alias = device.first_alias + m;
  metric.type = of.type;
  metric.value = sample.values.numbers[m];
  if (in_birth) {
    metric.name = of.name;
    metric.unit = of.unit;
  } else {
    metric.is_historical = sample.time_ms < born_ms_;
  }
  const MetricQuality quality = sample.values.qualities[m];
  if (quality != MetricQuality::good) device.was_not_good[m] = true;
  if (in_birth || device.was_not_good[m]) metric.quality = quality;
  return metric;
}

std::vector<PlantMessage> EdgeNode::data(std::uint64_t now_ms) {
  std::vector<PlantMessage> messages;
  if (queue_.under_way() > 0) return messages;
  for (const PlantSample& sample : queue_.send(most_under_way)) {
    Device& device = devices_[sample.device];
    if (!device.is_born) messages.push_back(device_birth(device, now_ms));
    messages.push_back(device_data(device, sample, now_ms));
  }
  return messages;
}

std::vector<PlantMessage> EdgeNode::deaths(std::uint64_t now_ms) {
  std::vector<PlantMessage> messages;
  if (queue_.waiting() + queue_.under_way() > 0) return messages;
  for (Device& device : devices_) {
    if (!device.has_stopped || !std::exchange(device.is_born, false)) continue;
    messages.push_back({topic("DDEATH", &device), encode_payload({now_ms, std::nullopt, next_seq()})});
  }
  return messages;
}

void EdgeNode::disconnected() {
  queue_.take_back();
  for (Device& device : devices_) device.is_born = false;
}

void EdgeNode::add(std::size_t device, std::uint64_t time_ms, PlantValues values) {
  Device& to = devices_[device];
  to.has_stopped = false;
  to.newest = {device, time_ms, values};
  queue_.push({device, time_ms, std::move(values)});
}

void EdgeNode::stop(std::size_t device) { devices_[device].has_stopped = true; }

}  // namespace spindle_twin::firmware
