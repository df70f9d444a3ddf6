#include "fem_offline/model/patch_recovery.hpp"

#include <deal.II/base/quadrature_lib.h>
#include <deal.II/fe/fe_values.h>

#include <Eigen/QR>
#include <algorithm>

namespace spindle_twin::fem_offline {
namespace {

using Cell = dealii::DoFHandler<2>::active_cell_iterator;

// Where a part is one element thick its samples leave a curvature across it undetermined; a weight this small on all
// coefficients but the constant makes it zero and changes a determined one by 1e-6 of itself.
constexpr double steadying = 3e-3;

/// A place in the coordinates of its patch, scaled to about -1..1 along both axes, and the monomials there.
class PatchFrame {
 public:
  PatchFrame(const Eigen::MatrixX2d& points, int degree) : degree_(degree) {
    const Eigen::RowVector2d least = points.colwise().minCoeff(), most = points.colwise().maxCoeff();
    centre_ = 0.5 * (least + most);
    half_ = 0.5 * (most - least);
    half_ = half_.cwiseMax(1e-6 * half_.maxCoeff());
  }
  int terms() const { return (degree_ + 1) * (degree_ + 2) / 2; }
  Eigen::RowVectorXd monomials(const Eigen::RowVector2d& at) const {
    const Eigen::RowVector2d x = (at - centre_).cwiseQuotient(half_);
    Eigen::RowVectorXd row(terms());
    int term = 0;
    double first = 1.0;
    for (int i = 0; i <= degree_; ++i, first *= x[0]) {
      double product = first;
      for (int j = 0; i + j <= degree_; ++j, product *= x[1]) row[term++] = product;
    }
    return row;
  }

