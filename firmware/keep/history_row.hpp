#pragma once

#include <string>

#include "firmware/cycle/snapshot.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// The header and one row of the history: a CSV with a row per cycle, temperatures in degC, lengths in um, empty
/// fields for values that do not exist. Readings and signals to the last bit, as `spindle-twin replay` reads them back.
std::string history_header(const rom::Network& network);
std::string history_row(const Snapshot& snapshot);

}  // namespace spindle_twin::firmware
