#pragma once

#include <Eigen/SparseCore>
#include <optional>
#include <string>
#include <vector>

#include "fem_offline/description/spindle.hpp"
#include "fem_offline/sparse/sparse_matrix.hpp"
#include "rom/boundaries.hpp"

namespace spindle_twin::fem_offline {

/// Where an unknown sits. Air volumes follow the FE nodes and have part = -1.
struct DofPlace {
  int part = -1;
  double r_m = 0.0;
  double z_m = 0.0;
};

struct FePart {
  std::string name;
  std::vector<int> dofs;            ///< all of its unknowns
  Eigen::VectorXd mean_row;         ///< n; volume mean
  std::optional<double> initial_K;  ///< where a transient starts, if the description says so
};

struct FeKeyPoint {
  std::string name;
  int part = 0;
  Point at;
  Eigen::SparseVector<double> row;  ///< n
};

struct FeDeformation {
  std::string name;
  Eigen::VectorXd row_m_per_K;  ///< n, from one adjoint elastic solve; deformation_m = row · (T − T_ref)
};

struct FeContactPressure {
  std::string name;
  double assembly_pressure_Pa = 0.0;
  Eigen::VectorXd row_Pa_per_K;  ///< n; pressure_Pa = assembly + row · (T − T_ref)
};

/// The FE model as affine terms, free of the FE library:
///   C dT/dt = −(K₀ + Σⱼ gⱼ Kⱼ) T + Σⱼ gⱼ (Kⱼ 1) T_env(j) + B q
/// n unknowns; C [J/K], K₀ [W/K], Kⱼ [m²] (for 1 W/m²K), B [1] with columns that sum to 1. All symmetric. Rows of K₀
/// and of every Kⱼ between bodies sum to zero. Order of conductances, environments and
/// circuits: description/model_places.
struct AffineModel {  // NOLINT(public-members): the terms of one equation, and what each unknown means
  std::string spindle;
  std::string description_hash;
  rom::Boundaries boundaries;
  SparseMatrix capacity_J_per_K;
  SparseMatrix conduction_W_per_K;
  std::vector<SparseMatrix> conductance_terms_m2;
  std::vector<int> held;                ///< the conductances that prescribe a temperature
  Eigen::MatrixXd source_distribution;  ///< n x sources
  std::vector<DofPlace> places;
  std::vector<std::string> air_names;  ///< of the last unknowns
  std::vector<FePart> parts;
  std::vector<FeKeyPoint> key_points;
  std::vector<FeDeformation> deformations;
  std::vector<FeContactPressure> contact_pressures;
  std::optional<Eigen::VectorXd>
      imposed_rises_K;  ///< n; the field that the description gives instead of a heat balance
};

}  // namespace spindle_twin::fem_offline
