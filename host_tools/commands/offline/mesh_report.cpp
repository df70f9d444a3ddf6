#include "host_tools/commands/offline/mesh_report.hpp"

#include <cstdio>

namespace spindle_twin::host_tools {
namespace {

constexpr double mm_per_metre = 1e3;

}  // namespace

nlohmann::json mesh_json(const std::vector<fem_offline::PartQuality>& parts) {
  nlohmann::json json;
  std::size_t cells = 0;
  for (const auto& part : parts) {
    cells += part.cells;
    json["parts"][part.part] = {{"cells", part.cells},
                                {"scaled_jacobian_min", part.least_scaled_jacobian},
                                {"scaled_jacobian_mean", part.mean_scaled_jacobian},
                                {"scaled_jacobian_max", part.largest_scaled_jacobian},
                                {"aspect_max", part.largest_aspect},
                                {"side_min_mm", mm_per_metre * part.least_side_m},
                                {"side_max_mm", mm_per_metre * part.longest_side_m}};
  }
  json["cells"] = cells;
  return json;
}

void print_mesh_table(const std::vector<fem_offline::PartQuality>& parts) {
  std::printf("%-24s %8s %9s %9s %9s %9s %9s %9s\n", "mesh", "cells", "Jac min", "Jac mean", "Jac max", "aspect",
              "side mm", "to mm");
  for (const auto& part : parts) {
    std::printf("%-24s %8zu %9.4f %9.4f %9.4f %9.2f %9.4f %9.4f\n", part.part.c_str(), part.cells,
                part.least_scaled_jacobian, part.mean_scaled_jacobian, part.largest_scaled_jacobian,
                part.largest_aspect, mm_per_metre * part.least_side_m, mm_per_metre * part.longest_side_m);
  }
  std::printf("\n");
}

}  // namespace spindle_twin::host_tools
