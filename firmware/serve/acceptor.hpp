#pragma once

#include <poll.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "firmware/serve/allow_list.hpp"
#include "firmware/serve/descriptor.hpp"
#include "firmware/watch/clock.hpp"
#include "firmware/watch/log_limit.hpp"

namespace spindle_twin::firmware {

/// A listening socket, and which clients of its come in: those of addresses that are allowed, as long as descriptors
/// are left for the files of the daemon. What it turns away is closed and said, each reason at most once in a while.
/// For one thread.
class Acceptor {
 public:
  struct Client {
    Descriptor socket;       ///< non-blocking, quick (make_quick)
    std::uint32_t host = 0;  ///< IPv4 address, host byte order
  };

  /// `listener` as of listen_on, -1: nobody comes in. `name` begins the lines of the log ("server"), `allow_key` says
  /// where the list stands ("serve.allow").
  Acceptor(Descriptor listener, std::vector<AddressRange> allow, Clock& clock, std::string name, std::string allow_key);

  /// 0: none.
  int port() const;
  /// For poll(). Asks for nothing while it rests: a client that waits for a descriptor would make poll() return at
  /// once for as long as there is none.
  pollfd polled();
  /// When it looks again after it had no descriptor, a second later; 0: it does not rest.
  std::int64_t rests_until_ns() const { return rests_until_ns_; }
  /// The next one that comes in; none: no more wait, or there is no descriptor.
  std::optional<Client> next();
  /// poll() failed by itself: said, and a tenth of a second of rest.
  void rest_behind_failed_poll(int reason);

 private:
  void wait_for_descriptors(int reason);

  Descriptor listener_;
  std::vector<AddressRange> allow_;
  Clock& clock_;
  std::string name_, allow_key_;
  std::int64_t rests_until_ns_ = 0;
  LogLimit strangers_, refusals_, troubles_;
};

}  // namespace spindle_twin::firmware
