#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem_offline/model/affine_model.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

/// Largest errors wanted of a network in any case: of every key point, every deformation, every part's maximum.
struct Tolerance {
  double key_points_K = 0.03;
  double deformations_um = 0.015;
  double part_max_K = 0.2;
};

/// An output that keeps a network from the tolerance.
struct MissedOutput {
  enum class Kind { key_point, deformation, part_maximum };
  Kind kind = Kind::key_point;
  std::string name;
  double error = 0.0;   ///< K or um: the largest that was seen, or the certificate's limit
  double wanted = 0.0;  ///< K or um, at most

  double ratio() const { return error / wanted; }
};

/// Outputs that err more than is wanted of them, the one that errs most against it first. `errors`: SI, of every output
/// of `model` in the order of OutputLayout.
std::vector<MissedOutput> missed_outputs(const AffineModel& model, const Eigen::VectorXd& errors,
                                         const Tolerance& wanted);

/// Limits of a certificate above `wanted`, the one furthest above it first: that of the largest error of all key points
/// and of all part maxima in a case, under the name of the output that errs most, and those of the deformations. Empty
/// where all are kept. The certificate must have limits (CertificateLimit::content above 0).
std::vector<MissedOutput> missed_limits(const AffineModel& model, const rom::Certificate& certificate,
                                        const Tolerance& wanted);

}  // namespace spindle_twin::fem_offline
