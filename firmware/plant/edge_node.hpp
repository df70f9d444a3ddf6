#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "firmware/plant/payload.hpp"
#include "firmware/plant/plant_metrics.hpp"
#include "firmware/plant/sample_queue.hpp"

namespace spindle_twin::firmware {

/// One message of MQTT.
struct PlantMessage {
  std::string topic;
  std::vector<std::uint8_t> payload;
};

/// A spindle as the plant network has it.
struct PlantDevice {
  std::string name;
  std::unique_ptr<PlantMetrics> metrics;
};

/// What the daemon says as an edge node of Sparkplug B 3.0.0, with a device for each spindle: births, data and deaths,
/// their numbering, and what has to be said again. Knows no broker and no clock; times are ms since 1970. For one
/// thread; allocates.
class EdgeNode {
 public:
  static constexpr std::size_t most_under_way = 64;  ///< messages with data that go unconfirmed

  /// `queue`: samples of each device that wait at most.
  EdgeNode(std::string group, std::string node, std::vector<PlantDevice> devices, std::size_t queue);

  /// The will of the next connection: the death that its birth refers to. Once for each attempt.
  PlantMessage will(std::uint64_t now_ms);
  /// Where orders come in.
  std::string order_topic() const { return topic("NCMD"); }
  /// Whether a message there asks for births.
  bool asks_for_birth(std::span<const std::uint8_t> payload) const;

  /// The node's birth and those of all devices that have a sample: at the beginning of a connection, and when asked.
  std::vector<PlantMessage> births(std::uint64_t now_ms);
  /// The oldest samples that wait, each in a message; before its first sample of a connection a device's birth. Nothing
  /// while others are under way.
  std::vector<PlantMessage> data(std::uint64_t now_ms);
  /// Deaths of devices that have stopped, once each, when all that they said has arrived.
  std::vector<PlantMessage> deaths(std::uint64_t now_ms);
  /// The broker has read all that data() gave: how many samples.
  std::size_t confirm() { return queue_.confirm(); }
  /// The connection is gone.
  void disconnected();

  /// A device's newest sample; connected or not.
  void add(std::size_t device, std::uint64_t time_ms, PlantValues values);
  /// A device says nothing any more until its next sample.
  void stop(std::size_t device);

  const SampleQueue& queue() const { return queue_; }
  const PlantMetrics& metrics(std::size_t device) const { return *devices_[device].plan.metrics; }
  std::size_t devices() const { return devices_.size(); }

 private:
  struct Device {
    PlantDevice plan;
    std::uint64_t first_alias = 0;
    std::vector<bool> was_not_good = {};  ///< metrics whose quality has to be said in each message
    PlantSample newest = {};              ///< without numbers: there is none
    bool is_born = false;                 ///< on this connection
    bool has_stopped = false;
  };

  std::string topic(const char* kind, const Device* device = nullptr) const;
  std::uint8_t next_seq() { return seq_++; }
  PlantMessage node_birth(std::uint64_t now_ms);
  PlantMessage device_birth(Device& device, std::uint64_t now_ms);
  PlantMessage device_data(Device& device, const PlantSample& sample, std::uint64_t now_ms);
  PayloadMetric metric(Device& device, std::size_t m, const PlantSample& sample, bool in_birth) const;

  std::string group_, node_;
  std::vector<Device> devices_;
  SampleQueue queue_;
  std::uint8_t death_ = 0;       ///< Sparkplug's bdSeq of the connection; wraps
  bool had_connection_ = false;  ///< or tried to have
  std::uint8_t seq_ = 0;         ///< of the next message; wraps
  std::uint64_t born_ms_ = 0;
};

}  // namespace spindle_twin::firmware
