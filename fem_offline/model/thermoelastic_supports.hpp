#pragma once

#include <vector>

#include "fem_offline/model/surface_rules.hpp"
#include "fem_offline/model/volume_terms.hpp"

namespace spindle_twin::fem_offline {

/// The unknowns that a support acts on.
struct SupportPlaces {
  std::vector<int> places;           ///< without doubles
  std::vector<SurfacePoint> points;  ///< their weights sum to the face's area; one point of weight 1 for a point
};

SupportPlaces places_of(const Support& support, const Section& section, const SurfaceRules& rules,
                        const std::vector<DofPlace>& places);

/// Throws rom::InputError naming a part of a bonded group that can move as a rigid body: along z for a body of
/// revolution; along both axes or turning for a planar one.
void check_held(const Spindle& spindle, const SurfaceRules& rules, const std::vector<DofPlace>& places,
                const std::vector<SupportPlaces>& held);

}  // namespace spindle_twin::fem_offline
