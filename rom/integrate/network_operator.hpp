#pragma once

#include <Eigen/Core>

#include "rom/boundaries.hpp"
#include "rom/integrate/coolant.hpp"
#include "rom/integrate/law_terms.hpp"
#include "rom/network.hpp"

namespace spindle_twin::rom {

/// The network in coordinates where its capacity matrix is the identity. With C = L Lᵀ (Cholesky):
///   x = Lᵀ (T − T_ref),   dx/dt = −K̃(g) x + u
///   K̃(g) = L⁻¹ (K₀ + Σⱼ gⱼ Fⱼ Fⱼᵀ) L⁻ᵀ                                     [1/s], symmetric, positive semidefinite
///   u     = Σⱼ gⱼ L⁻¹ Fⱼ Fⱼᵀ 1 (T_env(j) − T_ref) + L⁻¹ (B q + node heat)
/// With coolant circuits the liquid brings every segment what those upstream gave it (integrate/coolant.hpp):
///   dx/dt = −K̃ x + u + P X̃(Pᵀ x),   P = [L⁻¹ F_s F_sᵀ 1] (N x M),   X̃ = diag(g_s) U diag(1/A_s) (M x M, not symmetric)
/// With physical laws (integrate/law_terms.hpp) heats and conductances are functions of x besides.
/// |x|² is the capacity-weighted square of the rise, so one scalar tolerance on x means the same at every node.
/// N states, J conductances. Read-only after construction: several steppers may share one from several threads.
class NetworkOperator {
 public:
  /// Throws std::invalid_argument if C is not positive definite or a matrix has the wrong shape. Allocates.
  explicit NetworkOperator(const Network& network);

  Eigen::Index nodes() const { return capacity_root_.rows(); }
  Eigen::Index conductances() const { return conductances_; }
  Eigen::Index sources() const { return sources_.cols(); }
  Eigen::Index environments() const { return environments_; }
  Eigen::Index circuits() const { return static_cast<Eigen::Index>(segments_.first.size()) - 1; }
  const CoolantSegments& segments() const { return segments_; }
  const LawTerms& laws() const { return laws_; }
  double reference_K() const { return reference_K_; }
  /// Whether C has no entry beside its diagonal: then node i may have capacity_factorᵢ times its capacity.
  bool diagonal_capacity() const { return diagonal_capacity_; }
  /// L, lower triangle valid.
  const Eigen::MatrixXd& capacity_root() const { return capacity_root_; }

  /// Square root of the mean node capacity, sqrt(1ᵀC1 / N) [sqrt(J/K)]: a capacity-weighted root mean square
  /// temperature error e [K] is a root mean square error e · internal_per_kelvin() in x.
  double internal_per_kelvin() const { return internal_per_kelvin_; }

  // The following are cycle-safe when their results are already sized N or N x N; none may alias an argument.
  void to_internal(const Eigen::VectorXd& temperatures_K, Eigen::VectorXd& x) const;
  void to_temperatures(const Eigen::VectorXd& x, Eigen::VectorXd& temperatures_K) const;

  /// Scratch for assemble(), sized by make_packed().
  Eigen::VectorXd make_packed() const { return packed_conduction_; }

  /// Lower triangle of K̃(g); the strict upper one is left as it is. Costs J N²/2 multiply-adds.
  void assemble(const Eigen::VectorXd& conductance_W_per_m2K, Eigen::VectorXd& packed, Eigen::MatrixXd& lower) const;

  /// The same from the packed K̃ of other conductances, at the cost of the terms that differ.
  void assemble_from(const Eigen::VectorXd& base_W_per_m2K, const Eigen::VectorXd& base_packed,
                     const Eigen::VectorXd& conductance_W_per_m2K, Eigen::VectorXd& packed,
                     Eigen::MatrixXd& lower) const;

  /// u for inputs that are held, without what the circuits' coupling adds. Node heats cost N²/2 multiply-adds.
  void drive(const BoundaryValues& values, Eigen::VectorXd& u) const;
  /// The same without the node heats, and L⁻¹ node heat alone, 0 where there is none.
  void drive_of_sources(const BoundaryValues& values, Eigen::VectorXd& u) const;
  void drive_of_nodes(const BoundaryValues& values, Eigen::VectorXd& u) const;

  /// W: P, then L⁻¹B of every heat that follows a law, then the rows that laws read. P alone where there are none.
  const Eigen::MatrixXd& feedback_columns() const { return laws_.empty() ? walls_ : feedback_columns_; }
  /// P.
  const Eigen::MatrixXd& walls() const { return walls_; }
  /// X̃ (M x M), and in `u` −P diag(g_s) U (T_inlet − T_ref) besides; `rises_K` is scratch of length M. Cycle-safe.
  void couple(const BoundaryValues& values, Eigen::MatrixXd& coupling, Eigen::VectorXd& rises_K,
              Eigen::VectorXd& u) const;

 private:
  void set_capacity(const Eigen::MatrixXd& capacity);
  void set_conductances(const Network& network);
  void set_walls(const Network& network);
  void set_feedback_columns();
  template <typename Weights>
  void add_terms(const Eigen::MatrixBase<Weights>& weights, Eigen::VectorXd& packed) const;
  void add_sources(const BoundaryValues& values, Eigen::VectorXd& u) const;
  static void unpack(const Eigen::VectorXd& packed, Eigen::MatrixXd& lower);

  Eigen::MatrixXd capacity_root_;      // L
  Eigen::VectorXd packed_conduction_;  // columns of the lower triangle of K̃₀, one after another
  Eigen::Index conductances_ = 0;
  // The same of all K̃ⱼ, in blocks: the first entries of every term one term after another, then the next of every term.
  // Together they are larger than the cache beside the processor, and what counts is how fast they come from memory:
  // in the order in which they lie, into a piece of the sum that stays in the innermost cache.
  Eigen::VectorXd conductance_terms_;
  Eigen::MatrixXd films_;  // L⁻¹ Fⱼ Fⱼᵀ 1 of those conductances that have an environment
  std::vector<Eigen::Index> film_conductance_;
  std::vector<Eigen::Index> film_environment_;
  CoolantSegments segments_;
  Eigen::MatrixXd walls_;    // P
  Eigen::MatrixXd sources_;  // L⁻¹ B
  Eigen::Index environments_ = 0;
  double reference_K_ = 0.0;
  double internal_per_kelvin_ = 0.0;
  bool diagonal_capacity_ = false;
  LawTerms laws_;
  Eigen::MatrixXd feedback_columns_;  // W, empty without laws
};

}  // namespace spindle_twin::rom
