#pragma once

#include <Eigen/Core>

#include "rom/boundaries.hpp"
#include "rom/network.hpp"

namespace spindle_twin::rom {

/// What a stepper reports of its last advance(). `refused`: node heats or capacity factors that this network does not
/// take (accepts() in integrate/right_hand_side.hpp), so that no other stepper would serve either.
enum class StepStatus { ok, integrator_failed, not_finite, refused };

/// Anything that carries the network's node temperatures forward with heats, conductances and environments held.
/// advance() moves exactly period_s; on a status other than ok the temperatures are those from before the call.
class Stepper {
 public:
  virtual ~Stepper() = default;
  virtual void set_temperatures(const Eigen::VectorXd& temperatures_K) = 0;
  virtual StepStatus advance(double period_s, const BoundaryValues& values) = 0;
  virtual const Eigen::VectorXd& temperatures_K() const = 0;
};

}  // namespace spindle_twin::rom
