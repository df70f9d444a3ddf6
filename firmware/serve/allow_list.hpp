#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace spindle_twin::firmware {

/// IPv4 addresses whose first bits are given.
struct AddressRange {
  std::uint32_t address = 0;  ///< host byte order
  std::uint32_t mask = 0xFFFFFFFFU;

  bool operator==(const AddressRange&) const = default;
};

/// "192.168.1.7" or "192.168.1.0/24"; empty if it is neither.
std::optional<AddressRange> parse_address_range(const std::string& text);

/// `address` in host byte order.
bool is_allowed(const std::vector<AddressRange>& allow, std::uint32_t address);

/// "192.168.1.7" of such an address.
std::string address_text(std::uint32_t address);

}  // namespace spindle_twin::firmware
