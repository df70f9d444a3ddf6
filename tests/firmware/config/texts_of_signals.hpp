#pragma once

#include <string>

namespace spindle_twin::firmware {

/// A configuration in which a PLC tells every signal; tables may follow.
inline const std::string all_from_the_plc = R"(network = "small.rom"
[serve]
[signals]
speed = { source = "plc" }
load = { source = "plc" }
coolant = { source = "plc" }
ambient = { source = "plc" }
)";

}  // namespace spindle_twin::firmware
