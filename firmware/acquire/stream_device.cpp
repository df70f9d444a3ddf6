#include "firmware/acquire/stream_device.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/acquire/read_address.hpp"
#include "firmware/serve/listen.hpp"

namespace spindle_twin::firmware {
namespace {

std::int64_t to_ns(double time_s) { return static_cast<std::int64_t>(1e9 * time_s); }

}  // namespace

ChannelSource StreamPlan::add_channel(const rom::TomlTable& table) {
  numbers.push_back(static_cast<std::uint32_t>(table.integer("channel", 0, 65535)));
  return {1.0, false, "channel " + std::to_string(numbers.back())};
}

std::unique_ptr<Driver> StreamPlan::make_driver(Clock& clock) const {
  return std::make_unique<StreamDevice>(*this, clock);
}

std::shared_ptr<DriverPlan> read_stream_plan(const rom::TomlTable& device) {
  const auto plan = std::make_shared<StreamPlan>();
  plan->address = read_ipv4(device, plan->address);
  plan->port = static_cast<int>(device.integer("port", 1, 65535));
  plan->allow = read_allow(device);
  plan->connections = static_cast<int>(device.integer_or("connections", plan->connections, 1, 64));
  plan->idle_s = device.number_or("idle_s", plan->idle_s, rom::between(0.1, 86400.0));
  plan->frame_deadline_s = device.number_or("frame_deadline_s", plan->frame_deadline_s, rom::between(0.05, 60.0));
  return plan;
}

/// One connection. Closes its socket at its end.
struct StreamDevice::Node {
  Node(int socket_of_node, std::int64_t now_ns) : socket(socket_of_node), heard_ns(now_ns), part_ns(now_ns) {}
  ~Node() { close(socket); }
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  int socket;
  std::int64_t heard_ns;  ///< of the last frame that was taken, or of the connection
  std::int64_t part_ns;   ///< since when the frame that is under way is
  bool has_spoken = false;
  StreamDecoder decoder;
  NodeClock clock;
  std::uint32_t refused = 0;  ///< of the decoder's, so many are counted
};

StreamDevice::StreamDevice(StreamPlan plan, Clock& clock) : plan_(std::move(plan)), clock_(clock) {}

StreamDevice::~StreamDevice() {
  if (listening_ >= 0) close(listening_);
}

int StreamDevice::port() const { return port_of(listening_); }

/// Without descriptors the connection would be offered again at once.
void StreamDevice::wait_behind(const char* trouble, int reason, std::int64_t now_ns) {
  if (const auto before = troubles_.pass(now_ns)) {
    spdlog::error("{} at {}: {}{}", trouble, plan_.where(), std::strerror(reason), LogLimit::also(*before));
  }
  clock_.sleep_until_ns(now_ns + 100'000'000);
}

void StreamDevice::accept_all(std::int64_t now_ns) {
  sockaddr_in from{};
  socklen_t size = sizeof from;
  while (true) {
    const int socket = accept4(listening_, reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
      if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED)
        wait_behind("no node can be accepted", errno, now_ns);
      return;
    }
    if (!is_allowed(plan_.allow, ntohl(from.sin_addr.s_addr))) {
      close(socket);
      std::array<char, INET_ADDRSTRLEN> text{};
      inet_ntop(AF_INET, &from.sin_addr, text.data(), text.size());
      if (const auto before = strangers_.pass(now_ns)) {
        spdlog::warn("node {} is not in allow of {}, closed{}", text.data(), plan_.where(), LogLimit::also(*before));
      }
      continue;
    }
    if (nodes_.size() == static_cast<std::size_t>(plan_.connections)) {
      nodes_.erase(std::min_element(nodes_.begin(), nodes_.end(),
                                    [](const Node& a, const Node& b) { return a.heard_ns < b.heard_ns; }));
    }
    make_quick(socket);
    nodes_.emplace_back(socket, now_ns);
  }
}

