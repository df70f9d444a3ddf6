#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "firmware/serve/descriptor.hpp"
#include "firmware/serve/listen.hpp"

/// As much of a broker of MQTT 5 as one client needs, which answers what a test wants; and as much of a payload's form
/// as a test looks at.
namespace spindle_twin::firmware::small_broker {

using Bytes = std::vector<std::uint8_t>;

struct Published {
  std::string topic;
  Bytes payload;
};

/// Does something in turn() only. One client at a time, the newest.
class Broker {
 public:
  Broker() : listener_(listen_on("127.0.0.1", 0)) {}

  int port() const { return port_of(listener_.get()); }

  void turn() {
    const int socket = accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket >= 0) {
      client_ = Descriptor(socket);
      in_.clear();
      ++connections;
    }
    std::array<std::uint8_t, 65536> part{};
    for (ssize_t got = 0; client_.get() >= 0 && (got = recv(client_.get(), part.data(), part.size(), 0)) > 0;) {
      in_.insert(in_.end(), part.begin(), part.begin() + got);
    }
    while (take_packet()) {
    }
  }
  void send(const Bytes& bytes) { (void)!::send(client_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  void accept_session(std::uint8_t code = 0) { send({0x20, 3, 0, code, 0}); }
  /// Answers the oldest subscription that has no answer: all before it was read.
  void confirm(std::uint8_t code = 0) {
    const Bytes id = subscriptions_.front();
    subscriptions_.erase(subscriptions_.begin());
    send({0x90, 4, id[0], id[1], 0, code});
  }
  /// A message of quality of service 0 to the client.
  void publish(const std::string& topic, const Bytes& payload) {
    Bytes body{static_cast<std::uint8_t>(topic.size() >> 8U), static_cast<std::uint8_t>(topic.size() & 0xFFU)};
    body.insert(body.end(), topic.begin(), topic.end());
    body.push_back(0);
    body.insert(body.end(), payload.begin(), payload.end());
    Bytes packet{0x30};
    for (std::size_t rest = body.size();;) {
      packet.push_back(static_cast<std::uint8_t>(rest % 128 + (rest >= 128 ? 128 : 0)));
      rest /= 128;
      if (rest == 0) break;
    }
    packet.insert(packet.end(), body.begin(), body.end());
    send(packet);
  }
  void end() { client_ = Descriptor(); }
  std::size_t unconfirmed() const { return subscriptions_.size(); }
  std::size_t count(const std::string& kind) const {
    std::size_t found = 0;
    for (const Published& each : published) found += each.topic.find("/" + kind + "/") != std::string::npos ? 1 : 0;
    return found;
  }
  std::vector<Published> take_published() { return std::exchange(published, {}); }

  bool accepts = true;   ///< by itself
  bool confirms = true;  ///< likewise
  int connections = 0;
  std::vector<Published> published;
  std::vector<std::string> subscribed;  ///< topics, with their quality of service
  Bytes connect, disconnect;            ///< the last of each, behind the length

 private:
  bool take_packet() {
    std::size_t at = 1, length = 0;
    for (unsigned shift = 0; at < in_.size(); ++at, shift += 7) {
      length += static_cast<std::size_t>(in_[at] & 0x7FU) << shift;
      if (in_[at] < 128) break;
    }
    if (++at > in_.size() || in_.size() < at + length) return false;
    const std::uint8_t kind = in_[0];
    const Bytes body(in_.begin() + static_cast<long>(at), in_.begin() + static_cast<long>(at + length));
    in_.erase(in_.begin(), in_.begin() + static_cast<long>(at + length));
    take(kind, body);
    return true;
  }
  void take(std::uint8_t kind, const Bytes& body) {
    const auto text = [&body](std::size_t at) {
      const std::size_t size = static_cast<std::size_t>(body[at]) << 8U | body[at + 1];
      return std::string(body.begin() + static_cast<long>(at + 2), body.begin() + static_cast<long>(at + 2 + size));
    };
    if (kind == 0x10) {
      connect = body;
      subscriptions_.clear();
      if (accepts) accept_session();
    } else if (kind == 0x82) {
      subscriptions_.push_back({body[0], body[1]});
      const std::string topic = text(3);
      subscribed.push_back(topic + " " + std::to_string(body[5 + topic.size()]));
      if (confirms) confirm();
    } else if (kind == 0x30) {
      const std::string topic = text(0);
      published.push_back({topic, Bytes(body.begin() + static_cast<long>(3 + topic.size()), body.end())});
    } else if (kind == 0xE0) {
      disconnect = body.empty() ? Bytes{0} : body;
    }
  }

  Descriptor listener_, client_;
  Bytes in_;
  std::vector<Bytes> subscriptions_;  ///< the numbers of those that have no answer
};

/// Of a message in protobuf's form: the first field of this number; of one with a length its bytes, else the number's
/// own. Empty where there is none.
inline Bytes field_of(const Bytes& message, std::uint64_t number) {
  std::size_t at = 0;
  const auto varint = [&] {
    std::uint64_t value = 0;
    for (unsigned shift = 0; at < message.size(); shift += 7) {
      const std::uint8_t byte = message[at++];
      value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
      if (byte < 128) break;
    }
    return value;
  };
  while (at < message.size()) {
    const std::uint64_t tag = varint();
    const std::size_t begin = at;
    std::size_t end = at;
    if (tag % 8 == 0) {
      varint();
      end = at;
    } else if (tag % 8 == 2) {
      const std::uint64_t size = varint();
      const auto from = static_cast<long>(at);
      at += size;
      if (tag / 8 == number) return Bytes(message.begin() + from, message.begin() + static_cast<long>(at));
      continue;
    } else {
      at += tag % 8 == 5 ? 4 : 8;
      end = at;
    }
    if (tag / 8 == number) {
      return Bytes(message.begin() + static_cast<long>(begin), message.begin() + static_cast<long>(end));
    }
  }
  return {};
}

inline std::uint64_t number_of(const Bytes& varint) {
  std::uint64_t value = 0;
  for (std::size_t b = varint.size(); b > 0; --b) value = value << 7U | (varint[b - 1] & 0x7FU);
  return value;
}

/// When the first metric of a payload was, in ms since 1970.
inline std::uint64_t metric_ms(const Bytes& payload) { return number_of(field_of(field_of(payload, 2), 3)); }

/// Whether `done` comes true, asked again and again, within thirty seconds.
template <class Done>
bool comes_true(Done done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
  }
  return true;
}

}  // namespace spindle_twin::firmware::small_broker
