#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace spindle_twin::firmware {

/// Takes the payload of a message at the plant's NCMD topic through the node, and gives the reason why it is not
/// obeyed; empty where it asks for all births. Throws std::logic_error where a payload is obeyed in which no metric of
/// the standard's name is set to true, where a damaged one is, and where an order beside another loses or gains by it.
std::string checked_command(std::span<const std::uint8_t> payload);

}  // namespace spindle_twin::firmware
