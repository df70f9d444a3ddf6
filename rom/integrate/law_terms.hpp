#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "rom/integrate/coolant.hpp"
#include "rom/network.hpp"

namespace spindle_twin::rom {

/// What a law reads of the network's state, in this order: first and second temperature, pressure, displacement.
constexpr std::size_t law_readings = 4;

/// One physical law of a network. Its value is a heat of `source` or the value of `conductance`.
struct LawTerm {
  BoundLaw bound;
  int source = -1;
  int conductance = -1;
  std::array<Eigen::Index, law_readings> reading{};  ///< index into the readings, -1: nothing of the state
  int environment = -1;                              ///< of the conductance
  int segment = -1;                                  ///< of a coolant circuit
  int circuit = -1;
  double area_m2 = 0.0;         ///< of the segment
  Eigen::MatrixXd direction;    ///< L⁻¹B of the source (N x 1), or L⁻¹F of the conductance (N x rank)
  Eigen::VectorXd column_sums;  ///< Fᵀ1 towards an environment, otherwise 0
};

/// All physical laws of a network, in internal coordinates x (NetworkOperator). Readings z are linear outputs:
///   z = rowsᵀ x + offset        part means, contact pressures, deformations, Z of them
///   qᵢ = factorᵢ · lawᵢ(z),   gⱼ = factorⱼ · lawⱼ(z), of a segment G/A of the channel law at the film factorⱼ ·
///   lawⱼ(z)
/// Read-only after construction.
class LawTerms {
 public:
  LawTerms() = default;
  /// `capacity_root`: L of C = L Lᵀ; `segments` with the areas of the network's own matrices. Throws
  /// std::invalid_argument for an index that does not exist. Allocates.
  LawTerms(const Network& network, const Eigen::MatrixXd& capacity_root, const CoolantSegments& segments);

  const std::vector<LawTerm>& list() const { return list_; }
  bool empty() const { return list_.empty(); }
  Eigen::Index count() const { return static_cast<Eigen::Index>(list_.size()); }
  const Eigen::MatrixXd& rows() const { return rows_; }
  const Eigen::VectorXd& offset() const { return offset_; }

  /// Heats and conductances of the laws at these readings, into `values`; all else in it is left. Cycle-safe.
  void evaluate(const Eigen::VectorXd& readings, BoundaryValues& values) const;
  /// The same, with the slopes of each value by its law_readings readings (laws x law_readings). Cycle-safe.
  void evaluate(const Eigen::VectorXd& readings, BoundaryValues& values, Eigen::MatrixXd& slopes) const;
  /// The same as the first at these node temperatures. Cycle-safe.
  void at_temperatures(const Eigen::VectorXd& temperatures_K, BoundaryValues& values) const;

 private:
  Eigen::Index add_reading(const Eigen::VectorXd& nodal_row, double offset_at_0_K);

  std::vector<LawTerm> list_;
  Eigen::MatrixXd nodal_rows_;    // N x Z: z = nodal_rowsᵀ T + nodal_offset
  Eigen::VectorXd nodal_offset_;  // Z
  Eigen::MatrixXd rows_;          // L⁻¹ nodal_rows
  Eigen::VectorXd offset_;        // nodal_offset + nodal_rowsᵀ 1 T_ref
};

}  // namespace spindle_twin::rom
