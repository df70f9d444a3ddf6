#include "firmware/serve/device_identification.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "firmware/serve/frame_gate.hpp"

namespace spindle_twin::firmware {
namespace {

// Object ids 0 to 4: vendor name, product code, revision; vendor URL, product name.
constexpr std::array<std::string_view, 5> objects{"spindle-twin", "spindle-twind", SPINDLE_TWIN_VERSION, "",
                                                  "Thermal twin of a CNC spindle"};
constexpr std::size_t basic_objects = 3;
constexpr std::uint8_t regular_and_individual = 0x82;

std::vector<std::uint8_t> framed(std::span<const std::uint8_t> request, const std::vector<std::uint8_t>& pdu) {
  const std::size_t length = pdu.size() + 1;
  std::vector<std::uint8_t> frame(mbap_bytes + pdu.size());
  frame[0] = request[0];  // transaction; the protocol id stays 0
  frame[1] = request[1];
  frame[4] = static_cast<std::uint8_t>(length >> 8U);
  frame[5] = static_cast<std::uint8_t>(length & 0xFFU);
  frame[6] = request[6];
  std::copy(pdu.begin(), pdu.end(), frame.begin() + mbap_bytes);
  return frame;
}

}  // namespace

std::vector<std::uint8_t> identify_device(std::span<const std::uint8_t> request) {
  const std::uint8_t function = request[mbap_bytes];
  const std::uint8_t category = request[mbap_bytes + 2];
  std::size_t first = request[mbap_bytes + 3];
  std::size_t end = 0;
  const auto exception = [&](std::uint8_t code) {
    return framed(request, {static_cast<std::uint8_t>(function | 0x80U), code});
  };
  switch (category) {
    case 1:
      end = basic_objects;
      break;
    case 2:
    case 3:
      end = objects.size();
      break;
    case 4:
      if (first >= objects.size()) return exception(2);
      end = first + 1;
      break;
    default:
      return exception(3);
  }
  if (first >= end) first = 0;  // a stream that asks for an object beyond the last begins again
  std::vector<std::uint8_t> pdu{function,
                                request[mbap_bytes + 1],
                                category,
                                regular_and_individual,
                                0,
                                0,
                                static_cast<std::uint8_t>(end - first)};
  for (std::size_t id = first; id < end; ++id) {
    pdu.push_back(static_cast<std::uint8_t>(id));
    pdu.push_back(static_cast<std::uint8_t>(objects[id].size()));
    pdu.insert(pdu.end(), objects[id].begin(), objects[id].end());
  }
  return framed(request, pdu);
}

}  // namespace spindle_twin::firmware
