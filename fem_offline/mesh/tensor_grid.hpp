#pragma once

#include <cstddef>
#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Lines of one direction: `coarse_m` at corners and piece ends, and how each stretch between two of them is divided.
struct GridLines {
  std::vector<double> coarse_m;
  std::vector<std::vector<double>> fine_m;  ///< per stretch, both of its ends among them
};

struct TensorGrid {
  GridLines r;
  GridLines z;
};

/// True if all sides run along r or z.
bool is_axis_aligned(const PartOutline& outline);

/// Coarse lines at all corners and piece ends of the axis-aligned parts and at the borders of supports and deformation
/// faces. A stretch is divided by the least element size of the parts it runs through, at least `cells_across` times
/// over the thickness of each of them, and finer towards contacts if the mesh asks for it.
TensorGrid make_tensor_grid(const Spindle& spindle, const Section& section, double element_limit);

/// Adds the grid cells inside the outline to the mesh.
void add_grid_cells(const TensorGrid& grid, const PartOutline& outline, std::size_t part, SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
