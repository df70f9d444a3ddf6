#include "fem_offline/model/discretisation.hpp"

#include <deal.II/dofs/dof_tools.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/grid/manifold_lib.h>

#include <algorithm>
#include <map>

namespace spindle_twin::fem_offline {
namespace {

/// Tells the sides which circle they lie on; one manifold per centre.
template <int dim>
void bend(dealii::Triangulation<dim>& triangulation, const std::vector<BentSide>& bent_sides) {
  std::map<std::pair<std::size_t, std::size_t>, const BentSide*> bent;
  for (const BentSide& side : bent_sides) bent[std::minmax(side.a, side.b)] = &side;
  if (bent.empty()) return;
  std::map<std::pair<double, double>, dealii::types::manifold_id> known;
  for (const auto& cell : triangulation.active_cell_iterators()) {
    for (const unsigned face : cell->face_indices()) {
      if (!cell->at_boundary(face)) continue;
      const auto found =
          bent.find(std::minmax<std::size_t>(cell->face(face)->vertex_index(0), cell->face(face)->vertex_index(1)));
      if (found == bent.end()) continue;
      const Point& centre = found->second->centre;
      const auto [entry, is_new] =
          known.try_emplace({centre.r_m, centre.z_m}, static_cast<dealii::types::manifold_id>(known.size() + 1));
      if (is_new) {
        triangulation.set_manifold(entry->second,
                                   dealii::SphericalManifold<dim>(dealii::Point<dim>(centre.r_m, centre.z_m)));
      }
      cell->face(face)->set_manifold_id(entry->second);
    }
  }
}

template <int dim>
void fill(dealii::Triangulation<dim>& triangulation, const SectionMesh& mesh) {
  static_assert(dim == 2, "a three-dimensional mesh comes from another mesher");
  std::vector<dealii::Point<dim>> vertices;
  for (const Point& point : mesh.points) vertices.emplace_back(point.r_m, point.z_m);
  std::vector<dealii::CellData<dim>> cells;
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    dealii::CellData<dim> cell;
    const auto& [a, b, c, d] = mesh.quads[q];
    cell.vertices = {static_cast<unsigned>(a), static_cast<unsigned>(b), static_cast<unsigned>(d),
                     static_cast<unsigned>(c)};
    cell.material_id = static_cast<dealii::types::material_id>(mesh.part_of_quad[q]);
    cells.push_back(cell);
  }
  // The edges of recombined quadrilaterals come in any direction.
  dealii::GridTools::consistently_order_cells(cells);
  triangulation.create_triangulation(vertices, cells, dealii::SubCellData());
  bend(triangulation, mesh.bent_sides);
}

}  // namespace

template <int dim>
Discretisation<dim>::Discretisation(const SectionMesh& mesh, int degree, Geometry geometry_of_mesh)
    : geometry(geometry_of_mesh),
      element(static_cast<unsigned>(degree)),
      mapping(mesh.bent_sides.empty() || degree == 1 ? 1 : 2) {
  fill(triangulation, mesh);
  dof_handler.reinit(triangulation);
  dof_handler.distribute_dofs(element);
  std::vector<dealii::Point<dim>> points(dof_handler.n_dofs());
  dealii::DoFTools::map_dofs_to_support_points(mapping, dof_handler, points);
  for (const auto& point : points) places.push_back({-1, point[0], point[1]});
  std::vector<dealii::types::global_dof_index> dofs(element.n_dofs_per_cell());
  for (const auto& cell : dof_handler.active_cell_iterators()) {
    cell->get_dof_indices(dofs);
    for (const auto dof : dofs) places[dof].part = static_cast<int>(cell->material_id());
  }
}

template struct Discretisation<2>;

}  // namespace spindle_twin::fem_offline
