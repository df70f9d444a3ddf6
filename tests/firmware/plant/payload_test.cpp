#include "firmware/plant/payload.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

/// Against bytes made by hand from the standard's field numbers.
namespace spindle_twin::firmware {
namespace plant_payload_test {

using Bytes = std::vector<std::uint8_t>;

PayloadMetric number(std::uint64_t alias, DataType type, double value) {
  PayloadMetric metric;
  metric.alias = alias;
  metric.type = type;
  metric.value = value;
  return metric;
}

TEST(PlantPayload, a_float_of_a_message_of_data) {
  PayloadMessage message{1000, std::nullopt, 7};
  message.metrics.push_back(number(3, DataType::float32, 1.5));
  const Bytes wanted = {0x08, 0xE8, 0x07,              // timestamp = 1 : 1000
                        0x12, 0x0C,                    // metrics = 2, 12 bytes
                        0x10, 0x03,                    // alias = 2 : 3
                        0x18, 0xE8, 0x07,              // timestamp = 3 : 1000
                        0x20, 0x09,                    // datatype = 4 : Float
                        0x65, 0x00, 0x00, 0xC0, 0x3F,  // float_value = 12 : 1.5
                        0x18, 0x07};                   // seq = 3 : 7
  EXPECT_EQ(encode_payload(message), wanted);
}

TEST(PlantPayload, a_zero_is_said_and_so_is_the_first_number_of_a_birth) {
  PayloadMessage message{1, std::nullopt, 0};
  message.metrics.push_back(number(0, DataType::uint16, 0.0));
  EXPECT_EQ(encode_payload(message),
            (Bytes{0x08, 0x01, 0x12, 0x08, 0x10, 0x00, 0x18, 0x01, 0x20, 0x06, 0x50, 0x00, 0x18, 0x00}));
}

TEST(PlantPayload, without_a_value_it_is_null_and_has_no_other) {
  PayloadMessage message{1, std::nullopt, 1};
  message.metrics.push_back(number(2, DataType::float32, std::numeric_limits<double>::quiet_NaN()));
  message.metrics.back().quality = MetricQuality::bad;
  const Bytes wanted = {0x08, 0x01,                                         // timestamp
                        0x12, 0x19,                                         // metrics
                        0x10, 0x02,                                         // alias
                        0x18, 0x01,                                         // timestamp
                        0x20, 0x09,                                         // datatype
                        0x38, 0x01,                                         // is_null = 7 : true
                        0x4A, 0x0F,                                         // properties = 9
                        0x0A, 0x07, 'Q',  'u',  'a',  'l',  'i', 't', 'y',  // keys = 1
                        0x12, 0x04, 0x08, 0x03, 0x18, 0x00,  // values = 2 : type Int32, int_value = 3 : 0
                        0x18, 0x01};
  EXPECT_EQ(encode_payload(message), wanted);
}

TEST(PlantPayload, negative_numbers_are_the_twos_complement_in_32_bits) {
  PayloadMessage message{1};
  message.metrics.push_back(number(1, DataType::int32, -2.0));
  const Bytes made = encode_payload(message);
  EXPECT_EQ(Bytes(made.end() - 6, made.end()), (Bytes{0x50, 0xFE, 0xFF, 0xFF, 0xFF, 0x0F}));
}

TEST(PlantPayload, what_does_not_fit_is_clipped) {
  PayloadMessage message{1};
  message.metrics.push_back(number(1, DataType::uint16, 1e12));
  const Bytes made = encode_payload(message);
  EXPECT_EQ(Bytes(made.end() - 4, made.end()), (Bytes{0x50, 0xFF, 0xFF, 0x03}));
}

/// Sparkplug 3.0.0, 6.4.16 and 6.4.17.
TEST(PlantPayload, each_type_has_the_standards_number_and_field) {
  const auto last_of = [](DataType type, double value, std::size_t bytes) {
    PayloadMessage message{1};
    message.metrics.push_back(number(1, type, value));
    const Bytes made = encode_payload(message);
    return Bytes(made.end() - static_cast<long>(bytes), made.end());
  };
  EXPECT_EQ(last_of(DataType::int32, 5.0, 4), (Bytes{0x20, 3, 0x50, 5}));
  EXPECT_EQ(last_of(DataType::int64, 5.0, 4), (Bytes{0x20, 4, 0x58, 5}));
  EXPECT_EQ(last_of(DataType::uint16, 5.0, 4), (Bytes{0x20, 6, 0x50, 5}));
  EXPECT_EQ(last_of(DataType::boolean, 5.0, 4), (Bytes{0x20, 11, 0x70, 1}));
  EXPECT_EQ(last_of(DataType::boolean, 0.0, 4), (Bytes{0x20, 11, 0x70, 0}));
  EXPECT_EQ(last_of(DataType::int64, 4294967295.0, 6), (Bytes{0x58, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F}));
  PayloadMessage text{1};
  text.metrics.push_back(number(1, DataType::string, 0.0));
  text.metrics.back().text = "ab";
  const Bytes made = encode_payload(text);
  EXPECT_EQ(Bytes(made.end() - 6, made.end()), (Bytes{0x20, 12, 0x7A, 2, 'a', 'b'}));
  for (const auto& [quality, code] :
       {std::pair{MetricQuality::bad, 0U}, {MetricQuality::good, 192U}, {MetricQuality::stale, 500U}}) {
    EXPECT_EQ(static_cast<std::uint32_t>(quality), code);
  }
}

TEST(PlantPayload, a_metric_with_a_unit_and_a_quality_has_both_as_properties_and_with_one_has_that) {
  const auto properties = [](const std::string& unit, std::optional<MetricQuality> quality) {
    PayloadMessage message{1};
    message.metrics.push_back(number(1, DataType::uint16, 5.0));
    message.metrics.back().unit = unit;
    message.metrics.back().quality = quality;
    const Bytes made = encode_payload(message);
    return std::string(made.begin(), made.end());
  };
  const std::string unit_key =
                        "\x0A\x07"
                        "engUnit",
                    quality_key = "\x0A\x07Quality";
  const std::string unit_value(
      "\x12\x06\x08\x0C\x42\x02"
      "um",
      8);
  const std::string quality_value("\x12\x05\x08\x03\x18\xC0\x01", 7);
  for (const bool unit : {false, true}) {
    for (const bool quality : {false, true}) {
      const std::string made =
          properties(unit ? "um" : "", quality ? std::optional(MetricQuality::good) : std::nullopt);
      const auto has = [&](const std::string& part) { return made.find(part) != std::string::npos; };
      EXPECT_EQ(has(unit_key), unit);
      EXPECT_EQ(has(unit_value), unit);
      EXPECT_EQ(has(quality_key), quality);
      EXPECT_EQ(has(quality_value), quality);
    }
  }
}

Bytes order(const std::string& name, bool value) {
  PayloadMessage message{5};
  message.metrics.push_back(number(0, DataType::boolean, value ? 1.0 : 0.0));
  message.metrics.back().alias.reset();
  message.metrics.back().name = name;
  return encode_payload(message);
}

TEST(PlantPayload, an_order_is_known_by_its_name_and_only_when_it_is_true) {
  EXPECT_TRUE(sets_true(order("Node Control/Rebirth", true), "Node Control/Rebirth"));
  EXPECT_FALSE(sets_true(order("Node Control/Rebirth", false), "Node Control/Rebirth"));
  EXPECT_FALSE(sets_true(order("Node Control/Reboot", true), "Node Control/Rebirth"));
  EXPECT_FALSE(sets_true({}, "Node Control/Rebirth"));
  Bytes damaged{0x12, 0x02, 0xFF, 0xFF};  // a metric whose first key has no end
  const Bytes whole = order("Node Control/Rebirth", true);
  damaged.insert(damaged.end(), whole.begin(), whole.end());
  EXPECT_FALSE(sets_true(damaged, "Node Control/Rebirth"));
}

TEST(PlantPayload, a_damaged_order_is_mostly_none_and_harms_nobody) {
  const Bytes whole = order("Node Control/Rebirth", true);
  ASSERT_TRUE(sets_true(whole, "Node Control/Rebirth"));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(sets_true(std::span(whole).first(length), "Node Control/Rebirth")) << length;
  }
  std::mt19937 random(1);
  std::uniform_int_distribution<int> any(0, 255);
  int taken = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    Bytes bytes = whole;
    for (int flips = 0; flips < 3; ++flips) {
      bytes[static_cast<std::size_t>(any(random)) % bytes.size()] = static_cast<std::uint8_t>(any(random));
    }
    taken += sets_true(bytes, "Node Control/Rebirth") ? 1 : 0;
  }
  EXPECT_LT(taken, 2000) << "one that says nothing of the order's name and value may be flipped";
}

}  // namespace plant_payload_test
}  // namespace spindle_twin::firmware
