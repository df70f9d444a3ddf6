#pragma once

#include <optional>
#include <string>
#include <vector>

#include "firmware/serve/allow_list.hpp"

namespace spindle_twin::firmware {

/// Modbus/TCP Security: TLS with certificates on both sides, in front of the server.
struct TlsPlan {
  std::string address = "127.0.0.1";  ///< IPv4 to listen on
  int port = 802;                     ///< 0 takes a free one (tests)
  std::string certificate;            ///< PEM files: the daemon's own, with its chain,
  std::string key;                    ///< its private key,
  std::string clients_ca;             ///< and the authority that has signed the clients'
  std::string revoked;                ///< its list of certificates that count no more; empty: there is none
  std::optional<std::vector<std::string>> write_roles = std::nullopt;  ///< empty: every client may write

  bool operator==(const TlsPlan&) const = default;
};

/// What the Modbus server needs; made once from the configuration.
struct ServePlan {
  bool plain = true;                  ///< false: by TLS only
  std::string address = "127.0.0.1";  ///< IPv4 to listen on
  int port = 502;                     ///< 0 takes a free one (tests)
  std::vector<AddressRange> allow;    ///< clients that are answered
  std::vector<AddressRange> write;    ///< of these, whose writes are taken
  int connections = 32;               ///< at most at once
  int connections_per_host = 16;      ///< of these, from one address
  double idle_s = 300.0;              ///< a connection without a request for so long is closed
  double frame_deadline_s = 1.0;      ///< from a request's first byte to its last
  std::optional<TlsPlan> tls = std::nullopt;

  bool operator==(const ServePlan&) const = default;
};

}  // namespace spindle_twin::firmware
