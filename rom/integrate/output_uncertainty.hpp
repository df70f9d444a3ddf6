#pragma once

#include <Eigen/Core>

#include "rom/network.hpp"

namespace spindle_twin::rom {

/// 1σ of what the certificate says of one output: σ² = (limit/2)² + mesh². The limit of the largest error of a case
/// counts as 2σ: what a published band of ±2σ has to cover; in files of before there was one the worst of the cases
/// that were run stands for it. The mesh error is the same in every case, so it counts in full. Independent of heats,
/// contacts and sensors, whose variances add.
double certificate_deviation(const OutputError& error);

/// Standard deviations that the network itself adds to each of its outputs, in the order of NetworkOutputs. Not a
/// number where the certificate says nothing.
struct OutputUncertainty {
  Eigen::VectorXd key_points_K;
  Eigen::VectorXd part_means_K;
  Eigen::VectorXd part_maxima_K;
  Eigen::VectorXd deformations_m;
  Eigen::VectorXd contact_pressures_Pa;
};

/// All of an output's kind: σ of what its certificate says. Files of before there were errors per output know the worst
/// key point, the worst part maximum and the nose alone; these stand for their kind, a part's maximum also for its
/// mean, without a mesh error. All NaN without a certificate. Allocates.
OutputUncertainty output_uncertainty(const Network& network);

}  // namespace spindle_twin::rom
