#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem_offline/reduce/reduce.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// A choice of as many unknowns as the basis has columns, so that their temperatures are its coordinates.
struct NodalCoordinates {
  std::vector<int> nodes;       ///< ascending
  Eigen::MatrixXd at_nodes;     ///< rows of the orthonormal basis V at the nodes, N x N
  Eigen::MatrixXd interpolant;  ///< V · at_nodes⁻¹, unknowns x N: rows at nodes are unit rows, all rows sum to 1
  double condition = 0.0;       ///< of at_nodes times that of V, which is 1
};

/// The first choice are the rows of V that are the most independent (complete pivoting); then nodes are swapped while
/// an entry of the interpolant is above 1.2 in magnitude (maximum volume: Goreinov et al. 2010), which keeps the
/// interpolant from amplifying anywhere. The same bits for any number of threads. Throws std::runtime_error where
/// columns are dependent.
NodalCoordinates choose_nodes(const Eigen::MatrixXd& orthonormal_basis, int threads);

/// C, K₀, Fⱼ and B of the network on an orthonormal basis, whose first `bodies` columns are as those of RichBasis.
void project_network(const AffineModel& model, const Eigen::MatrixXd& basis, int bodies, const NodalCoordinates& nodal,
                     int threads, rom::Network& network);

/// Rows of key points, part means and deformations; the nodes' names and places.
void project_outputs(const AffineModel& model, const NodalCoordinates& nodal, rom::Network& network);

/// At most 400 points of every part whose largest and smallest temperature stand for those of the part, over random
/// fields that a spindle can have: steady ones and those some time after a change of the operating state.
/// Fields are those of `dense` on this basis, the network's interpolant or the one that it was made of.
PartExtremes find_part_extremes(const AffineModel& model, const Eigen::MatrixXd& basis, const DenseModel& dense,
                                const ReduceOptions& options);

/// Gives the parts of the network the rows of these points.
void add_part_extremes(const AffineModel& model, const NodalCoordinates& nodal, const PartExtremes& extremes,
                       rom::Network& network);

}  // namespace spindle_twin::fem_offline
