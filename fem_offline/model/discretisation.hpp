#pragma once

#include <deal.II/base/point.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/mapping_q.h>
#include <deal.II/grid/tria.h>

#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"
#include "fem_offline/model/affine_model.hpp"
#include "fem_offline/model/surface_rules.hpp"

namespace spindle_twin::fem_offline {

/// All parts in one triangulation of disconnected pieces, with scalar Lagrange elements: every part owns its unknowns.
/// Bent sides are parabolas through their ends and the middle of the arc (isoparametric elements), straight if
/// degree 1. Material id = part index. In two dimensions coordinate 0 is r, 1 is z.
template <int dim>
struct Discretisation {
  Discretisation(const SectionMesh& mesh, int degree, Geometry geometry = Geometry::axisymmetric);

  Geometry geometry;
  dealii::Triangulation<dim> triangulation;
  dealii::FE_Q<dim> element;
  dealii::MappingQ<dim> mapping;
  dealii::DoFHandler<dim> dof_handler;
  std::vector<DofPlace> places;  ///< one per unknown
};

/// Volume per volume of the meshed domain: depth_m in two dimensions, 1 in three.
template <int dim>
double revolution_factor(Geometry geometry, const dealii::Point<dim>& at) {
  if constexpr (dim == 2) {
    return depth_m(geometry, at[0]);
  } else {
    return 1.0;
  }
}

/// Quadrature points and traces on every piece, and on the common refinement of every pair.
SurfaceRules make_surface_rules(const Discretisation<2>& discretisation, const Spindle& spindle,
                                const Section& section);

/// Values of the element functions of `part` at a point of it (or its nearest point).
Trace trace_at(const Discretisation<2>& discretisation, int part, const Point& at);

}  // namespace spindle_twin::fem_offline
