#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/serve/descriptor.hpp"
#include "firmware/serve/tls_identity.hpp"

namespace spindle_twin::firmware {

/// One client by TLS: its handshake, then its bytes to the Modbus server and back. It waits for nobody, and holds at
/// the most one record of 16 KiB in each direction: who does not read is not read.
class TlsLink {
 public:
  enum class Handshake { goes_on, done, failed };

  /// `client`: accepted and non-blocking. `host`: its IPv4 address, host byte order.
  TlsLink(Descriptor client, TlsSession session, std::uint32_t host, std::int64_t deadline_ns);

  /// As far as it goes now; until it is done.
  Handshake shake_hands();
  const SSL* session() const { return session_.get(); }
  std::uint32_t host() const { return host_; }
  /// Behind the handshake: from here on bytes go to this end of a connection to the server.
  void join(Descriptor server);
  bool joined() const { return server_.get() >= 0; }
  /// Moves what can be moved now.
  void move_bytes(std::int64_t now_ns);

  /// What poll() has to wait for, of both sockets; server() is -1 until there is one, and while it is known that the
  /// server is leaving and the client has not taken what it has said.
  int client() const { return client_.get(); }
  int server() const { return server_leaves_ && server_events() == 0 ? -1 : server_.get(); }
  /// poll() has seen that the server closes its side: the client has a second to take the rest.
  void note_leaving_server(std::int64_t now_ns);
  short client_events() const;
  short server_events() const;
  /// Of the handshake, of a client that takes nothing of what waits for it (10 s), and of the last bytes once the
  /// server has ended; 0: none.
  std::int64_t deadline_ns() const { return deadline_ns_; }
  bool over() const { return over_; }
  /// Says good-bye, as far as that goes now.
  void end();

 private:
  class Record {
   public:
    bool empty() const { return begin_ == end_; }
    std::span<std::uint8_t> room() { return bytes_; }
    std::span<const std::uint8_t> rest() const { return std::span(bytes_).subspan(begin_, end_ - begin_); }
    void filled(std::size_t bytes) { begin_ = 0, end_ = bytes; }
    void taken(std::size_t bytes) { begin_ += bytes; }

   private:
    std::array<std::uint8_t, 16384> bytes_{};
    std::size_t begin_ = 0, end_ = 0;
  };

  bool read_client();
  bool write_server(std::int64_t now_ns);
  bool read_server(std::int64_t now_ns);
  bool write_client(std::int64_t now_ns);
  void note_end_of_server(std::int64_t now_ns);
  short wanted(int result);

  Descriptor client_, server_;
  TlsSession session_;
  std::uint32_t host_;
  std::int64_t deadline_ns_;
  short read_waits_for_, write_waits_for_;
  bool server_leaves_ = false, server_ended_ = false;
  bool over_ = false;
  Record up_, down_;  ///< to the server, to the client
};

}  // namespace spindle_twin::firmware
