#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/file_header.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"
#include "tests/rom/law_network.hpp"
#include "tests/support/recorded.hpp"
#include "tests/support/text_faults.hpp"
#include "tests/support/wire_faults.hpp"

/// What readers of networks say to each fault of whoever wrote one, as it was when this was recorded.
namespace spindle_twin::rom::tests {
namespace recorded_refusals_test {

using spindle_twin::tests::expect_as_recorded;
using spindle_twin::tests::sum_of_message;
using spindle_twin::tests::text_faults;
using spindle_twin::tests::TextFault;
using spindle_twin::tests::WireFaults;

constexpr spindle_twin::tests::Tolerance tolerance{1e-11};

/// A sum that changes with any number of the network.
std::string sum_of(const Network& network) {
  const std::vector<std::uint8_t> bytes = encode_network(network);
  char text[32];
  std::snprintf(text, sizeof text, "%.13g", sum_of_message(std::span(bytes).subspan(header::size)));
  return text;
}

template <class Read>
std::string answer(const Read& read) {
  try {
    return "taken " + sum_of(read());
  } catch (const InputError& error) {
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    return message;
  }
}

void expect_recorded_answers_to_text_faults(const std::string& name, int of_each) {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/" + name + ".toml");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  ASSERT_FALSE(text.empty());
  std::string now;
  for (const TextFault& fault : text_faults(text, of_each)) {
    now += fault.what + " -> " + answer([&] { return parse_by_hand(fault.text, "x.toml"); }) + "\n";
  }
  expect_as_recorded("by_hand_" + name + ".txt", now, tolerance);
}

TEST(RecordedRefusals, a_hand_written_network_of_numbers_with_one_mistake) {
  expect_recorded_answers_to_text_faults("motor_spindle", 2);
}

TEST(RecordedRefusals, a_hand_written_network_of_laws_with_one_mistake) {
  expect_recorded_answers_to_text_faults("motor_spindle_laws", 2);
}

/// The file of a network with one fault in its payload, and header and hash that fit it.
void expect_recorded_answers_to_wire_faults(const std::string& name, const Network& network, int of_each) {
  const std::vector<std::uint8_t> good = encode_network(network);
  const std::span<const std::uint8_t> payload = std::span(good).subspan(header::size);
  std::string now;
  const WireFaults faults(payload, of_each, [&](const std::string& what, const std::vector<std::uint8_t>& message) {
    std::vector<std::uint8_t> bytes(good.begin(), good.begin() + header::size);
    bytes.insert(bytes.end(), message.begin(), message.end());
    header::put_little_endian(std::uint64_t{message.size()}, bytes.data() + header::length_at);
    const Sha256 hash = sha256(message);
    std::copy(hash.begin(), hash.end(), bytes.begin() + header::hash_at);
    now += what + " -> " + answer([&] { return decode_network(bytes, "x.rom"); }) + "\n";
  });
  expect_as_recorded("network_" + name + ".txt", now, tolerance);
}

TEST(RecordedRefusals, a_network_file_with_one_fault) {
  expect_recorded_answers_to_wire_faults("laws", make_network_with_laws(), 2);
}

TEST(RecordedRefusals, a_certified_network_file_with_one_fault) {
  expect_recorded_answers_to_wire_faults("certified",
                                         read_network(SPINDLE_TWIN_SOURCE_DIR "/tests/rom/old_files/schema_4.rom"), 2);
}

}  // namespace recorded_refusals_test
}  // namespace spindle_twin::rom::tests
