#include "tests/bench/modbus_loading/connection.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

namespace spindle_twin::load {

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Bytes framed(std::uint16_t transaction, const Bytes& pdu, std::uint8_t unit) {
  constexpr std::size_t mbap_bytes = 7;
  const std::size_t length = pdu.size() + 1;
  Bytes frame(mbap_bytes + pdu.size());
  frame[0] = static_cast<std::uint8_t>(transaction >> 8U);
  frame[1] = static_cast<std::uint8_t>(transaction & 0xFFU);
  frame[4] = static_cast<std::uint8_t>(length >> 8U);
  frame[5] = static_cast<std::uint8_t>(length & 0xFFU);
  frame[6] = unit;
  std::copy(pdu.begin(), pdu.end(), frame.begin() + mbap_bytes);
  return frame;
}

Connection::Connection(Connection&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), received_(std::move(other.received_)) {}

Connection& Connection::operator=(Connection&& other) noexcept {
  std::swap(socket_, other.socket_);
  std::swap(received_, other.received_);
  return *this;
}

void Connection::open(int port, int receive_buffer) {
  close();
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (receive_buffer > 0) setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(static_cast<std::uint16_t>(port));
  there.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (socket_ < 0 || connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof there) != 0) {
    const std::string reason = std::strerror(errno);
    close();
    throw std::runtime_error("port " + std::to_string(port) + ": " + reason);
  }
  const linger reset{1, 0};
  const int one = 1;
  setsockopt(socket_, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
  setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  fcntl(socket_, F_SETFL, O_NONBLOCK);
}

void Connection::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
  received_.clear();
}

bool Connection::send(std::span<const std::uint8_t> bytes) const {
  return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

bool Connection::receive() {
  std::array<std::uint8_t, 4096> some{};
  while (true) {
    const ssize_t n = recv(socket_, some.data(), some.size(), 0);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    if (n == 0) return false;
    received_.insert(received_.end(), some.begin(), some.begin() + n);
    if (static_cast<std::size_t>(n) < some.size()) return true;
  }
}

std::optional<Bytes> Connection::next_frame() {
  if (received_.size() < 6) return std::nullopt;
  const std::size_t size = 6U + (std::size_t{received_[4]} << 8U) + received_[5];
  if (received_.size() < size) return std::nullopt;
  const auto end = received_.begin() + static_cast<std::ptrdiff_t>(size);
  Bytes frame(received_.begin(), end);
  received_.erase(received_.begin(), end);
  return frame;
}

void wait_for(std::span<const Connection* const> connections, std::int64_t until_ns) {
  std::vector<pollfd> polled;
  polled.reserve(connections.size());
  for (const Connection* connection : connections) {
    if (connection->is_open()) polled.push_back({connection->socket(), POLLIN, 0});
  }
  const std::int64_t wait_ns = std::max<std::int64_t>(0, until_ns - now_ns());
  const timespec wait{wait_ns / ns_per_s, wait_ns % ns_per_s};
  ppoll(polled.data(), polled.size(), &wait, nullptr);
}

}  // namespace spindle_twin::load
