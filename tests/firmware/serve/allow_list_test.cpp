#include "firmware/serve/allow_list.hpp"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include <vector>

namespace spindle_twin::firmware {
namespace serve_allow_list_test {

TEST(AllowList, ranges_take_the_first_bits) {
  const auto host = [](const char* text) { return parse_address_range(text)->address; };
  const std::vector<AddressRange> allow{*parse_address_range("192.168.1.7"), *parse_address_range("10.1.0.0/16")};
  EXPECT_TRUE(is_allowed(allow, host("192.168.1.7")));
  EXPECT_FALSE(is_allowed(allow, host("192.168.1.8")));
  EXPECT_TRUE(is_allowed(allow, host("10.1.255.3")));
  EXPECT_FALSE(is_allowed(allow, host("10.2.0.1")));
  EXPECT_TRUE(is_allowed({*parse_address_range("0.0.0.0/0")}, host("8.8.8.8")));
  for (const auto& [range, last] : {std::pair{"10.1.0.4/32", "10.1.0.4"}, {"10.1.0.4/31", "10.1.0.5"}}) {
    EXPECT_TRUE(is_allowed({*parse_address_range(range)}, host("10.1.0.4"))) << range;
    EXPECT_TRUE(is_allowed({*parse_address_range(range)}, host(last))) << range;
    EXPECT_FALSE(is_allowed({*parse_address_range(range)}, host(last) + 1)) << range;
    EXPECT_FALSE(is_allowed({*parse_address_range(range)}, host("10.1.0.3"))) << range;
  }
  EXPECT_TRUE(is_allowed({*parse_address_range("128.0.0.0/1")}, host("255.1.2.3")));
  EXPECT_FALSE(is_allowed({*parse_address_range("128.0.0.0/1")}, host("127.1.2.3")));
  EXPECT_EQ(address_text(host("10.1.0.4")), "10.1.0.4");
  for (const char* text : {"", "10.1.0.0/33", "10.1.0.0/", "10.1.0/16", "host", "10.1.0.0/1x"}) {
    EXPECT_FALSE(parse_address_range(text)) << text;
  }
}

}  // namespace serve_allow_list_test
}  // namespace spindle_twin::firmware
