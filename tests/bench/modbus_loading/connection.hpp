#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace spindle_twin::load {

using Bytes = std::vector<std::uint8_t>;

inline constexpr std::int64_t ns_per_s = 1'000'000'000;
inline constexpr std::int64_t patience_ns = 30 * ns_per_s;  ///< an answer that takes longer is missing

std::int64_t now_ns();

/// What stands between the header and the end of a request of this unit, as a frame.
Bytes framed(std::uint16_t transaction, const Bytes& pdu, std::uint8_t unit = 1);

/// A client's connection to 127.0.0.1; its end is a reset, which leaves no port waiting.
class Connection {
 public:
  Connection() = default;
  ~Connection() { close(); }
  Connection(Connection&& other) noexcept;
  Connection& operator=(Connection&& other) noexcept;

  /// Throws std::runtime_error where nobody listens. receive_buffer 0: as the system has it.
  void open(int port, int receive_buffer = 0);
  void close();
  bool is_open() const { return socket_ >= 0; }
  int socket() const { return socket_; }

  /// False where the connection has ended or takes no more.
  bool send(std::span<const std::uint8_t> bytes) const;
  /// Takes what has come; false where the server has ended the connection.
  bool receive();
  /// The next whole frame of what has come.
  std::optional<Bytes> next_frame();

 private:
  int socket_ = -1;
  Bytes received_;
};

/// Waits until one of the connections has something, or until `until_ns`. Closed connections are left out.
void wait_for(std::span<const Connection* const> connections, std::int64_t until_ns);

}  // namespace spindle_twin::load
