#pragma once

#include <arpa/inet.h>
#include <linux/sockios.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/cycle/publish.hpp"
#include "firmware/serve/descriptor.hpp"
#include "firmware/show/http_server.hpp"
#include "firmware/watch/clock.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/firmware/support/standing_clock.hpp"

/// An HTTP server of the tests, whose clock stands until a test sets it, and clients that say and read what they like.
namespace spindle_twin::firmware::http_serving {

struct Reply {
  int status = 0;  ///< 0: the connection ended without an answer
  std::string head, body;
};

/// Every wait ends after 5 s.
class Client {
 public:
  /// Not connected where there is no port. `from`: one's own address, in host byte order. `room`: bytes that the
  /// system keeps until one reads; 0: as it likes.
  explicit Client(int port, std::uint32_t from = INADDR_LOOPBACK, int room = 0)
      : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    if (room > 0) setsockopt(socket_.get(), SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    const timeval patience{5, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const sockaddr_in here = address(from, 0);
    (void)!::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&here), sizeof here);
    if (port > 0) connect(port);
  }

  void connect(int port) {
    const sockaddr_in there = address(INADDR_LOOPBACK, port);
    (void)!::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&there), sizeof there);
  }
  /// The bytes are at the server's end when this returns, where it has room for them.
  void send(const std::string& bytes) {
    (void)!::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    for (int left = 1; left > 0 && std::chrono::steady_clock::now() < end;) {
      pollfd broken{socket_.get(), 0, 0};
      if (poll(&broken, 1, 0) != 0 || ioctl(socket_.get(), SIOCOUTQ, &left) != 0) return;
    }
  }
  void ask(const std::string& path) { send("GET " + path + " HTTP/1.1\r\n\r\n"); }

  /// All until the server ends it.
  Reply read_all() {
    while (more(0)) {
    }
    Reply reply;
    const std::size_t end = std::min(got_.find("\r\n\r\n"), got_.size());
    reply.head = got_.substr(0, end);
    reply.body = end < got_.size() ? got_.substr(end + 4) : "";
    if (reply.head.starts_with("HTTP/1.1 ")) reply.status = std::atoi(reply.head.c_str() + 9);
    return reply;
  }
  /// Up to and with the next `mark`; empty: it did not come.
  std::string read_until(const std::string& mark) {
    std::size_t at = got_.find(mark);
    for (; at == std::string::npos; at = got_.find(mark)) {
      if (!more(0)) return "";
    }
    std::string part = got_.substr(0, at + mark.size());
    got_.erase(0, at + mark.size());
    return part;
  }
  /// Whether nothing is there to be read, not even an end; some milliseconds for what is on its way.
  bool hears_nothing() {
    constexpr int on_its_way_ms = 5;
    pollfd readable{socket_.get(), POLLIN, 0};
    return got_.empty() && poll(&readable, 1, on_its_way_ms) == 0;
  }
  /// Whether the server ends the connection; waits for it.
  bool is_ended() {
    while (more(0)) {
    }
    return errno != EAGAIN;
  }
  /// Breaks the connection off.
  void reset() {
    const linger none{1, 0};
    setsockopt(socket_.get(), SOL_SOCKET, SO_LINGER, &none, sizeof none);
    socket_ = Descriptor();
  }
  void close() { socket_ = Descriptor(); }
  /// Still reads.
  void end_sending() { ::shutdown(socket_.get(), SHUT_WR); }

 private:
  static sockaddr_in address(std::uint32_t host, int port) {
    sockaddr_in made{};
    made.sin_family = AF_INET;
    made.sin_port = htons(static_cast<std::uint16_t>(port));
    made.sin_addr.s_addr = htonl(host);
    return made;
  }
  bool more(int flags) {
    std::array<char, 65536> part{};
    errno = 0;
    const ssize_t got = recv(socket_.get(), part.data(), part.size(), flags);
    if (got > 0) got_.append(part.data(), static_cast<std::size_t>(got));
    return got > 0;
  }

  Descriptor socket_;
  std::string got_;
};

inline SpindleToShow spindle(const std::string& name = "") {
  SpindleToShow one;
  one.name = name;
  one.names = names_of(tests::small_network());
  return one;
}

inline std::vector<SpindleToShow> only(SpindleToShow spindle) {
  std::vector<SpindleToShow> one;
  one.push_back(std::move(spindle));
  return one;
}

/// A server in its own thread on a free port.
struct Serving {
  explicit Serving(std::vector<SpindleToShow> spindles = only(spindle()), const ShowPlan& the_plan = plan())
      : server(the_plan, std::move(spindles), clock), thread([this] { server.run(); }) {}
  ~Serving() {
    server.stop();
    thread.join();
  }
  Serving(const Serving&) = delete;
  Serving& operator=(const Serving&) = delete;

  static ShowPlan plan() {
    ShowPlan plan;
    plan.port = 0;
    plan.allow = {*parse_address_range("127.0.0.0/8")};
    return plan;
  }

  Reply get(const std::string& path) {
    Client client(server.port());
    client.ask(path);
    return client.read_all();
  }
  /// The server has looked at all that was there before, at the time that it is now.
  void look() { get("/routes"); }
  void pass(std::int64_t by_ns) {
    clock.pass(by_ns);
    look();
  }
  /// What it counts, its answer's own connection included.
  double count(const std::string& name) {
    const std::string text = get("/metrics").body, line = "\nspindle_twin_http_" + name + " ";
    const std::size_t at = text.find(line);
    return at == std::string::npos ? -1.0 : std::atof(text.c_str() + at + line.size());
  }
  /// Whether it comes to count so many; the connection of the question before may be on its way out yet.
  bool counts(const std::string& name, int wanted) {
    double counted = -1.0;
    for (int n = 0; n < 100 && counted != wanted; ++n) counted = count(name);
    return counted == wanted;
  }
  bool has_clients(int wanted) { return counts("connections", wanted + 1); }
  bool has_dropped(int wanted) { return count("dropped_total") == wanted; }

  void show_cycle(std::uint64_t sequence, std::size_t of = 0) {
    Snapshot snapshot = first_snapshot(tests::small_network());
    snapshot.state = State::running;
    snapshot.sequence = sequence;
    snapshot.time_ns = clock.now_ns();
    server.tap(of).write(snapshot);
  }

  StandingClock clock;
  HttpServer server;
  std::thread thread;
};

}  // namespace spindle_twin::firmware::http_serving
