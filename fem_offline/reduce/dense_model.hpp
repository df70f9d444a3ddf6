#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/parameter_box.hpp"
#include "rom/boundaries.hpp"
#include "rom/integrate/coolant.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// Lower triangle of a symmetric n x n matrix, column behind column: half its memory. Of the terms of a rich model
/// there are a hundred.
class PackedSymmetric {
 public:
  PackedSymmetric() = default;
  /// Reads the lower triangle.
  explicit PackedSymmetric(const Eigen::MatrixXd& matrix);
  /// Rows c to n − 1 of column c.
  auto column(Eigen::Index c) const { return values_.segment(c * size_ - c * (c - 1) / 2, size_ - c); }
  Eigen::MatrixXd whole() const;

 private:
  Eigen::Index size_ = 0;
  Eigen::VectorXd values_;
};

/// The FE model tested with a Galerkin basis V of n columns; all matrices dense, n x n unless said otherwise:
///   C dT/dt = −(K₀ + Σⱼ gⱼ Kⱼ) T + Σⱼ gⱼ (Kⱼ 1) T_env(j) + B q
struct DenseModel {
  Eigen::MatrixXd capacity;
  Eigen::MatrixXd conduction;
  std::vector<PackedSymmetric> conductance_terms;
  Eigen::MatrixXd walls_m2;             ///< n x conductances: Kⱼ 1, zero for exchange between bodies
  Eigen::MatrixXd source_distribution;  ///< n x sources
  Eigen::VectorXd uniform;              ///< n; the field that is 1 everywhere
};

/// Of a network: its own matrices.
DenseModel dense_model_of(const rom::Network& network);

/// Conduction and drive of a model under held inputs: C dT/dt = drive − (K − H Wᵀ) T, with T the rise above `zero_K`.
/// H Wᵀ is what a circuit's liquid carries from segment to segment: M columns each, none without circuits.
struct HeldModel {
  Eigen::MatrixXd conduction;  ///< K, of which only the lower triangle
  Eigen::MatrixXd carried;     ///< H
  Eigen::MatrixXd walls;       ///< W
  Eigen::VectorXd drive;
  Eigen::VectorXd contained_W_per_m2K;  ///< of every conductance, what K has of it; empty before the first inputs
};

/// Gives `held` these inputs. One that held others of the same model changes only by the conductances that differ: of
/// the terms of a K most follow neither speed nor flow.
void hold_inputs(const DenseModel& model, const rom::Boundaries& boundaries, const rom::CoolantSegments& segments,
                 const rom::BoundaryValues& values, double zero_K, HeldModel& held);

/// Factor of K + rate · C − H Wᵀ: Cholesky of the symmetric part, and H Wᵀ by the Woodbury identity.
class ShiftedModel {
 public:
  /// Throws std::runtime_error where the symmetric part is not positive definite.
  ShiftedModel(const DenseModel& model, const HeldModel& held, double rate_per_s);
  Eigen::VectorXd solve(const Eigen::VectorXd& heat_W) const;
  /// With the transposed matrix, a column each.
  Eigen::MatrixXd solve_transposed(const Eigen::MatrixXd& rows) const;

 private:
  DenseCholesky symmetric_;
  Eigen::MatrixXd carried_, walls_;
};

/// Whether circuits may stand still in a random state: then there may be no steady state.
enum class Coolant { flows, flows_or_stands };

/// A random state of the machine: any speed, load and coolant flow of the box, environments `spread_K` about the
/// description's.
rom::OperatingState random_state(const rom::Boundaries& boundaries, const ParameterBox& box, double spread_K,
                                 Coolant coolant, RandomStream& random);

}  // namespace spindle_twin::fem_offline
