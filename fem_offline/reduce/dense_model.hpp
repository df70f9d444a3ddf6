#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/parameter_box.hpp"
#include "rom/boundaries.hpp"
#include "rom/integrate/coolant.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// Symmetric n x n matrices, of each the lower triangle, column behind column: half their memory. Of a rich model there
/// are a hundred, and a sum of all takes as long as reading them.
class PackedTerms {
 public:
  PackedTerms() = default;
  /// `count` matrices that are not set yet.
  PackedTerms(Eigen::Index size, Eigen::Index count) : size_(size), values_(size * (size + 1) / 2, count) {}
  Eigen::Index count() const { return values_.cols(); }
  /// Of each the first `size` rows and columns.
  PackedTerms first(Eigen::Index size) const;
  /// Reads the lower triangle. Several threads may set different ones.
  void set(Eigen::Index term, const Eigen::MatrixXd& matrix);
  /// Rows c to n − 1 of column c.
  auto column(Eigen::Index term, Eigen::Index c) const { return values_.col(term).segment(start_of(c), size_ - c); }
  /// One matrix for every column of `weights`: the sum of all terms, each times its weight, in one pass over the terms;
  /// packed in the same way.
  PackedTerms sums(const Eigen::MatrixXd& weights) const;
  /// Adds a term to the lower triangle of a matrix.
  void add_to_lower(Eigen::Index term, Eigen::MatrixXd& matrix) const;

 private:
  Eigen::Index start_of(Eigen::Index c) const { return c * size_ - c * (c - 1) / 2; }

  Eigen::Index size_ = 0;
  Eigen::MatrixXd values_;
};

/// The FE model tested with a Galerkin basis V of n columns; all matrices dense, n x n unless said otherwise:
///   C dT/dt = −(K₀ + Σⱼ gⱼ Kⱼ) T + Σⱼ gⱼ (Kⱼ 1) T_env(j) + B q
struct DenseModel {
  Eigen::MatrixXd capacity;
  Eigen::MatrixXd conduction;
  PackedTerms conductance_terms;
  Eigen::MatrixXd walls_m2;             ///< n x conductances: Kⱼ 1, zero for exchange between bodies
  Eigen::MatrixXd source_distribution;  ///< n x sources
  Eigen::VectorXd uniform;              ///< n; the field that is 1 everywhere
};

/// The model on the first `size` columns of its basis.
DenseModel first_states(const DenseModel& model, Eigen::Index size);

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

/// A model that holds these conductances and no other inputs, for hold_inputs to begin with. `sums`: of its terms, the
/// one numbered `sum` with these conductances as weights; for many inputs in one pass, which costs little more than
/// one.
HeldModel hold_conductances(const DenseModel& model, const PackedTerms& sums, Eigen::Index sum,
                            const Eigen::VectorXd& conductances_W_per_m2K);

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

/// Whether circuits stand still in a random state: then there may be no steady state.
enum class Coolant { flows, flows_or_stands, stands };

/// What random states of the machine are like.
struct StateDraw {
  double spread_K;    ///< environments lie so far about the description's
  double rest_share;  ///< of states: the spindle stands still without load
  Coolant coolant;
};

/// A random state of the machine: any speed, load and coolant flow of the box.
rom::OperatingState random_state(const rom::Boundaries& boundaries, const ParameterBox& box, const StateDraw& draw,
                                 RandomStream& random);

}  // namespace spindle_twin::fem_offline
