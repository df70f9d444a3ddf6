#pragma once

#include <Eigen/Core>

#include "rom/network.hpp"

namespace spindle_twin::rom {

/// Standard deviations that the network itself adds to each of its outputs, in the order of NetworkOutputs. Not a
/// number where the certificate says nothing.
struct OutputUncertainty {
  Eigen::VectorXd key_points_K;
  Eigen::VectorXd part_means_K;
  Eigen::VectorXd part_maxima_K;
  Eigen::VectorXd deformations_m;
  Eigen::VectorXd contact_pressures_Pa;
};

/// σ = (worst + mesh) / 2, per output. |network − exact| <= |network − FE| + |FE − finer FE| <= worst + mesh over the
/// certificate's cases, so that ±2σ holds every case that was measured. Files of before there were errors per output
/// know the worst key point, the worst part maximum and the nose alone; these stand for their kind, without a mesh
/// error. It is independent of heats, contacts and sensors: variances add. All NaN without a certificate. Allocates.
OutputUncertainty output_uncertainty(const Network& network);

}  // namespace spindle_twin::rom
