#include "tests/fuzz/check_modbus.hpp"

#include <modbus.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <vector>

#include "firmware/serve/command_registers.hpp"
#include "firmware/serve/device_identification.hpp"
#include "firmware/serve/frame_gate.hpp"
#include "firmware/serve/register_map.hpp"
#include "tests/fuzz/require.hpp"

namespace spindle_twin::firmware {
namespace {

/// libmodbus as the server has it, on a pair of sockets in the place of a connection.
class Modbus {
 public:
  Modbus()
      : modbus_(modbus_new_tcp(nullptr, 0), modbus_free),
        mapping_(modbus_mapping_new(0, 0, static_cast<int>(image_size()), static_cast<int>(image_size())),
                 modbus_mapping_free) {
    require(modbus_ && mapping_ && socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends_.data()) == 0, "sockets");
    modbus_set_socket(modbus_.get(), ends_[0]);
    modbus_set_response_timeout(modbus_.get(), 0, 1);
  }
  ~Modbus() {
    for (const int end : ends_) close(end);
  }
  Modbus(const Modbus&) = delete;
  Modbus& operator=(const Modbus&) = delete;

  std::vector<std::uint8_t> answer(std::span<const std::uint8_t> frame) {
    require(send(ends_[1], frame.data(), frame.size(), 0) == static_cast<ssize_t>(frame.size()), "a frame is sent");
    std::array<std::uint8_t, MODBUS_TCP_MAX_ADU_LENGTH> query{};
    const int length = modbus_receive(modbus_.get(), query.data());
    require(length == static_cast<int>(frame.size()), "libmodbus takes what the gate took for a frame");
    require(modbus_reply(modbus_.get(), query.data(), length, mapping_.get()) > 0, "libmodbus answers");
    return taken();
  }
  std::vector<std::uint8_t> refuse(std::span<const std::uint8_t> frame, std::uint8_t exception) {
    std::array<std::uint8_t, longest_frame> query{};
    std::copy(frame.begin(), frame.end(), query.begin());
    query[mbap_bytes] &= 0x7FU;
    require(modbus_reply_exception(modbus_.get(), query.data(), exception) > 0, "libmodbus refuses");
    return taken();
  }
  const std::uint16_t* registers() const { return mapping_->tab_registers; }

 private:
  std::vector<std::uint8_t> taken() const {
    std::vector<std::uint8_t> reply(2 * longest_frame);
    const ssize_t size = recv(ends_[1], reply.data(), reply.size(), 0);
    reply.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return reply;
  }

  std::unique_ptr<modbus_t, decltype(&modbus_free)> modbus_;
  std::unique_ptr<modbus_mapping_t, decltype(&modbus_mapping_free)> mapping_;
  std::array<int, 2> ends_{-1, -1};
};

/// Same transaction, protocol 0, its own length, same unit, same function or its exception.
void check_answer(std::span<const std::uint8_t> request, std::span<const std::uint8_t> reply) {
  require(reply.size() > mbap_bytes + 1 && reply.size() <= longest_frame, "an answer is a frame");
  require(std::equal(reply.begin(), reply.begin() + 4, request.begin()), "an answer has its request's transaction");
  require((std::size_t{reply[4]} << 8U) + reply[5] + 6 == reply.size(), "an answer has its own length");
  require(reply[6] == request[6], "an answer has its request's unit");
  require((reply[7] & 0x7FU) == (request[7] & 0x7FU), "an answer has its request's function");
}

void check_gate(std::span<const std::uint8_t> bytes, const Gate& gate) {
  if (gate.verdict == Verdict::wait) {
    require(gate.bytes > bytes.size() && gate.bytes <= longest_frame, "what is awaited is more than there is");
    return;
  }
  require(gate.bytes <= bytes.size() && gate.bytes <= longest_frame, "a frame is there");
  // What is no Modbus/TCP is known from its header.
  const std::size_t known_from = gate.verdict == Verdict::close ? mbap_bytes : gate.bytes;
  for (std::size_t length = known_from; length <= std::min(bytes.size(), known_from + 9); ++length) {
    const Gate early = judge_frame(bytes.first(length), writable_registers(), writable_registers());
    require(early.verdict == gate.verdict && early.bytes == gate.bytes && early.exception == gate.exception,
            "a verdict does not depend on what follows the frame");
  }
  for (std::size_t length = 0; length < gate.bytes && gate.verdict != Verdict::close; ++length) {
    require(judge_frame(bytes.first(length), writable_registers(), writable_registers()).verdict == Verdict::wait,
            "a frame that is not whole is waited for");
  }
  const WriteRange writable = writable_registers(), write = gate.write;
  require(write.count >= 0 && (write.count == 0 || (write.address >= writable.address &&
                                                    write.address + write.count <= writable.address + writable.count)),
          "only the command block is written");
}

}  // namespace

RequestCount checked_requests(std::span<const std::uint8_t> bytes) {
  static Modbus modbus;
  RequestCount count;
  RegisterImage image{};
  PlcSignals told;
  while (!bytes.empty()) {
    const Gate gate = judge_frame(bytes, writable_registers(), writable_registers());
    check_gate(bytes, gate);
    if (gate.verdict == Verdict::wait) break;
    count.closed = gate.verdict == Verdict::close;
    if (count.closed) break;
    const auto frame = bytes.first(gate.bytes);
    bytes = bytes.subspan(gate.bytes);
    if (gate.verdict == Verdict::refuse) {
      const std::vector<std::uint8_t> refusal = modbus.refuse(frame, gate.exception);
      check_answer(frame, refusal);
      require((refusal[mbap_bytes] & 0x80U) != 0, "a refusal is an exception");
      ++count.refused;
      continue;
    }
    check_answer(frame, gate.verdict == Verdict::identify ? identify_device(frame) : modbus.answer(frame));
    ++count.answered;
    if (gate.verdict != Verdict::hand_over || gate.write.count == 0) continue;
    const WriteRange writable = writable_registers();
    std::copy_n(modbus.registers() + writable.address, writable.count, image.begin() + writable.address);
    require(take_orders(gate.write, {}, image).size() <= most_orders, "a request brings no more orders than fit");
    take_signals(gate.write, 1, image, told);
  }
  return count;
}

}  // namespace spindle_twin::firmware
