#pragma once

#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/reduce/reduce.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// A description whose elements are half as large everywhere.
Spindle with_half_elements(Spindle spindle);

/// Largest change of every output between a mesh and one of half the element size, over the warm-up of the operating
/// state from the reference temperature (intervals 1, 1, 2, ... 64 s) and its steady end; into the certificate's
/// `mesh`. An upper bound of what is left on the finer one; of the coarser one about three quarters (order 2).
void measure_mesh_error(const AffineModel& model, const AffineModel& finer, int threads, const Progress& progress,
                        rom::Certificate& certificate);

}  // namespace spindle_twin::fem_offline
