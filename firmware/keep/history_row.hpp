#pragma once

#include <string>
#include <vector>

#include "firmware/cycle/snapshot.hpp"
#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// The header and one row of the history: a CSV with a row per cycle, temperatures in degC, lengths in um, empty
/// fields for values that do not exist. Readings and signals to the last bit, as `spindle-twin replay` reads them back.
std::string history_header(const rom::Network& network);
std::string history_row(const Snapshot& snapshot);

/// The numbers of the same row, none of them rounded; not finite: the value does not exist.
void history_numbers(const Snapshot& snapshot, std::vector<double>& numbers);

}  // namespace spindle_twin::firmware
