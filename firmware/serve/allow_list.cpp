#include "firmware/serve/allow_list.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <charconv>

namespace spindle_twin::firmware {

std::optional<AddressRange> parse_address_range(const std::string& text) {
  const std::size_t slash = text.find('/');
  in_addr address{};
  if (inet_pton(AF_INET, text.substr(0, slash).c_str(), &address) != 1) return std::nullopt;
  unsigned prefix = 32;
  if (slash != std::string::npos) {
    const char* const begin = text.data() + slash + 1;
    const char* const end = text.data() + text.size();
    const auto parsed = std::from_chars(begin, end, prefix);
    if (parsed.ec != std::errc() || parsed.ptr != end || prefix > 32) return std::nullopt;
  }
  const std::uint32_t mask = prefix == 0 ? 0U : 0xFFFFFFFFU << (32U - prefix);
  return AddressRange{ntohl(address.s_addr) & mask, mask};
}

bool is_allowed(const std::vector<AddressRange>& allow, std::uint32_t address) {
  return std::any_of(allow.begin(), allow.end(),
                     [&](const AddressRange& range) { return (address & range.mask) == range.address; });
}

std::string address_text(std::uint32_t address) {
  const in_addr in_network_order{htonl(address)};
  std::array<char, INET_ADDRSTRLEN> text{};
  return inet_ntop(AF_INET, &in_network_order, text.data(), text.size());
}

}  // namespace spindle_twin::firmware
