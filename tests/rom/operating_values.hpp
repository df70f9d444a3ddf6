#pragma once

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/network.hpp"

namespace spindle_twin::rom::tests {

/// What acts on a network at its operating state, uncorrected.
inline BoundaryValues operating_values(const Network& network) {
  BoundaryValues values = make_boundary_values(network.boundaries);
  evaluate_boundaries(network.boundaries, network.boundaries.operating, no_correction(network.boundaries), values);
  return values;
}

}  // namespace spindle_twin::rom::tests
