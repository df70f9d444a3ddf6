#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "firmware/config/config.hpp"

namespace spindle_twin::firmware {

/// What a configuration file says of a hand-written network's sensors; all other lines as they are by default.
struct DaemonLines {
  double period_s = 1.0;
  std::vector<std::string> sensors = {};  ///< key points
  double noise_K = 0.03;
  double offset_K = 0.02;
  double max_degC = 150.0;
  std::string correction = {};  ///< lines of [correction]
  std::string health = {};      ///< lines of [health]
  std::string signals = {};     ///< further lines of [signals]
  std::string tables = {};      ///< further tables
};

/// The plan that the daemon makes of such a file: a new default of the daemon counts here as well. All signals
/// come from the device.
inline CyclePlan daemon_plan(const rom::Network& network, const DaemonLines& lines) {
  std::ostringstream text;
  text << "network = { file = \"by_hand.rom\", allow_uncertified = true }\n[cycle]\nperiod_s = " << lines.period_s
       << "\n[serve]\nport = 1502\n[device]\naddress = \"127.0.0.1\"\nport = 1503\n";
  for (std::size_t k = 0; k < lines.sensors.size(); ++k) {
    text << "[[sensor]]\nkey_point = \"" << lines.sensors[k] << "\"\nregister = " << 2 * k
         << "\ntype = \"float32\"\nmax_degC = " << lines.max_degC << "\nnoise_K = " << lines.noise_K
         << "\noffset_K = " << lines.offset_K << "\n";
  }
  text << "[signals]\n";
  for (const char* signal : {"speed", "load", "coolant", "ambient"}) {
    text << signal << " = { source = \"device\", register = 0, type = \"float32\" }\n";
  }
  text << lines.signals;
  if (!lines.correction.empty()) text << "[correction]\n" << lines.correction << "\n";
  if (!lines.health.empty()) text << "[health]\n" << lines.health << "\n";
  text << lines.tables;
  if (lines.sensors.empty()) text << "[start]\ntemperature_degC = 20.0\n";
  return bind_config(parse_config(text.str(), "by_hand.toml"), network).cycle;
}

}  // namespace spindle_twin::firmware
