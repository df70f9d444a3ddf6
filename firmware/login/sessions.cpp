#include "firmware/login/sessions.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace spindle_twin::firmware {
namespace {

constexpr std::size_t token_bytes = 32;

std::string new_token() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium has no source of random numbers");
  std::array<unsigned char, token_bytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  std::array<char, 2 * token_bytes + 1> hex{};
  return sodium_bin2hex(hex.data(), hex.size(), bytes.data(), bytes.size());
}

/// Takes as long wherever the two differ.
bool is_same(const std::string& one, const std::string& other) {
  return one.size() == other.size() && sodium_memcmp(one.data(), other.data(), one.size()) == 0;
}

}  // namespace

Sessions::Sessions(double idle_s, double longest_s)
    : idle_ns_(static_cast<std::int64_t>(1e9 * idle_s)), longest_ns_(static_cast<std::int64_t>(1e9 * longest_s)) {}

void Sessions::end_old(std::int64_t now_ns) {
  std::erase_if(sessions_, [&](const Session& each) {
    return now_ns - each.used_ns >= idle_ns_ || now_ns - each.begun_ns >= longest_ns_;
  });
}

std::string Sessions::begin(const std::string& user, std::int64_t now_ns) {
  const std::lock_guard lock(guard_);
  end_old(now_ns);
  if (sessions_.size() >= most) {
    sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(), [](const Session& one, const Session& other) {
      return one.used_ns < other.used_ns;
    }));
  }
  sessions_.push_back({new_token(), user, now_ns, now_ns});
  return sessions_.back().token;
}

std::optional<std::string> Sessions::user_of(const std::string& token, std::int64_t now_ns, bool used) {
  const std::lock_guard lock(guard_);
  end_old(now_ns);
  for (Session& each : sessions_) {
    if (!is_same(each.token, token)) continue;
    if (used) each.used_ns = now_ns;
    return each.user;
  }
  return std::nullopt;
}

void Sessions::end(const std::string& token) {
  const std::lock_guard lock(guard_);
  std::erase_if(sessions_, [&](const Session& each) { return is_same(each.token, token); });
}

}  // namespace spindle_twin::firmware
