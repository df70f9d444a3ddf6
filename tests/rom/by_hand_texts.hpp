#pragma once

#include <string>

namespace spindle_twin::rom::tests {

/// A network written by hand: turning at 1000 rpm in a room of 20 degC, from which its rises count; `rest` follows.
inline std::string in_a_room(const std::string& name, const std::string& rest) {
  std::string text = "name = \"";
  text += name;
  text += R"("
[operating]
speed_rpm = 1000.0
reference_temperature_degC = 20.0
temperatures_degC = { room = 20.0 }
[[surrounding]]
name = "room"
kind = "ambient"
)";
  text += rest;
  return text;
}

}  // namespace spindle_twin::rom::tests
