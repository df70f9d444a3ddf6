#pragma once

#include <optional>
#include <string>
#include <vector>

namespace spindle_twin::firmware {

/// TLS to the broker, with a certificate on both sides. PEM files.
struct PlantTls {
  std::string ca;           ///< the authority that has signed the broker's certificate,
  std::string certificate;  ///< the daemon's own, with its chain,
  std::string key;          ///< and its private key

  bool operator==(const PlantTls&) const = default;
};

/// What the plant network needs; made once from the configuration.
struct PlantPlan {
  bool enabled = false;  ///< nothing is published unless the configuration asks for it
  std::string host;      ///< name or IPv4 address of the broker
  int port = 1883;
  std::string group = "spindles";           ///< of the edge node, as Sparkplug calls a daemon
  std::string node;                         ///< its name in the group
  double period_s = 10.0;                   ///< clock time from sample to sample
  int queue = 360;                          ///< samples of each spindle that wait for the broker at most
  std::vector<std::string> registers = {};  ///< whose numbers are published, by shown_name(); none: of all
  std::optional<PlantTls> tls = std::nullopt;

  bool operator==(const PlantPlan&) const = default;
};

inline constexpr int plant_tls_port = 8883;

}  // namespace spindle_twin::firmware
