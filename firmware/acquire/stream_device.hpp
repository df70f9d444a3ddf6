#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/acquire/driver.hpp"
#include "firmware/acquire/node_clock.hpp"
#include "firmware/acquire/stream_decoder.hpp"
#include "firmware/serve/allow_list.hpp"

namespace spindle_twin::firmware {

/// Nodes that connect to us and send frames after stream.proto.
struct StreamPlan final : DriverPlan {
  std::string address = "127.0.0.1";   ///< IPv4 to listen on
  int port = 0;                        ///< 0 takes a free one (tests)
  std::vector<AddressRange> allow;     ///< nodes that are listened to
  int connections = 4;                 ///< at most at once; the longest silent one makes room
  double idle_s = 10.0;                ///< a connection without a frame for so long is closed
  double frame_deadline_s = 1.0;       ///< from a frame's first byte to its last
  std::vector<std::uint32_t> numbers;  ///< the node's number of each channel

  ChannelSource add_channel(const rom::TomlTable& table) override;
  std::unique_ptr<Driver> make_driver(Clock& clock) const override;
  std::string where() const override { return address + ":" + std::to_string(port); }
  std::optional<ListenPlace> listens() const override { return ListenPlace{address, port}; }
  bool polls() const override { return false; }
};

/// Keys address, port, allow, connections, idle_s, frame_deadline_s. Throws rom::InputError.
std::shared_ptr<DriverPlan> read_stream_plan(const rom::TomlTable& device);

/// Listens for nodes and takes what they send. Buffers are of fixed size and nothing is ever answered, so that a node
/// can neither fill the memory nor hold the thread up. Connected while a frame came within idle_s.
class StreamDevice final : public Driver {
 public:
  StreamDevice(StreamPlan plan, Clock& clock);
  ~StreamDevice() override;
  StreamDevice(const StreamDevice&) = delete;
  StreamDevice& operator=(const StreamDevice&) = delete;

  /// Waits 0.1 s at most for bytes. Throws rom::InputError where the port cannot be had.
  Step step(DeviceReadings& readings) override;

  /// Where it listens, once step() was called.
  int port() const;

 private:
  struct Node;
  void accept_all(std::int64_t now_ns);
  /// Says so, and lets a tenth of a second pass: what failed would fail again at once.
  void wait_behind(const char* trouble, int reason, std::int64_t now_ns);
  bool is_open(Node& node, DeviceReadings& readings);
  void take_messages(Node& node, std::int64_t now_ns, DeviceReadings& readings);
  void take(Node& node, const spindle_twin_stream_Readings& message, std::int64_t now_ns, DeviceReadings& readings);
  void take_value(std::uint32_t number, float value, std::int64_t time_ns, DeviceReadings& readings);

  StreamPlan plan_;
  Clock& clock_;
  int listening_ = -1;
  std::list<Node> nodes_;
  LogLimit strangers_;
  LogLimit troubles_;
  std::string last_end_ = "no node has connected";
};

}  // namespace spindle_twin::firmware
