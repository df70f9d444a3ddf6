#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

#include "firmware/cycle/hand_over.hpp"
#include "firmware/cycle/order_desk.hpp"
#include "firmware/cycle/snapshot.hpp"
#include "firmware/serve/descriptor.hpp"
#include "firmware/serve/frame_gate.hpp"
#include "firmware/serve/modbus_server.hpp"
#include "firmware/serve/register_map.hpp"
#include "firmware/serve/serve_plan.hpp"
#include "firmware/watch/clock.hpp"

/// A Modbus server of the tests and a client that says what it likes.
namespace spindle_twin::firmware::serving {

using Bytes = std::vector<std::uint8_t>;

/// A server in its own thread on a free port.
struct Serving {
  explicit Serving(ServePlan the_plan = plan())
      : server(the_plan, clock, {{units_of_one_spindle(), snapshots, signals, orders}}) {
    thread = std::thread([this] { server.run(); });
  }
  ~Serving() {
    server.stop();
    thread.join();
  }

  static ServePlan plan() {
    ServePlan plan;
    plan.port = 0;
    plan.allow = plan.write = {*parse_address_range("127.0.0.0/8")};
    plan.frame_deadline_s = 0.3;
    return plan;
  }

  MonotonicClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  ModbusServer server;
  std::thread thread;
};

/// A client that sends bytes as they are; every wait ends after 5 s.
class Client {
 public:
  explicit Client(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in there{};
    there.sin_family = AF_INET;
    there.sin_port = htons(static_cast<std::uint16_t>(port));
    there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected = ::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0;
    const timeval patience{5, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }

  void send(const Bytes& bytes) { (void)!::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  /// One whole frame; empty when the server closed the connection instead.
  Bytes receive() {
    Bytes frame(6);
    if (!fill(frame, 0)) return {};
    frame.resize(6 + static_cast<std::size_t>(frame[4] << 8 | frame[5]));
    return fill(frame, 6) ? frame : Bytes{};
  }

  Bytes ask(const Bytes& pdu, std::uint8_t unit = 1) {
    send(framed(pdu, unit));
    return receive();
  }

  bool closed_by_server() {
    std::uint8_t byte = 0;
    // What was sent and never read turns the end into a reset.
    const ssize_t n = recv(socket_.get(), &byte, 1, 0);
    return n == 0 || (n < 0 && errno == ECONNRESET);
  }

  /// Whether the server has ended the connection, as one sees it who reads nothing; waits for that.
  bool reset_by_server() {
    pollfd waited{socket_.get(), 0, 0};
    return poll(&waited, 1, 5000) == 1 && (waited.revents & (POLLERR | POLLHUP)) != 0;
  }

  static Bytes framed(const Bytes& pdu, std::uint8_t unit = 1) {
    Bytes frame(mbap_bytes + pdu.size());
    frame[1] = 7;
    frame[5] = static_cast<std::uint8_t>(pdu.size() + 1);
    frame[6] = unit;
    std::copy(pdu.begin(), pdu.end(), frame.begin() + mbap_bytes);
    return frame;
  }

  bool connected = false;

 private:
  bool fill(Bytes& bytes, std::size_t from) {
    while (from < bytes.size()) {
      const ssize_t n = recv(socket_.get(), bytes.data() + from, bytes.size() - from, 0);
      if (n <= 0) return false;
      from += static_cast<std::size_t>(n);
    }
    return true;
  }

  Descriptor socket_;
};

inline const Bytes read_known{4, 0, 0, 0, 6};
inline const Bytes known_words{0x12, 0x34, 0xFF, 0x83, 0xC1, 0x48, 0x00, 0x00, 0x00, 0x00, 0xC1, 0x48};

inline Bytes payload(const Bytes& reply) { return reply.size() > 9 ? Bytes(reply.begin() + 9, reply.end()) : Bytes{}; }

inline int exception_of(const Bytes& reply) { return reply.size() == 9 && (reply[7] & 0x80) != 0 ? reply[8] : 0; }

inline Bytes write_single(Register which, std::uint16_t value) {
  const std::uint16_t at = entry_of(which).address;
  return {6, static_cast<std::uint8_t>(at >> 8), static_cast<std::uint8_t>(at & 255),
          static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value & 255)};
}

}  // namespace spindle_twin::firmware::serving
