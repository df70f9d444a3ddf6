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

  const std::string name;  ///< empty: the only one
  const int unit;
  const Config config;
  const rom::RomFile file;
  const SpindlePlan plan;
  Cycle cycle;
};

/// Reads the spindle's network and binds the configuration to it. Throws rom::InputError with file, line and field.
/// Not for the cycle.
std::unique_ptr<PreparedSpindle> prepare(ConfiguredSpindle configured);

/// "signed by KEY" or "not signed".
std::string signer(const rom::RomFile& file);

}  // namespace spindle_twin::firmware
