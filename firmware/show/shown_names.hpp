#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rom/network.hpp"

namespace spindle_twin::firmware {

/// The names of a network's outputs, which registers know by number only.
struct ShownNames {
  std::string spindle;
  std::vector<std::string> key_points;
  std::vector<std::string> parts;
  std::vector<std::string> sources;
  std::vector<std::string> conductances;
  std::vector<std::string> deformations;
  std::vector<std::string> circuits;
  std::vector<std::string> heats;  ///< measured ones

  /// Of a register's slots (RegisterEntry::slot_names); null where these have no names.
  const std::vector<std::string>* of(std::string_view slot_names) const;
};

ShownNames names_of(const rom::Network& network);

}  // namespace spindle_twin::firmware
