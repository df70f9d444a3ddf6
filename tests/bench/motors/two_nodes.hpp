#pragma once

#include <Eigen/Core>
#include <array>

#include "rom/network.hpp"
#include "tests/bench/motors/motor.hpp"

namespace spindle_twin::bench {

/// What a person writes for a motor: winding and housing, a contact between them, a film to the room, a copper loss in
/// the winding and a loss with speed in both. The logarithms of the six numbers.
struct TwoNodes {
  enum Index : Eigen::Index { winding_J_per_K, housing_J_per_K, contact_W_per_K, film_W_per_K, copper_W, speed_W };
  static constexpr Eigen::Index count = 6;
  Eigen::Matrix<double, count, 1> logarithms = Eigen::Matrix<double, count, 1>::Zero();
  double value(Index i) const;
};

struct TwoNodesFit {
  TwoNodes nodes;
  double rms_K = 0.0;  ///< what is left between the fit and the motor, over both temperatures
};

/// Least squares over four hours of a duty of its own, from a cold start.
TwoNodesFit best_two_nodes(const Motor& motor, Random& random);

/// Capacities and conductances 30-50 % higher or lower. The signs: +1, -1, or 0 for one at random.
TwoNodes made_wrong(const TwoNodes& fit, const std::array<int, 4>& signs, Random& random);

/// As a file that somebody wrote would be read; key points "winding" and "housing".
rom::Network network_of(const TwoNodes& nodes);

constexpr double rated_speed_rpm = 3000.0;

}  // namespace spindle_twin::bench
