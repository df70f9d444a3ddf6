#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/serve/acceptor.hpp"
#include "firmware/serve/descriptor.hpp"
#include "firmware/serve/modbus_server.hpp"
#include "firmware/serve/serve_plan.hpp"
#include "firmware/serve/tls_identity.hpp"
#include "firmware/serve/tls_link.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// Modbus/TCP Security in front of the Modbus server, in the one thread that calls run(): a client that `allow` names
/// shows a certificate, and its bytes then pass the same gate, limits and answers as those of the plain port. Files
/// that are replaced count from the next client on.
class TlsFront {
 public:
  /// Listens. Throws rom::InputError naming address and port, or the file, if that is not possible. `plan.tls` must be
  /// there; `server` must outlive this.
  TlsFront(const ServePlan& plan, Clock& clock, ModbusServer& server);

  int port() const;
  /// The last moment of the daemon's certificate, and whether it is over. Not while run() runs.
  std::string valid_until() const { return identity_->valid_until(); }
  bool expired() const { return identity_->expired(); }
  /// Until stop(); a failing poll() is tried again.
  void run();
  /// Ends run(); from any thread or signal handler.
  void stop();

 private:
  /// Of a file: whether it is still the one that was read.
  struct Stamp {
    std::int64_t changed_ns = 0, bytes = 0;
    std::uint64_t inode = 0;
    bool operator==(const Stamp&) const = default;
  };
  using Stamps = std::array<Stamp, 4>;

  void accept_all();
  const char* refusal_of(std::uint32_t host) const;
  void look_at(TlsLink& link);
  void begin(TlsLink& link);
  void renew_identity();
  Stamps stamps() const;
  int poll_timeout_ms() const;

  ServePlan plan_;
  TlsPlan tls_;
  Clock& clock_;
  ModbusServer& server_;
  std::unique_ptr<TlsIdentity> identity_;
  Stamps read_;  ///< the files of identity_, or newer ones that could not be used
  Acceptor acceptor_;
  Descriptor wake_;
  std::vector<std::unique_ptr<TlsLink>> links_;
  LogLimit refusals_, handshakes_, guests_, troubles_;
};

}  // namespace spindle_twin::firmware
