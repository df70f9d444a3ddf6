#include "tests/fuzz/check_description.hpp"

#include <stdexcept>

#include "fem_offline/mesh/mesh_quality.hpp"

namespace spindle_twin::fem_offline {

std::string checked(const std::string& text) {
  constexpr double element_limit = 2e4;
  try {
    const Spindle spindle = parse_spindle(text, "input.toml");
    const Section section = build_section(spindle);
    mesh_quality(spindle, mesh_section(spindle, section, element_limit));
  } catch (const rom::InputError& error) {
    const std::string message = error.what();
    const std::string file = "input.toml:";
    if (!message.starts_with(file) || message.size() == file.size() || message[file.size()] < '1' ||
        message[file.size()] > '9') {
      throw std::logic_error("no file and line: " + message);
    }
    return message;
  }
  return "";
}

}  // namespace spindle_twin::fem_offline
