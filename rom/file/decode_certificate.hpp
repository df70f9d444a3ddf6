#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

#include "rom/file/rom.pb.h"
#include "rom/network.hpp"

namespace spindle_twin::rom {

/// Worst, median, mesh error and limit of one output after the other, as they stand in the file.
struct FlatErrors {
  Eigen::VectorXd key_points_K, part_means_K, part_maxima_K, deformations_m, contact_pressures_Pa;

  bool empty() const {
    for (const auto* each : {&key_points_K, &part_means_K, &part_maxima_K, &deformations_m, &contact_pressures_Pa}) {
      if (each->size() > 0) return false;
    }
    return true;
  }
};

/// Lets nanopb fill `errors`, which must live until the message is decoded.
void attach_certificate(spindle_twin_rom_Certificate& message, FlatErrors& errors);

/// Throws InputError for a list that is not made of fours, of threes in files of before `schema_version` knew limits.
Certificate decode_certificate(const spindle_twin_rom_Certificate& message, const FlatErrors& errors,
                               std::uint32_t schema_version, const std::string& file);

}  // namespace spindle_twin::rom
