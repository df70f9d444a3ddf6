#include "firmware/serve/device_identification.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

/// The answers of the Modbus application protocol 1.1b3, 6.21.
namespace spindle_twin::firmware {
namespace serve_device_identification_test {

using Bytes = std::vector<std::uint8_t>;

const std::vector<std::string> texts{"spindle-twin", "spindle-twind", SPINDLE_TWIN_VERSION, "",
                                     "Thermal twin of a CNC spindle"};

Bytes asked(std::uint8_t category, std::uint8_t first) { return {0xAB, 0xCD, 0, 0, 0, 5, 17, 43, 14, category, first}; }

/// The objects from `first` to before `end`, in the frame of the request.
Bytes answer(std::uint8_t category, std::size_t first, std::size_t end) {
  Bytes pdu{43, 14, category, 0x82, 0, 0, static_cast<std::uint8_t>(end - first)};
  for (std::size_t id = first; id < end; ++id) {
    pdu.push_back(static_cast<std::uint8_t>(id));
    pdu.push_back(static_cast<std::uint8_t>(texts[id].size()));
    pdu.insert(pdu.end(), texts[id].begin(), texts[id].end());
  }
  Bytes frame{0xAB, 0xCD, 0, 0, 0, static_cast<std::uint8_t>(pdu.size() + 1), 17};
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

TEST(DeviceIdentification, a_stream_goes_from_the_object_that_is_asked_for_to_the_last_of_its_category) {
  for (const auto& [category, end] : {std::pair{std::uint8_t{1}, std::uint8_t{3}}, {2, 5}, {3, 5}}) {
    for (std::uint8_t first = 0; first < end; ++first) {
      EXPECT_EQ(identify_device(asked(category, first)), answer(category, first, end)) << +category << " " << +first;
    }
  }
}

TEST(DeviceIdentification, a_stream_from_beyond_its_last_object_begins_with_the_first) {
  for (const auto& [category, end] : {std::pair{std::uint8_t{1}, std::uint8_t{3}}, {2, 5}, {3, 5}}) {
    for (const int first : {end + 0, 128, 255}) {
      EXPECT_EQ(identify_device(asked(category, static_cast<std::uint8_t>(first))), answer(category, 0, end))
          << +category << " " << first;
    }
  }
}

TEST(DeviceIdentification, each_object_is_there_by_itself_and_the_one_beyond_the_last_is_exception_2) {
  for (std::uint8_t id = 0; id < 5; ++id) EXPECT_EQ(identify_device(asked(4, id)), answer(4, id, id + std::size_t{1}));
  for (const std::uint8_t id : Bytes{5, 6, 255}) {
    EXPECT_EQ(identify_device(asked(4, id)), (Bytes{0xAB, 0xCD, 0, 0, 0, 3, 17, 0xAB, 2}));
  }
}

TEST(DeviceIdentification, an_unknown_category_is_exception_3) {
  for (const std::uint8_t category : Bytes{0, 5, 255}) {
    EXPECT_EQ(identify_device(asked(category, 0)), (Bytes{0xAB, 0xCD, 0, 0, 0, 3, 17, 0xAB, 3}));
  }
}

}  // namespace serve_device_identification_test
}  // namespace spindle_twin::firmware
