#pragma once

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// A certificate as lines on stdout, what certificate_to_json() holds.
void print_certificate(const rom::Network& network);

}  // namespace spindle_twin::host_tools
