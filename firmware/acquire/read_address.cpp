#include "firmware/acquire/read_address.hpp"

#include <arpa/inet.h>

namespace spindle_twin::firmware {

std::string read_ipv4(const rom::TomlTable& table, const std::string& otherwise) {
  std::string address = table.string_or("address", otherwise);
  in_addr parsed{};
  if (inet_pton(AF_INET, address.c_str(), &parsed) != 1) {
    table.fail("address", "must be an IPv4 address such as 127.0.0.1, is \"" + address + "\"");
  }
  return address;
}

std::vector<AddressRange> read_allow_or(const rom::TomlTable& table, const char* key,
                                        const std::vector<AddressRange>& otherwise) {
  if (!table.has(key)) return otherwise;
  std::vector<AddressRange> ranges;
  for (const std::string& entry : table.strings(key)) {
    const auto range = parse_address_range(entry);
    if (!range) {
      table.fail(key, "every entry must be an IPv4 address or range such as 192.168.1.0/24, is \"" + entry + "\"");
    }
    ranges.push_back(*range);
  }
  return ranges;
}

std::vector<AddressRange> read_allow(const rom::TomlTable& table) {
  std::vector<AddressRange> ranges = read_allow_or(table, "allow", {*parse_address_range("127.0.0.0/8")});
  if (ranges.empty()) table.fail("allow", "must name at least one address or range; nobody else is answered");
  return ranges;
}

}  // namespace spindle_twin::firmware
