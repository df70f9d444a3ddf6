#include "firmware/serve/frame_gate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "firmware/serve/device_identification.hpp"

namespace spindle_twin::firmware {
namespace serve_frame_gate_test {

using Bytes = std::vector<std::uint8_t>;
constexpr WriteRange writable{1000, 6};

Bytes framed(const Bytes& pdu, std::uint8_t unit = 1) {
  Bytes frame(mbap_bytes + pdu.size());
  frame[0] = 0xAB;
  frame[5] = static_cast<std::uint8_t>(pdu.size() + 1);
  frame[6] = unit;
  std::copy(pdu.begin(), pdu.end(), frame.begin() + mbap_bytes);
  return frame;
}

const Bytes read_ten{4, 0, 0, 0, 10};

TEST(FrameGate, waits_until_the_last_byte_then_hands_over) {
  const Bytes frame = framed(read_ten);
  for (std::size_t n = 0; n < frame.size(); ++n) {
    const Gate gate = judge_frame(std::span(frame).first(n), writable);
    EXPECT_EQ(gate.verdict, Verdict::wait) << n;
    EXPECT_EQ(gate.bytes, n < mbap_bytes ? mbap_bytes : frame.size()) << n;
  }
  Bytes two(2 * frame.size());
  std::copy(frame.begin(), frame.end(), std::copy(frame.begin(), frame.end(), two.begin()));
  const Gate gate = judge_frame(two, writable);
  EXPECT_EQ(gate.verdict, Verdict::hand_over);
  EXPECT_EQ(gate.bytes, frame.size());
}

TEST(FrameGate, closes_on_another_protocol_and_on_impossible_lengths) {
  for (const std::size_t byte_of_protocol : {2U, 3U}) {
    Bytes frame = framed(read_ten);
    frame[byte_of_protocol] = 1;
    EXPECT_EQ(judge_frame(frame, writable).verdict, Verdict::close) << byte_of_protocol;
  }
  for (const int length : {0, 1, 255, 1000, 65535}) {
    Bytes wrong = framed(read_ten);
    wrong[4] = static_cast<std::uint8_t>(length >> 8);
    wrong[5] = static_cast<std::uint8_t>(length & 255);
    EXPECT_EQ(judge_frame(wrong, writable).verdict, Verdict::close) << length;
  }
}

TEST(FrameGate, answers_units_0_1_and_255_only) {
  for (int unit = 0; unit < 256; ++unit) {
    const Gate gate = judge_frame(framed(read_ten, static_cast<std::uint8_t>(unit)), writable);
    const bool ours = unit == 0 || unit == 1 || unit == 255;
    EXPECT_EQ(gate.verdict, ours ? Verdict::hand_over : Verdict::refuse) << unit;
    EXPECT_EQ(gate.exception, ours ? 0 : 11) << unit;
  }
}

TEST(FrameGate, refuses_functions_that_are_not_served) {
  for (int function = 0; function < 256; ++function) {
    const bool served = function == 3 || function == 4 || function == 6 || function == 16 || function == 22 ||
                        function == 23 || function == 43;
    if (served) continue;
    const Gate gate = judge_frame(framed({static_cast<std::uint8_t>(function), 0, 0, 0, 1}), writable);
    EXPECT_EQ(gate.verdict, Verdict::refuse) << function;
    EXPECT_EQ(gate.exception, 1) << function;
  }
}

TEST(FrameGate, refuses_a_length_or_quantity_that_contradicts_the_function) {
  for (const Bytes& pdu : {Bytes{4, 0, 0, 0}, Bytes{4, 0, 0, 0, 1, 9}, Bytes{16, 3, 232, 0, 1, 2, 0},
                           Bytes{16, 3, 232, 0, 2, 2, 0, 0}, Bytes{3, 0, 0, 0, 0}, Bytes{3, 0, 0, 0, 126}, Bytes{4}}) {
    const Gate gate = judge_frame(framed(pdu), writable);
    EXPECT_EQ(gate.verdict, Verdict::refuse) << pdu.size();
    EXPECT_EQ(gate.exception, 3) << pdu.size();
  }
}

/// A whole request from register 1000 on: of 3, 4 and 16 `quantity` registers, of 23 as many read and `written`
/// written.
Bytes whole_request(std::uint8_t function, int quantity, int written = 1) {
  Bytes pdu{function, 3, 232, static_cast<std::uint8_t>(quantity >> 8), static_cast<std::uint8_t>(quantity & 255)};
  if (function == 22) pdu.resize(7);
  if (function == 23) {
    for (const int byte : {3, 233, 0, written}) pdu.push_back(static_cast<std::uint8_t>(byte));
  }
  if (function == 16 || function == 23) {
    const int bytes = 2 * (function == 16 ? quantity : written);
    pdu.push_back(static_cast<std::uint8_t>(bytes));
    pdu.resize(pdu.size() + static_cast<std::size_t>(bytes));
  }
  return pdu;
}
constexpr WriteRange all_registers{0, 65536};

/// Modbus application protocol 1.1b3: 125 registers are read at the most, 123 written, 121 where both is done.
TEST(FrameGate, takes_one_register_up_to_as_many_as_the_standard_allows) {
  const auto expect = [](const Bytes& pdu, int exception) {
    const Gate gate = judge_frame(framed(pdu), all_registers);
    EXPECT_EQ(gate.exception, exception) << int{pdu[0]} << " " << int{pdu[3]} << " " << int{pdu[4]};
    EXPECT_EQ(gate.verdict, exception == 0 ? Verdict::hand_over : Verdict::refuse);
  };
  for (const std::uint8_t function : {std::uint8_t{3}, std::uint8_t{4}}) {
    for (const int quantity : {1, 125}) expect(whole_request(function, quantity), 0);
    for (const int quantity : {0, 126, 257}) expect(whole_request(function, quantity), 3);
  }
  for (const int quantity : {1, 123}) expect(whole_request(16, quantity), 0);
  expect(whole_request(16, 0), 3);
  expect(whole_request(23, 1, 1), 0);
  expect(whole_request(23, 125, 121), 0);
  for (const auto& [read, written] : {std::pair{0, 1}, {126, 1}, {1, 0}}) expect(whole_request(23, read, written), 3);
}

TEST(FrameGate, says_which_registers_a_request_writes) {
  const auto written = [](const Bytes& pdu) { return judge_frame(framed(pdu), all_registers).write; };
  for (const std::uint8_t function : {std::uint8_t{3}, std::uint8_t{4}}) {
    EXPECT_EQ(written(whole_request(function, 9)).count, 0);
  }
  for (const std::uint8_t function : {std::uint8_t{6}, std::uint8_t{22}}) {
    EXPECT_EQ(written(whole_request(function, 9)).address, 1000);
    EXPECT_EQ(written(whole_request(function, 9)).count, 1) << "what stands there is its value";
  }
  EXPECT_EQ(written(whole_request(16, 9)).address, 1000);
  EXPECT_EQ(written(whole_request(16, 9)).count, 9);
  EXPECT_EQ(written(whole_request(23, 9, 4)).address, 1001) << "not what it reads";
  EXPECT_EQ(written(whole_request(23, 9, 4)).count, 4);
}

TEST(FrameGate, a_request_that_is_a_byte_shorter_or_longer_than_it_says_is_exception_3) {
  for (const std::uint8_t function : Bytes{3, 4, 6, 16, 22, 23}) {
    const Bytes whole = whole_request(function, 2, 2);
    EXPECT_EQ(judge_frame(framed(whole), all_registers).verdict, Verdict::hand_over) << int{function};
    for (std::size_t n = 1; n <= whole.size() + 1; ++n) {
      Bytes wrong = whole;
      wrong.resize(n);
      if (n != whole.size()) {
        EXPECT_EQ(judge_frame(framed(wrong), all_registers).exception, 3) << int{function} << " " << n;
      }
    }
  }
  for (const auto& [function, place] : {std::pair{16, 5}, {23, 9}}) {
    Bytes wrong = whole_request(static_cast<std::uint8_t>(function), 2, 2);
    wrong[static_cast<std::size_t>(place)] = 2;
    wrong.resize(wrong.size() - 2);
    EXPECT_EQ(judge_frame(framed(wrong), all_registers).exception, 3) << function << ": quantity 2, bytes of one";
  }
}

TEST(FrameGate, a_frame_of_260_bytes_is_judged) {
  Bytes longest = whole_request(4, 1);
  longest.resize(253);
  const Gate gate = judge_frame(framed(longest), all_registers);
  EXPECT_EQ(gate.exception, 3);
  EXPECT_EQ(gate.bytes, longest_frame);
}

TEST(FrameGate, of_function_43_only_device_identification_of_four_bytes_is_served) {
  for (const Bytes& other : {Bytes{43}, Bytes{43, 13}, Bytes{43, 13, 1, 0}, Bytes{43, 15, 1, 0}}) {
    EXPECT_EQ(judge_frame(framed(other), writable).exception, 1) << other.size();
  }
  for (const Bytes& wrong : {Bytes{43, 14}, Bytes{43, 14, 1}, Bytes{43, 14, 1, 0, 0}}) {
    EXPECT_EQ(judge_frame(framed(wrong), writable).exception, 3) << wrong.size();
  }
}

TEST(FrameGate, lets_writes_pass_only_inside_the_command_block) {
  const auto single = [](int address) {
    return framed({6, static_cast<std::uint8_t>(address >> 8), static_cast<std::uint8_t>(address & 255), 0, 1});
  };
  EXPECT_EQ(judge_frame(single(1000), writable).verdict, Verdict::hand_over);
  EXPECT_EQ(judge_frame(single(1005), writable).verdict, Verdict::hand_over);
  for (const int address : {0, 999, 1006, 65535}) {
    const Gate gate = judge_frame(single(address), writable);
    EXPECT_EQ(gate.verdict, Verdict::refuse) << address;
    EXPECT_EQ(gate.exception, 2) << address;
  }
  EXPECT_EQ(judge_frame(framed({16, 3, 237, 0, 2, 4, 0, 1, 0, 1}), writable).exception, 2);
  EXPECT_EQ(judge_frame(framed({23, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 1}), writable).exception, 2);
}

TEST(FrameGate, input_registers_leave_out_those_that_are_holding_only) {
  const auto read = [](std::uint8_t function, int address, int count) {
    const Bytes frame = framed({function, static_cast<std::uint8_t>(address >> 8),
                                static_cast<std::uint8_t>(address & 255), 0, static_cast<std::uint8_t>(count)});
    return judge_frame(frame, writable, writable);
  };
  EXPECT_EQ(read(4, 999, 1).verdict, Verdict::hand_over);
  EXPECT_EQ(read(4, 1006, 1).verdict, Verdict::hand_over);
  EXPECT_EQ(read(3, 999, 8).verdict, Verdict::hand_over);
  for (const auto& [address, count] : {std::pair{1000, 1}, std::pair{1005, 1}, std::pair{999, 2}, std::pair{990, 30}}) {
    const Gate gate = read(4, address, count);
    EXPECT_EQ(gate.verdict, Verdict::refuse) << address;
    EXPECT_EQ(gate.exception, 2) << address;
  }
}

TEST(FrameGate, random_bytes_never_reach_beyond_what_was_received) {
  constexpr unsigned seed = 20240611;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> byte(0, 255);
  std::uniform_int_distribution<std::size_t> size(0, longest_frame);
  for (int trial = 0; trial < 20000; ++trial) {
    Bytes bytes(size(random));
    for (auto& b : bytes) b = static_cast<std::uint8_t>(byte(random));
    if (bytes.size() > 5 && trial % 2 == 0) bytes[2] = bytes[3] = bytes[4] = 0;
    const Gate gate = judge_frame(bytes, writable);
    if (gate.verdict == Verdict::wait) {
      EXPECT_GT(gate.bytes, bytes.size());
    } else if (gate.verdict != Verdict::close) {
      EXPECT_LE(gate.bytes, bytes.size());
    }
    EXPECT_TRUE(gate.write.count == 0 || gate.write.address >= writable.address);
    EXPECT_EQ(gate.exception != 0, gate.verdict == Verdict::refuse);
  }
}

TEST(DeviceIdentification, basic_category_lists_three_objects) {
  const Bytes request = framed({43, 14, 1, 0});
  EXPECT_EQ(judge_frame(request, writable).verdict, Verdict::identify);
  EXPECT_EQ(judge_frame(request, writable).exception, 0);
  const Bytes reply = identify_device(request);
  EXPECT_EQ(reply[0], 0xAB);
  EXPECT_EQ(reply[5] + 6U, reply.size());
  EXPECT_EQ(reply[7], 43);
  EXPECT_EQ(reply[13], 3);
  EXPECT_EQ(std::string(reply.begin() + 16, reply.begin() + 16 + reply[15]), "spindle-twin");
}

TEST(DeviceIdentification, a_single_object_is_the_one_that_was_asked_for) {
  for (const auto& [id, text] : {std::pair{std::uint8_t{1}, "spindle-twind"}, {4, "Thermal twin of a CNC spindle"}}) {
    const Bytes reply = identify_device(framed({43, 14, 4, id}));
    EXPECT_EQ(reply[13], 1);
    EXPECT_EQ(reply[14], id);
    EXPECT_EQ(std::string(reply.begin() + 16, reply.end()), text);
  }
}

TEST(DeviceIdentification, an_object_that_does_not_exist_is_exception_2) {
  const Bytes reply = identify_device(framed({43, 14, 4, 77}));
  EXPECT_EQ(reply[7], 43 | 0x80);
  EXPECT_EQ(reply[8], 2);
}

}  // namespace serve_frame_gate_test
}  // namespace spindle_twin::firmware
