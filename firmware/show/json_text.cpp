#include "firmware/show/json_text.hpp"

#include <spdlog/fmt/fmt.h>

#include <iterator>

namespace spindle_twin::firmware {

std::string json_text(std::string_view text) {
  std::string out = "\"";
  for (const char each : text) {
    if (each == '"' || each == '\\') {
      out.append(1, '\\').append(1, each);
    } else if (static_cast<unsigned char>(each) < 0x20) {
      fmt::format_to(std::back_inserter(out), "\\u{:04x}", static_cast<unsigned>(each));
    } else {
      out += each;
    }
  }
  return out + "\"";
}

}  // namespace spindle_twin::firmware
