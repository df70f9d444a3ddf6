#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace spindle_twin::firmware {

// Each takes the bytes of a file through its reader and gives the reason why it was refused; empty where it was read.
// Throws std::logic_error where a reason does not begin with the file, and where what was read is not what it should
// be:

/// The message of a checkpoint, behind its hash: written and read again it is the same.
std::string checked_checkpoint(std::span<const std::uint8_t> message);
/// The message of the standing orders, the same.
std::string checked_orders(std::span<const std::uint8_t> message);
/// The message of a calibration, the same.
std::string checked_calibration(std::span<const std::uint8_t> message);
/// A configuration of the daemon.
std::string checked_config(std::span<const std::uint8_t> text);
/// A table of numbers: as many in each row as there are names, none of them infinite.
std::string checked_table(std::span<const std::uint8_t> text);
/// A history in SQLite: each run has the rows that it is said to have.
std::string checked_history(std::span<const std::uint8_t> bytes);

}  // namespace spindle_twin::firmware
