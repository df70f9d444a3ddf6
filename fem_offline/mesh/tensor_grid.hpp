#pragma once

#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Rising coordinates of the grid lines, already subdivided.
struct TensorGrid {
  std::vector<double> r_m;
  std::vector<double> z_m;
};

/// True if all sides run along r or z.
bool is_axis_aligned(const PartOutline& outline);

/// Lines at all corners and piece ends of the axis-aligned parts and at the borders of supports and deformation faces.
TensorGrid make_tensor_grid(const Spindle& spindle, const Section& section);

/// Adds the grid cells inside the outline to the mesh.
void add_grid_cells(const TensorGrid& grid, const PartOutline& outline, std::size_t part, SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
