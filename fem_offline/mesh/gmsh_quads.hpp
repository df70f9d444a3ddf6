#pragma once

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Meshes one part of any straight-sided outline with gmsh and adds it to the mesh. `pieces` of other parts are
/// passed over. Sides are divided evenly between piece ends, so two parts meshed this way match where they touch.
/// Throws rom::InputError naming the part if gmsh fails. Not for several threads at once (gmsh has one state).
void add_gmsh_quads(const Spindle& spindle, const Section& section, std::size_t part, SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
