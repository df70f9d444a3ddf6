#pragma once

#include <nlohmann/json.hpp>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

inline nlohmann::ordered_json to_json(const rom::CertificateErrors& errors) {
  return {{"key_points_K", errors.key_points_K}, {"nose_um", errors.nose_um}, {"part_max_K", errors.part_max_K}};
}

}  // namespace spindle_twin::host_tools
