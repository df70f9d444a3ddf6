#pragma once

#include <string>
#include <vector>

#include "firmware/config/config.hpp"

namespace spindle_twin::firmware {

/// One spindle of the daemon.
struct ConfiguredSpindle {
  std::string name;  ///< in log, HTTP and service manager; empty: the daemon's only one, without [[spindle]]
  int unit = 1;      ///< by which Modbus clients ask for it; the only one also answers 0 and 255
  Config config;
};

/// All that the daemon runs. What it has once stands here, not in the spindles' configurations.
struct DaemonConfig {
  std::string log_level = "info";
  ServePlan serve;
  ShowPlan show;
  PlantPlan plant;
  std::vector<ConfiguredSpindle> spindles;  ///< one at least
};

/// The files that a spindle writes: orders, checkpoint, history, parameters.
std::vector<std::string> state_files(const Config& config);

/// For --check: those of them that this user could not write now, as the folder is not there or not his; one each.
std::vector<rom::InputError> unwritable_files(const Config& config);

/// Reads a configuration: of one spindle, or a list of spindles (`[[spindle]]`: name, unit, config) with what they have
/// together ([serve], [http], [plant], log_level) and one file for each. Throws rom::InputError with file, line, field
/// and what is allowed, also where two spindles share a name, a unit, a port or a file that both would write.
DaemonConfig read_daemon_config(const std::string& path);

}  // namespace spindle_twin::firmware
