#pragma once

#include <memory>
#include <string>

#include "firmware/config/daemon_config.hpp"
#include "firmware/cycle/cycle.hpp"
#include "rom/file/rom_file.hpp"

namespace spindle_twin::firmware {

/// One spindle, ready to run: what its configuration and its network have become. Stays where it is, as the cycle
/// refers to network and plan.
struct PreparedSpindle {
  explicit PreparedSpindle(ConfiguredSpindle configured);
  PreparedSpindle(const PreparedSpindle&) = delete;
  PreparedSpindle& operator=(const PreparedSpindle&) = delete;

  double cycle_s() const { return plan.cycle.period_s / plan.cycle.clock_rate; }  ///< clock time from cycle to cycle

  /// Of the network that the configuration names; another one than `file` where that was accepted in an exchange.
  std::string configured_sha256;
  std::string sha256_before;  ///< of the network that an accepted one took the place of; else empty
  std::string note;           ///< for the log: why an accepted network is not run; else empty

  const std::string name;  ///< empty: the only one
  const int unit;
  const Config config;
  const rom::RomFile file;
  const SpindlePlan plan;
  Cycle cycle;
};

/// Reads the spindle's network and binds the configuration to it. Throws rom::InputError with file, line and field.
/// Where the slot has a network that was accepted in place of the configured one, and which still can be run, that one
/// is taken. Not for the cycle.
std::unique_ptr<PreparedSpindle> prepare(ConfiguredSpindle configured);

/// The same spindle with the network of the file `path`, which must carry a trusted signature and have the same names
/// in the same order. Throws rom::InputError that names what does not fit, and what is allowed.
std::unique_ptr<PreparedSpindle> prepare_with(const PreparedSpindle& spindle, const std::string& path);

/// Where the network stands that was accepted in place of the configured one, and the one accepted before it. Their
/// names carry the configured network's hash: who configures another network is not given the accepted one.
std::string accepted_path(const PreparedSpindle& spindle);
std::string previous_path(const PreparedSpindle& spindle);

/// "signed by KEY" or "not signed".
std::string signer(const rom::RomFile& file);

}  // namespace spindle_twin::firmware
