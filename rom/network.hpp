#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

/// A state of the network is the temperature of this physical point (or of a well-mixed air volume).
struct Node {
  std::string name;
  std::string part;  ///< empty for an air volume
  double r_m = 0.0;
  double z_m = 0.0;
};

struct KeyPoint {
  std::string name;
  std::string part;
  double r_m = 0.0;
  double z_m = 0.0;
  Eigen::VectorXd row;  ///< N; temperature_K = row · T
};

/// A part's temperatures: volume mean, and the extremes taken over a few candidate points.
struct PartOutput {
  std::string name;
  Eigen::VectorXd mean_row;        ///< N
  Eigen::MatrixXd candidate_rows;  ///< M x N; maximum_K = max_i (candidate_rows · T)_i, minimum likewise
};

struct DeformationOutput {
  std::string name;
  Eigen::VectorXd row_m_per_K;  ///< N; deformation_m = row · (T − T_ref); + = spindle longer
};

/// Mean pressure of a joint: pressure_Pa = assembly + row · (T − T_ref), bonded and linear: below zero it would open.
struct ContactPressureOutput {
  std::string name;
  double assembly_pressure_Pa = 0.0;
  Eigen::VectorXd row_Pa_per_K;  ///< N
};

/// A closed ring of a part's outline on the meridian section, for pictures: outer rings counter-clockwise (r to the
/// right, z up), holes clockwise.
struct OutlineRing {
  std::string part;
  Eigen::MatrixXd points_m;  ///< 2 x M: r, z
};

/// One column of a certificate: errors of network minus FE model over random cases, on key points, nose, part maxima.
struct CertificateErrors {
  double key_points_K = 0.0;
  double nose_um = 0.0;
  double part_max_K = 0.0;
};

/// Largest |network − FE model| of one output over a case: worst and median over the cases that were run; what a finer
/// FE mesh changes in that output at the operating state; and the limit that other cases exceed no more often than
/// CertificateLimit says, 0 in files of before there was one. In the output's own unit: K, m or Pa.
struct OutputError {
  double worst = 0.0;
  double median = 0.0;
  double mesh = 0.0;
  double limit = 0.0;
};

/// What a limit is: with probability `confidence`, at most the share 1 − `content` of all cases from the box exceed it.
struct CertificateLimit {
  double content = 0.0;  ///< 0: no limits were measured
  double confidence = 0.0;
  bool fitted = false;  ///< log-normal through the cases that were run; else one of their own errors, whatever the law
};

/// The box of factors and states that the cases were drawn from.
struct CertificateBox {
  double contact_low = 0.0;
  double contact_high = 0.0;
  double film_low = 0.0;
  double film_high = 0.0;
  double speed_high_rpm = 0.0;
};

struct Certificate {  // NOLINT(public-members): columns of one table, as in the file
  std::uint64_t seed = 0;
  std::uint32_t cases = 0;  ///< 0: no certificate was measured
  CertificateErrors worst;
  CertificateErrors median;
  CertificateErrors limit;  ///< as OutputError::limit, of the largest error of each kind in a case
  CertificateLimit limit_rule;
  CertificateBox box;
  double mesh_size_m = 0.0;  ///< largest FE element wanted; 0 where there is no FE model
  std::uint32_t fe_unknowns = 0;
  /// Per output, in the order of the network's own lists; empty in files of before there were any.
  std::vector<OutputError> key_points_K;
  std::vector<OutputError> part_means_K;
  std::vector<OutputError> part_maxima_K;
  std::vector<OutputError> deformations_m;
  std::vector<OutputError> contact_pressures_Pa;
  std::uint32_t searched = 0;     ///< jumps that a search for the worst has tried; 0: none was made
  CertificateErrors worst_found;  ///< largest errors that it found, in corners that no drawn case need have come near
};

/// The nodal RC network:
///   C dT/dt = −(K₀ + Σⱼ gⱼ Fⱼ Fⱼᵀ) T + Σⱼ gⱼ Fⱼ Fⱼᵀ 1 T_env(j) + B q
/// N states. C, K₀ symmetric; C positive definite; rows of K₀ sum to zero; for an exchange between bodies
/// (environment < 0) columns of Fⱼ sum to zero. gⱼ in W/m²K, Fⱼ for 1 W/m²K. Columns of B sum to 1.
struct Network {                 // NOLINT(public-members): terms of one equation, and its outputs, as in the file
  std::string spindle;           ///< the description's name
  std::string description_hash;  ///< SHA-256, hex, of the description file the network was built from
  bool hand_written = false;     ///< there is no FE model, so no certificate can be measured
  std::vector<Node> nodes;
  Eigen::MatrixXd capacity_J_per_K;    ///< C, N x N
  Eigen::MatrixXd conduction_W_per_K;  ///< K₀, N x N
  Boundaries boundaries;
  std::vector<Eigen::MatrixXd> factors_m;  ///< Fⱼ, N x rankⱼ, one per conductance
  Eigen::MatrixXd source_distribution;     ///< B, N x sources
  std::vector<KeyPoint> key_points;
  std::vector<PartOutput> parts;
  std::vector<DeformationOutput> deformations;  ///< the first is the nose; of a hand-written network there may be none
  std::vector<ContactPressureOutput> contact_pressures;
  Certificate certificate;
  std::vector<OutlineRing> outlines;  ///< none where nobody drew the section
};

}  // namespace spindle_twin::rom
