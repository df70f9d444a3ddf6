#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "fem_offline/description/spindle.hpp"

namespace spindle_twin::fem_offline {

class FeModel;

/// The nodes of one element in rows and columns, (degree + 1)² of them, and its part.
struct LatticeCell {
  std::size_t part = 0;
  std::vector<int> nodes;
};

/// The mesh as pictures need it, free of the FE library. Between nodes a field is drawn linearly.
struct Lattice {
  int degree = 1;
  std::vector<Point> nodes;
  std::vector<LatticeCell> cells;
};

/// Its nodes are the FE unknowns.
Lattice lattice_of(const FeModel& model);

using LatticeEdge = std::pair<int, int>;
using LatticeTriangle = std::array<int, 3>;

/// Two triangles per square of the lattice; all of them cover the section once.
std::vector<LatticeTriangle> triangles_of(const Lattice& lattice);

/// Sides that belong to one element only, node to node: the outlines of the parts.
std::vector<LatticeEdge> rim_of(const Lattice& lattice);

/// Straight pieces of the isoline field = level, one per triangle it crosses.
struct IsolinePiece {
  Point start;
  Point end;
};
std::vector<IsolinePiece> isoline(const Lattice& lattice, const std::vector<LatticeTriangle>& triangles,
                                  const Eigen::VectorXd& field, double level);

/// 1, 2 or 5 times a power of ten, the largest such that `span` holds at least `least_count` of them. span > 0.
double nice_step(double span, int least_count);

}  // namespace spindle_twin::fem_offline
