#pragma once

#include <Eigen/Core>
#include <vector>

#include "correction/estimator/sensitivities.hpp"
#include "correction/estimator/square_root_filter.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// What P leaves out.
struct LeftOut {
  const Eigen::VectorXd& bend;  ///< one entry per parameter, √(κ/2) P_ii where it is the ln of a factor, else 0
  double scale_factor = 1.0;    ///< √ρ
};

/// 1σ of every published temperature and deformation.
struct OutputDeviations {
  Eigen::VectorXd key_points_K;
  Eigen::VectorXd part_mean_K;
  Eigen::VectorXd part_maximum_K;
  Eigen::VectorXd deformations_m;
  Eigen::VectorXd contact_pressures_Pa;
};

/// σ² = ρ (l S P Sᵀ lᵀ + κ ½ Σ (l S)_i² P_ii²) + certificate², with P of the parameters: what state and parameters
/// leave open (the sum over the ln factors, in which outputs are not linear; ρ of ReducedChiSquare), and what the
/// network itself leaves out. An output follows e^θ of a heat and e^−θ of a conductance, so its error is skewed and its
/// long tail lies beyond 2σ. Published is half the way to the point that a fraction Φ(−2) of a skewed error exceeds
/// (Cornish and Fisher, 1938):
///   σ (1 + min(|γ|, 2) / 4),   γ σ³ = 3 Σ ±(l S)_i (P Sᵀ lᵀ)_i²,   + heats, − conductances, 0 what is not an ln factor
/// Of a deformation L, l S is e^g l S and L itself in the place of g, the ln of its factor (expand_by).
/// Alternatives are steps in θ of which one may be true besides: max (l S Δθ)² is added. Of a part's maximum the row l
/// is that of its hottest candidate point, the first of those that are equally hot.
class DeviationOfOutputs {
 public:
  /// Of no output: evaluate() does nothing.
  DeviationOfOutputs() = default;
  /// `skewed`: γ counts. Allocates; evaluate() does not.
  DeviationOfOutputs(const rom::Network& network, const Sensitivities& sensitivities, const ParameterModel& parameters,
                     bool skewed);

  void evaluate(Sensitivities& sensitivities, SquareRootFilter& filter, const LeftOut& left_out,
                const Eigen::VectorXd& nodes_K);
  /// p x any number of steps, as many in every call.
  void set_alternatives(const Eigen::MatrixXd& steps) { alternatives_ = steps; }
  void clear_alternatives() { alternatives_.setZero(); }
  const OutputDeviations& deviations() const { return deviations_; }

 private:
  /// Rows on x and the certificate's 1σ of each.
  struct Rows {
    std::vector<Eigen::VectorXd> internal;
    std::vector<double> certificate;
  };
  void evaluate(const Rows& rows, Sensitivities& sensitivities, SquareRootFilter& filter, const LeftOut& left_out,
                Eigen::VectorXd& to);
  double deviation(const Eigen::Ref<const Eigen::VectorXd>& internal, double certificate, Sensitivities& sensitivities,
                   SquareRootFilter& filter, const LeftOut& left_out);

  double deviation(double certificate, SquareRootFilter& filter, const LeftOut& left_out);  ///< of sensitivity_

  Rows key_points_, part_means_, deformations_, pressures_;
  Eigen::Index expansion_ = -1;              // its place in θ
  std::vector<Eigen::MatrixXd> candidates_;  // per part, one row on x in each column
  std::vector<double> part_maximum_certificate_;
  Eigen::VectorXd skew_sign_;  // of each parameter
  Eigen::VectorXd sensitivity_, covariance_, x_;
  Eigen::MatrixXd alternatives_;
  OutputDeviations deviations_;
};

}  // namespace spindle_twin::correction