 private:
  int degree_;
  Eigen::RowVector2d centre_, half_;
};

/// Least squares, steadied; coefficients x components.
Eigen::MatrixXd fitted(const PatchFrame& frame, const Eigen::MatrixX2d& points, const Eigen::MatrixXd& values) {
  const int terms = frame.terms();
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(points.rows() + terms - 1, terms);
  Eigen::MatrixXd wanted = Eigen::MatrixXd::Zero(system.rows(), values.cols());
  for (Eigen::Index i = 0; i < points.rows(); ++i) system.row(i) = frame.monomials(points.row(i));
  wanted.topRows(values.rows()) = values;
  for (int term = 1; term < terms; ++term) system(points.rows() + term - 1, term) = steadying;
  return system.householderQr().solve(wanted);
}

/// The mesh as the patches see it.
struct Neighbours {
  std::vector<std::vector<unsigned>> cells_of_corner;
  std::vector<std::array<unsigned, 4>> corners_of_cell;
  std::vector<bool> at_rim;  // per corner
};

Neighbours neighbours_of(const Discretisation<2>& discretisation) {
  const auto& triangulation = discretisation.triangulation;
  Neighbours mesh{std::vector<std::vector<unsigned>>(triangulation.n_vertices()),
                  std::vector<std::array<unsigned, 4>>(triangulation.n_active_cells()),
                  std::vector<bool>(triangulation.n_vertices(), false)};
  for (const auto& cell : triangulation.active_cell_iterators()) {
    const unsigned index = cell->active_cell_index();
    for (const unsigned v : cell->vertex_indices()) {
      mesh.corners_of_cell[index][v] = cell->vertex_index(v);
      mesh.cells_of_corner[cell->vertex_index(v)].push_back(index);
    }
    for (const unsigned face : cell->face_indices()) {
      if (!cell->at_boundary(face)) continue;
      for (unsigned v = 0; v < 2; ++v) mesh.at_rim[cell->face(face)->vertex_index(v)] = true;
    }
  }
  return mesh;
}

std::vector<unsigned> patch_of(const Neighbours& mesh, unsigned corner) {
  std::vector<unsigned> cells = mesh.cells_of_corner[corner];
  if (!mesh.at_rim[corner]) return cells;
  for (const unsigned cell : mesh.cells_of_corner[corner]) {
    for (const unsigned other : mesh.corners_of_cell[cell]) {
      cells.insert(cells.end(), mesh.cells_of_corner[other].begin(), mesh.cells_of_corner[other].end());
    }
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  return cells;
}

/// Gauss points of every cell.
std::vector<Eigen::MatrixX2d> sample_places(const Discretisation<2>& discretisation) {
  const dealii::QGauss<2> gauss(discretisation.element.degree);
  dealii::FEValues<2> values(discretisation.mapping, discretisation.element, gauss, dealii::update_quadrature_points);
  std::vector<Eigen::MatrixX2d> places;
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    values.reinit(cell);
    Eigen::MatrixX2d& points = places.emplace_back(gauss.size(), 2);
    for (const unsigned q : values.quadrature_point_indices()) {
      for (unsigned c = 0; c < 2; ++c) points(q, c) = values.quadrature_point(q)[c];
    }
  }
  return places;
}

}  // namespace

Eigen::MatrixXd recovered_at_places(const Discretisation<2>& discretisation,
                                    const std::vector<Eigen::MatrixXd>& samples) {
  const auto& element = discretisation.element;
  const Neighbours mesh = neighbours_of(discretisation);
  const std::vector<Eigen::MatrixX2d> places = sample_places(discretisation);
  std::vector<std::vector<dealii::types::global_dof_index>> dofs_of_cell;
  for (const auto& cell : discretisation.dof_handler.active_cell_iterators()) {
    cell->get_dof_indices(dofs_of_cell.emplace_back(element.n_dofs_per_cell()));
  }
  // A corner speaks for the unknowns of its cells that no other corner of the cell is nearer to.
  std::vector<std::vector<unsigned>> local_of_corner(4);
  for (unsigned i = 0; i < element.n_dofs_per_cell(); ++i) {
    std::array<double, 4> distance{};
    for (unsigned v = 0; v < 4; ++v) {
      distance[v] = element.unit_support_point(i).distance(dealii::GeometryInfo<2>::unit_cell_vertex(v));
    }
    const double least = *std::min_element(distance.begin(), distance.end());
    for (unsigned v = 0; v < 4; ++v) {
      if (distance[v] <= least + 1e-9) local_of_corner[v].push_back(i);
    }
  }

  const auto n = static_cast<Eigen::Index>(discretisation.places.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(n, samples.front().cols());
  Eigen::VectorXd count = Eigen::VectorXd::Zero(n);
  const Eigen::Index per_cell = places.front().rows();
  for (unsigned corner = 0; corner < mesh.cells_of_corner.size(); ++corner) {
    const std::vector<unsigned> patch = patch_of(mesh, corner);
    Eigen::MatrixX2d points(per_cell * static_cast<Eigen::Index>(patch.size()), 2);
    Eigen::MatrixXd values(points.rows(), sum.cols());
    for (std::size_t i = 0; i < patch.size(); ++i) {
      points.middleRows(static_cast<Eigen::Index>(i) * per_cell, per_cell) = places[patch[i]];
      values.middleRows(static_cast<Eigen::Index>(i) * per_cell, per_cell) = samples[patch[i]];
    }
    const PatchFrame frame(points, static_cast<int>(element.degree));
    const Eigen::MatrixXd coefficients = fitted(frame, points, values);
    for (const unsigned cell : mesh.cells_of_corner[corner]) {
      const auto& corners = mesh.corners_of_cell[cell];
      const auto local = static_cast<std::size_t>(std::find(corners.begin(), corners.end(), corner) - corners.begin());
      for (const unsigned i : local_of_corner[local]) {
        const auto dof = static_cast<Eigen::Index>(dofs_of_cell[cell][i]);
        const DofPlace& place = discretisation.places[static_cast<std::size_t>(dof)];
        sum.row(dof) += frame.monomials({place.r_m, place.z_m}) * coefficients;
        count[dof] += 1.0;
      }
    }
  }
  return count.cwiseInverse().asDiagonal() * sum;
}

}  // namespace spindle_twin::fem_offline
