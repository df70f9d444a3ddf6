#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// Outputs in one column, in this order: temperatures of the key points, means and maxima of the parts [K],
/// deformations [m], contact pressures [Pa].
struct OutputLayout {
  Eigen::Index key_points = 0;
  Eigen::Index parts = 0;
  Eigen::Index deformations = 0;
  Eigen::Index pressures = 0;

  Eigen::Index means_at() const { return key_points; }
  Eigen::Index maxima_at() const { return key_points + parts; }
  Eigen::Index deformations_at() const { return key_points + 2 * parts; }
  Eigen::Index pressures_at() const { return deformations_at() + deformations; }
  Eigen::Index total() const { return pressures_at() + pressures; }
};

OutputLayout output_layout(const AffineModel& model);

/// Points of every part, by their place among the part's unknowns, whose extremes stand for those of the part.
using PartExtremes = std::vector<std::vector<int>>;

/// What fields in some coordinates give: those of a network's nodes, or of a basis.
struct OutputRows {
  OutputLayout layout;
  Eigen::VectorXd at_reference;           ///< every output where all is at the reference temperature, SI
  Eigen::MatrixXd linear;                 ///< a row for each output but the maxima, in the same order
  std::vector<Eigen::MatrixXd> extremes;  ///< of each part: rows of the points whose largest is its maximum
};

OutputRows output_rows_of(const rom::Network& network);
/// For temperatures V x, with V the basis.
OutputRows project_output_rows(const AffineModel& model, const Eigen::MatrixXd& basis, const PartExtremes& extremes);

/// The rows of a part's points in this basis.
Eigen::MatrixXd extreme_rows(const FePart& part, const std::vector<int>& points, const Eigen::MatrixXd& basis);

/// Every output of fields given as rises above the reference temperature, a column each, SI.
Eigen::MatrixXd outputs_of(const OutputRows& rows, const Eigen::MatrixXd& rises_K);

}  // namespace spindle_twin::fem_offline
