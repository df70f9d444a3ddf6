#include "fem_offline/look/picture_lattice.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "fem_offline/model/build_model.hpp"
#include "fem_offline/model/discretisation.hpp"

namespace spindle_twin::fem_offline {

Lattice lattice_of(const FeModel& model) {
  const Discretisation<2>& discretisation = model.discretisation();
  Lattice lattice;
  lattice.degree = static_cast<int>(discretisation.element.degree);
  for (const DofPlace& place : discretisation.places) lattice.nodes.push_back({place.r_m, place.z_m});
  const std::vector<unsigned> in_rows = discretisation.element.get_poly_space_numbering_inverse();
  std::vector<dealii::types::global_dof_index> dofs(discretisation.element.n_dofs_per_cell());
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    cell->get_dof_indices(dofs);
    LatticeCell& drawn = lattice.cells.emplace_back();
    drawn.part = cell->material_id();
    for (const unsigned local : in_rows) drawn.nodes.push_back(static_cast<int>(dofs[local]));
  }
  return lattice;
}

std::vector<LatticeTriangle> triangles_of(const Lattice& lattice) {
  std::vector<LatticeTriangle> triangles;
  const int row = lattice.degree + 1;
  for (const LatticeCell& cell : lattice.cells) {
    for (int j = 0; j < lattice.degree; ++j) {
      for (int i = 0; i < lattice.degree; ++i) {
        const int a = cell.nodes[j * row + i], b = cell.nodes[j * row + i + 1];
        const int c = cell.nodes[(j + 1) * row + i], d = cell.nodes[(j + 1) * row + i + 1];
        triangles.push_back({a, b, d});
        triangles.push_back({a, d, c});
      }
    }
  }
  return triangles;
}

std::vector<LatticeEdge> rim_of(const Lattice& lattice) {
  std::map<LatticeEdge, int> count;
  const int row = lattice.degree + 1;
  for (const LatticeCell& cell : lattice.cells) {
    const auto add = [&](int from, int to) { ++count[std::minmax(cell.nodes[from], cell.nodes[to])]; };
    for (int i = 0; i < lattice.degree; ++i) {
      add(i, i + 1);
      add(lattice.degree * row + i, lattice.degree * row + i + 1);
      add(i * row, (i + 1) * row);
      add(i * row + lattice.degree, (i + 1) * row + lattice.degree);
    }
  }
  std::vector<LatticeEdge> edges;
  for (const auto& [edge, uses] : count) {
    if (uses == 1) edges.push_back(edge);
  }
  return edges;
}

std::vector<IsolinePiece> isoline(const Lattice& lattice, const std::vector<LatticeTriangle>& triangles,
                                  const Eigen::VectorXd& field, double level) {
  std::vector<IsolinePiece> pieces;
  for (const LatticeTriangle& triangle : triangles) {
    std::vector<Point> crossings;
    for (int k = 0; k < 3; ++k) {
      const int a = triangle[k], b = triangle[(k + 1) % 3];
      // A node on the level counts as above it, so that every triangle has no crossing or two.
      if ((field[a] >= level) == (field[b] >= level)) continue;
      const double share = (level - field[a]) / (field[b] - field[a]);
      const Point &from = lattice.nodes[a], &to = lattice.nodes[b];
      crossings.push_back({from.r_m + share * (to.r_m - from.r_m), from.z_m + share * (to.z_m - from.z_m)});
    }
    if (crossings.size() == 2) pieces.push_back({crossings[0], crossings[1]});
  }
  return pieces;
}

double nice_step(double span, int least_count) {
  const double widest = span / least_count;
  const double power = std::pow(10.0, std::floor(std::log10(widest)));
  double step = power;
  for (const double factor : {2.0, 5.0}) {
    if (factor * power <= widest * (1.0 + 1e-12)) step = factor * power;
  }
  return step;
}

}  // namespace spindle_twin::fem_offline
