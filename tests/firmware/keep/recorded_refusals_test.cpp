#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <vector>

#include "firmware/keep/checkpoint.hpp"
#include "firmware/keep/orders_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/support/recorded.hpp"
#include "tests/support/wire_faults.hpp"

/// What the readers of the daemon's own files say to each fault behind a hash that fits, as it was when this was
/// recorded.
namespace spindle_twin::firmware {
namespace keep_recorded_refusals_test {

using Bytes = std::vector<std::uint8_t>;
constexpr tests::Tolerance tolerance{1e-11};

/// The same first line with the hash of another message, then that.
Bytes sealed_again(const Bytes& sealed, const Bytes& message) {
  const auto end_of_line = std::find(sealed.begin(), sealed.end(), '\n');
  std::string line(sealed.begin(), end_of_line);
  line.resize(line.rfind(' ') + 1);
  line += rom::sha256_hex({reinterpret_cast<const char*>(message.data()), message.size()}) + "\n";
  Bytes all(line.begin(), line.end());
  all.insert(all.end(), message.begin(), message.end());
  return all;
}

std::span<const std::uint8_t> payload_of(const Bytes& sealed) {
  return std::span(std::find(sealed.begin(), sealed.end(), '\n') + 1, sealed.end());
}

/// What reading makes of the file with each fault: a sum over what is written of that again, or why not.
template <class WriteWhatIsRead>
std::string answers(const Bytes& sealed, const WriteWhatIsRead& again) {
  std::string now;
  const tests::WireFaults faults(payload_of(sealed), 2, [&](const std::string& what, const Bytes& message) {
    std::string answer;
    try {
      const Bytes read = again(sealed_again(sealed, message));
      char text[64];
      std::snprintf(text, sizeof text, "taken %.13g", tests::sum_of_message(payload_of(read)));
      answer = text;
    } catch (const rom::InputError& error) {
      answer = error.what();
    }
    now += what + " -> " + answer + "\n";
  });
  return now;
}

TEST(RecordedRefusals, of_a_checkpoint_with_one_fault) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, estimated(), runtime);
  const Machine machine(network, 0.5);
  for (int n = 0; n < 60; ++n) cycle.step(machine.frame(at_s(n)), {}, at_s(n), 0);
  Checkpoint checkpoint;
  cycle.remember(checkpoint.remembered);
  checkpoint.network_sha256 = std::string(64, 'a');
  checkpoint.saved_unix_s = 1.7e9;
  const std::string now = answers(encode_checkpoint(checkpoint), [](const Bytes& bytes) {
    return encode_checkpoint(decode_checkpoint(bytes, "twin.checkpoint"));
  });
  tests::expect_as_recorded("checkpoint.txt", now, tolerance);
}

TEST(RecordedRefusals, of_an_orders_file_with_one_fault) {
  KeptOrders kept;
  kept.network_sha256 = std::string(64, 'b');
  kept.saved_unix_s = 1.7e9;
  kept.orders = {3, SwitchOrder::off, SwitchOrder::on, 4e-6, 1, {}, {}, 2, true};
  kept.orders.sensor_tare_K.fill(0.25);
  kept.orders.sensor_tare_deviation_K.fill(0.02);
  const std::string now = answers(
      encode_orders(kept), [](const Bytes& bytes) { return encode_orders(decode_orders(bytes, "twin.orders")); });
  tests::expect_as_recorded("orders.txt", now, tolerance);
}

}  // namespace keep_recorded_refusals_test
}  // namespace spindle_twin::firmware
