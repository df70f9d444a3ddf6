#pragma once

#include <optional>
#include <utility>

#include "firmware/serve/descriptor.hpp"

namespace spindle_twin::firmware {

/// Two ends of one TCP connection inside this process, both non-blocking; nobody else can have come between. Not a pair
/// of local sockets: those know no mark below which poll() stays quiet (SO_RCVLOWAT). Empty: with errno.
std::optional<std::pair<Descriptor, Descriptor>> loopback_pair();

}  // namespace spindle_twin::firmware