void StreamDevice::take_value(std::uint32_t number, float value, std::int64_t time_ns, DeviceReadings& readings) {
  for (std::size_t channel = 0; channel < plan_.numbers.size(); ++channel) {
    if (plan_.numbers[channel] == number) readings.take(channel, static_cast<double>(value), time_ns);
  }
}

void StreamDevice::take(Node& node, const spindle_twin_stream_Readings& message, std::int64_t now_ns,
                        DeviceReadings& readings) {
  constexpr std::int64_t ns_per_ms = 1'000'000;
  constexpr std::int64_t ns_per_us = 1'000;
  const std::int64_t made_ns = node.clock.made_ns(message.time_ms, now_ns);
  for (pb_size_t i = 0; i < message.readings_count; ++i) {
    const spindle_twin_stream_Reading& reading = message.readings[i];
    take_value(reading.channel, reading.value, made_ns - reading.age_ms * ns_per_ms, readings);
  }
  const spindle_twin_stream_Burst& burst = message.burst;
  for (pb_size_t i = 0; message.has_burst && i < burst.values_count; ++i) {
    const std::int64_t behind = burst.values_count - 1 - i;
    const std::int64_t age_ns = burst.age_ms * ns_per_ms + behind * burst.interval_us * ns_per_us;
    take_value(burst.channel, burst.values[i], made_ns - age_ns, readings);
  }
}

void StreamDevice::take_messages(Node& node, std::int64_t now_ns, DeviceReadings& readings) {
  spindle_twin_stream_Readings message = spindle_twin_stream_Readings_init_zero;
  const auto take_whole_ones = [&] {
    while (node.decoder.next(message)) {
      take(node, message, now_ns, readings);
      readings.accept();
      node.heard_ns = node.part_ns = now_ns;
      node.has_spoken = true;
    }
  };
  take_whole_ones();
  if (node.decoder.has_part() && now_ns - node.part_ns > to_ns(plan_.frame_deadline_s)) {
    node.decoder.give_up();
    take_whole_ones();
  }
  for (; node.refused != node.decoder.refused(); ++node.refused) {
    readings.refuse();
    node.part_ns = now_ns;
  }
}

/// Takes what the node has sent; false: the connection is at its end.
bool StreamDevice::is_open(Node& node, DeviceReadings& readings) {
  constexpr int most_reads = 16;  // so that one node that floods us leaves the others their turn
  bool open = true;
  for (int i = 0; i < most_reads && open; ++i) {
    const std::span<std::uint8_t> room = node.decoder.room();
    const ssize_t got = recv(node.socket, room.data(), room.size(), 0);
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) break;
    open = got > 0;
    const std::int64_t now_ns = clock_.now_ns();
    if (!node.decoder.has_part()) node.part_ns = now_ns;
    if (open) node.decoder.received(static_cast<std::size_t>(got));
    take_messages(node, now_ns, readings);
  }
  if (!open) {
    last_end_ = "the node closed the connection";
    node.decoder.give_up();
  } else if (clock_.now_ns() - node.heard_ns > to_ns(plan_.idle_s)) {
    last_end_ = "the node sent no frame in time";
    open = false;
  }
  take_messages(node, clock_.now_ns(), readings);
  return open;
}

Step StreamDevice::step(DeviceReadings& readings) {
  if (listening_ < 0) listening_ = listen_on(plan_.address, plan_.port, "device");
  std::vector<pollfd> sockets{{listening_, POLLIN, 0}};
  for (const Node& node : nodes_) sockets.push_back({node.socket, POLLIN, 0});
  constexpr int longest_wait_ms = 100;
  if (::poll(sockets.data(), sockets.size(), longest_wait_ms) < 0 && errno != EINTR) {
    wait_behind("no node can be waited for", errno, clock_.now_ns());
  }
  if (sockets[0].revents != 0) accept_all(clock_.now_ns());
  nodes_.remove_if([&](Node& node) { return !is_open(node, readings); });
  const bool heard = std::any_of(nodes_.begin(), nodes_.end(), [](const Node& node) { return node.has_spoken; });
  return heard ? Step{} : Step{Step::Is::waiting, last_end_};
}

}  // namespace spindle_twin::firmware
