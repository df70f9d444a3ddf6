#include "firmware/login/login_limit.hpp"

#include <algorithm>

#include "firmware/watch/clock.hpp"

namespace spindle_twin::firmware {
namespace {

struct Allowance {
  int at_once;
  std::int64_t each_ns;
};
constexpr Allowance of_one{5, 12 * ns_per_s}, of_all{20, 3 * ns_per_s};

/// Until the next try: each one moves the moment at which all are there again by its share.
std::int64_t until_next_ns(const Allowance& allowance, std::int64_t free_ns, std::int64_t now_ns) {
  return std::max<std::int64_t>(0, free_ns - now_ns - (allowance.at_once - 1) * allowance.each_ns);
}

}  // namespace

double LoginLimit::wait_s(std::uint32_t host, std::int64_t now_ns) {
  std::erase_if(free_ns_, [now_ns](const auto& each) { return each.second <= now_ns; });
  const auto known = free_ns_.find(host);
  const std::int64_t own_ns = known == free_ns_.end() ? now_ns : known->second;
  const std::int64_t all_ns = std::max(all_free_ns_, now_ns);
  std::int64_t wait_ns = std::max(until_next_ns(of_one, own_ns, now_ns), until_next_ns(of_all, all_ns, now_ns));
  if (known == free_ns_.end() && free_ns_.size() >= most_hosts) wait_ns = std::max(wait_ns, of_one.each_ns);
  if (wait_ns > 0) return 1e-9 * static_cast<double>(wait_ns);
  free_ns_[host] = own_ns + of_one.each_ns;
  all_free_ns_ = all_ns + of_all.each_ns;
  return 0.0;
}

}  // namespace spindle_twin::firmware
