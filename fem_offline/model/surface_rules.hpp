#pragma once

#include <vector>

#include "fem_offline/mesh/section.hpp"

namespace spindle_twin::fem_offline {

/// The element functions that do not vanish at a point: Σ valuesᵢ uᵢ is the field there.
struct Trace {
  std::vector<int> dofs;
  std::vector<double> values;
};

struct SurfacePoint {
  Point at;
  double weight_m2 = 0.0;
  Trace trace;
};

/// One point of the common refinement of two faces that touch or look at each other.
struct PairedPoint {
  double weight_m2 = 0.0;  ///< at the mean of the two radii
  Trace a;
  Trace b;
};

struct SurfacePair {
  PieceKind kind = PieceKind::contact;
  std::size_t index = 0;  ///< into Spindle::contacts or gap_films
  std::size_t part_a = 0;
  std::size_t part_b = 0;
  double least_face_m = 0.0;  ///< shortest element side of both
  std::vector<PairedPoint> points;
};

/// Everything that surface integrals need, free of the FE library.
struct SurfaceRules {
  std::vector<std::vector<SurfacePoint>> pieces;  ///< one list per Section::pieces
  std::vector<SurfacePair> pairs;
};

}  // namespace spindle_twin::fem_offline
