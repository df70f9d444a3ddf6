#include "tests/fuzz/check_network_file.hpp"

#include <stdexcept>

#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {

std::string checked_network_file(const std::vector<std::uint8_t>& bytes) {
  const std::string start = "input.rom: ";
  try {
    const std::vector<std::uint8_t> once = encode_network(decode_rom_file(bytes, "input.rom").network);
    if (encode_network(decode_rom_file(once, "again").network) != once)
      throw std::logic_error("changed by a round trip");
  } catch (const InputError& error) {
    const std::string message = error.what();
    if (!message.starts_with(start) || message.size() == start.size()) {
      throw std::logic_error("no file and reason: " + message);
    }
    return message;
  }
  return "";
}

}  // namespace spindle_twin::rom
