#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "rom/range.hpp"

namespace spindle_twin::correction {

/// What the estimator can be told of a sensor.
inline constexpr rom::Range noise_range_K = rom::between(1e-4, 10.0);
inline constexpr rom::Range offset_range_K = rom::between(1e-4, 10.0);  ///< deviation of the offset
inline constexpr rom::Range lag_range_s = rom::between(0.0, 600.0);

/// A temperature sensor as the estimator sees it.
struct EstimatorSensor {
  std::string name;
  Eigen::VectorXd row;    ///< N; temperature_K = row · T, entries sum to 1
  double noise_K = 0.03;  ///< 1σ of one reading
  double offset_deviation_K =
      0.02;            ///< 1σ of its constant error: 0.02 after a tare, 0.2 for a class A PT100 without one
  double lag_s = 0.0;  ///< first-order lag between the temperature and the reading: mean of its prior
};

/// What the last update made of a channel: of a sensor in K, of a displacement the same in m.
struct SensorRecord {
  double observation_K = 0.0;  ///< mean of the valid readings since the update before; NaN without one
  double innovation_K = 0.0;   ///< observation − prediction − offset, before this channel was fused
  double variance_K2 = 0.0;    ///< expected of the innovation
  double test_ratio = 0.0;     ///< innovation² / (gate² variance): above 1 it is rejected
  bool rejected = false;
  bool fused = false;
  double offset_K = 0.0;
  double offset_deviation_K = 0.0;
  int rejected_in_a_row = 0;
};

/// What an update was made from, for other filters over the same unknowns z = (θ, b, τ) that see the same readings:
/// ln factors and the other parameters, offsets and lags of the sensors.
struct EstimatorUpdate {
  double elapsed_s = 0.0;        ///< since the update before
  Eigen::VectorXd unknowns;      ///< z before it, n; innovations and rows hold there
  Eigen::MatrixXd rows;          ///< n x sensors: d(prediction + offset)/dz
  Eigen::VectorXd innovation_K;  ///< mean of reading − prediction − offset; NaN without a valid reading
  Eigen::VectorXd noise_K2;      ///< variance of the innovation besides that of z
  double displacement_m = std::numeric_limits<double>::quiet_NaN();  ///< innovation of a touch-off; NaN without one
  double displacement_variance_m2 = 1.0;                             ///< besides that of z
  Eigen::VectorXd displacement_row;                                  ///< n

  /// Innovation of a sensor for a filter whose mean is `mean`. May run in the cycle.
  double innovation_at(Eigen::Index sensor, const Eigen::VectorXd& mean) const {
    return innovation_K[sensor] - rows.col(sensor).dot(mean - unknowns);
  }
  double displacement_at(const Eigen::VectorXd& mean) const {
    return displacement_m - displacement_row.dot(mean - unknowns);
  }
};

}  // namespace spindle_twin::correction
