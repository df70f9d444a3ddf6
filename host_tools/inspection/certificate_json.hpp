#pragma once

#include <nlohmann/json.hpp>

#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// Which of the columns that not every certificate has are shown.
struct CertificateColumns {
  bool limit = false;
  bool mesh = false;
};
CertificateColumns certificate_columns(const rom::Certificate& certificate);

/// A certificate as every command's --json has it: {cases, seed, worst, median, limit, box, mesh,
/// outputs{key_points_K, part_mean_K, part_max_K, deformations_um, contact_pressures_MPa}}, each of the last by name
/// {worst, median, limit, mesh}; the last two, and the `limit` above, only where they were measured.
nlohmann::ordered_json certificate_to_json(const rom::Network& network);

}  // namespace spindle_twin::host_tools
