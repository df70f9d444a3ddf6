#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace spindle_twin::firmware {

/// Who is logged in, in memory only: a restart ends all. A session ends when nothing was commanded with it for so long,
/// when it has lasted so long in any case, or when it is ended; of 16 the longest idle one makes room. Any thread.
class Sessions {
 public:
  static constexpr std::size_t most = 16;

  Sessions(double idle_s, double longest_s);

  /// A new session; its token, 64 hex digits that nobody can guess. now_ns: monotonic, as below.
  std::string begin(const std::string& user, std::int64_t now_ns);
  /// Whose token it is. `used`: the session counts as in use.
  std::optional<std::string> user_of(const std::string& token, std::int64_t now_ns, bool used);
  void end(const std::string& token);

 private:
  struct Session {
    std::string token;
    std::string user;
    std::int64_t begun_ns = 0;
    std::int64_t used_ns = 0;
  };
  void end_old(std::int64_t now_ns);

  const std::int64_t idle_ns_, longest_ns_;
  std::mutex guard_;
  std::vector<Session> sessions_;
};

}  // namespace spindle_twin::firmware
