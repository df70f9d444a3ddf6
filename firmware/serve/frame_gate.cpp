#include "firmware/serve/frame_gate.hpp"

#include <modbus.h>

namespace spindle_twin::firmware {
namespace {

constexpr std::uint8_t read_device_identification = 0x2B;
constexpr std::uint8_t device_identification_mei = 0x0E;

int word_at(std::span<const std::uint8_t> bytes, std::size_t at) { return (bytes[at] << 8) | bytes[at + 1]; }

Gate refused(std::size_t bytes, int exception) {
  return {Verdict::refuse, bytes, static_cast<std::uint8_t>(exception), {}};
}

/// Length of the PDU that a request of this function must have; 0 if its own byte count contradicts its quantity.
std::size_t expected_pdu(std::span<const std::uint8_t> pdu) {
  switch (pdu[0]) {
    case MODBUS_FC_MASK_WRITE_REGISTER:
      return 7;
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
      return pdu.size() >= 6 && 2 * word_at(pdu, 3) == pdu[5] ? std::size_t{6} + pdu[5] : 0;
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
      return pdu.size() >= 10 && 2 * word_at(pdu, 7) == pdu[9] ? std::size_t{10} + pdu[9] : 0;
    default:
      return 5;
  }
}

bool in_range(int quantity, int most) { return quantity >= 1 && quantity <= most; }

/// libmodbus answers a bad quantity by throwing away whatever else the client has sent.
bool quantity_is_allowed(std::span<const std::uint8_t> pdu) {
  switch (pdu[0]) {
    case MODBUS_FC_READ_HOLDING_REGISTERS:
    case MODBUS_FC_READ_INPUT_REGISTERS:
      return in_range(word_at(pdu, 3), MODBUS_MAX_READ_REGISTERS);
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
      return in_range(word_at(pdu, 3), MODBUS_MAX_WRITE_REGISTERS);
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
      return in_range(word_at(pdu, 3), MODBUS_MAX_WR_READ_REGISTERS) &&
             in_range(word_at(pdu, 7), MODBUS_MAX_WR_WRITE_REGISTERS);
    default:
      return true;
  }
}

WriteRange written_by(std::span<const std::uint8_t> pdu) {
  switch (pdu[0]) {
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
    case MODBUS_FC_MASK_WRITE_REGISTER:
      return {word_at(pdu, 1), 1};
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
      return {word_at(pdu, 1), word_at(pdu, 3)};
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
      return {word_at(pdu, 5), word_at(pdu, 7)};
    default:
      return {};
  }
}

WriteRange inputs_read_by(std::span<const std::uint8_t> pdu) {
  if (pdu[0] != MODBUS_FC_READ_INPUT_REGISTERS) return {};
  return {word_at(pdu, 1), word_at(pdu, 3)};
}

bool overlap(WriteRange a, WriteRange b) { return a.address < b.address + b.count && b.address < a.address + a.count; }

}  // namespace

Units units_of_one_spindle() {
  constexpr std::size_t without_setting = 255;
  Units units;
  units.set(0).set(1).set(without_setting);
  return units;
}

Gate judge_frame(std::span<const std::uint8_t> received, WriteRange writable, WriteRange holding_only,
                 const Units& units) {
  if (received.size() < mbap_bytes) return {Verdict::wait, mbap_bytes, 0, {}};
  const int protocol = word_at(received, 2);
  const int length = word_at(received, 4);
  if (protocol != 0 || length < 2 || length > 254) return {Verdict::close, 0, 0, {}};
  const std::size_t bytes = 6 + static_cast<std::size_t>(length);
  if (received.size() < bytes) return {Verdict::wait, bytes, 0, {}};

  if (!units.test(unit_of(received))) return refused(bytes, MODBUS_EXCEPTION_GATEWAY_TARGET);

  const auto pdu = received.subspan(mbap_bytes, bytes - mbap_bytes);
  switch (pdu[0]) {
    case MODBUS_FC_READ_HOLDING_REGISTERS:
    case MODBUS_FC_READ_INPUT_REGISTERS:
    case MODBUS_FC_WRITE_SINGLE_REGISTER:
    case MODBUS_FC_WRITE_MULTIPLE_REGISTERS:
    case MODBUS_FC_MASK_WRITE_REGISTER:
    case MODBUS_FC_WRITE_AND_READ_REGISTERS:
      break;
    case read_device_identification:
      if (pdu.size() < 2 || pdu[1] != device_identification_mei)
        return refused(bytes, MODBUS_EXCEPTION_ILLEGAL_FUNCTION);
      if (pdu.size() != 4) return refused(bytes, MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE);
      return {Verdict::identify, bytes, 0, {}};
    default:
      return refused(bytes, MODBUS_EXCEPTION_ILLEGAL_FUNCTION);
  }
  if (pdu.size() != expected_pdu(pdu) || !quantity_is_allowed(pdu))
    return refused(bytes, MODBUS_EXCEPTION_ILLEGAL_DATA_VALUE);

  const WriteRange write = written_by(pdu);
  const bool inside = write.count == 0 || (write.address >= writable.address &&
                                           write.address + write.count <= writable.address + writable.count);
  if (!inside || overlap(inputs_read_by(pdu), holding_only))
    return refused(bytes, MODBUS_EXCEPTION_ILLEGAL_DATA_ADDRESS);
  return {Verdict::hand_over, bytes, 0, write};
}

}  // namespace spindle_twin::firmware
