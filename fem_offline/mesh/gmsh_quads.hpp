#pragma once

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Meshes one part of any straight-sided outline with gmsh and adds it to the mesh. `pieces` of other parts are
/// passed over. Sides are divided evenly between piece ends, with the finer size of both parts at a contact, so two
/// parts meshed this way match where they touch; inside, sizes follow those along the rim. Throws rom::InputError
/// naming the part if the sizes ask for too many elements, or if gmsh throws, crashes or takes longer than
/// MeshSettings::part_time_limit_s of computing (it runs in a process of its own).
void add_gmsh_quads(const Spindle& spindle, const Section& section, std::size_t part, double element_limit,
                    SectionMesh& mesh);

}  // namespace spindle_twin::fem_offline
