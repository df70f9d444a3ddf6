#pragma once

#include <cstdint>
#include <map>

namespace spindle_twin::firmware {

/// How often a password may be tried: from one address five times at once and then once in 12 s, from all together
/// twenty times at once and then once in 3 s. For one thread.
class LoginLimit {
 public:
  /// 0: it may be tried, and counts; else for how many seconds it may not. host: IPv4 address; now_ns: monotonic.
  double wait_s(std::uint32_t host, std::int64_t now_ns);

 private:
  static constexpr std::size_t most_hosts = 256;
  std::map<std::uint32_t, std::int64_t> free_ns_;  ///< when each address would have all its tries again
  std::int64_t all_free_ns_ = 0;
};

}  // namespace spindle_twin::firmware
