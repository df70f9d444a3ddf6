#pragma once

#include <memory>

#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/stepper.hpp"

namespace spindle_twin::rom {

/// The first stepper while it serves; when it fails, the second one does that period from the last good state and the
/// first one goes on from there. A failure of both leaves the temperatures as they were and returns the second's
/// status.
class FallbackStepper final : public Stepper {
 public:
  FallbackStepper(std::unique_ptr<Stepper> first, std::unique_ptr<Stepper> second);

  void set_temperatures(const Eigen::VectorXd& temperatures_K) override;

  /// Cycle-safe as far as the first stepper is; a fallback to ExactStepper may allocate.
  StepStatus advance(double period_s, const BoundaryValues& values) override;
  const Eigen::VectorXd& temperatures_K() const override { return first_->temperatures_K(); }

  /// What the first stepper said of the last advance(); other than ok means that the second one was asked.
  StepStatus first_status() const { return first_status_; }
  long fallbacks() const { return fallbacks_; }

 private:
  std::unique_ptr<Stepper> first_;
  std::unique_ptr<Stepper> second_;
  StepStatus first_status_ = StepStatus::ok;
  long fallbacks_ = 0;
};

/// CVODE with the exact stepper behind it: what daemon, simulation and replay run. Throws std::invalid_argument for a
/// network that NetworkOperator refuses. Allocates.
std::unique_ptr<FallbackStepper> make_runtime_stepper(const Network& network, const CvodeSettings& settings = {});
/// The same with an operator that others use too: of a network of 200 nodes it is the largest part of what a stepper
/// needs.
std::unique_ptr<FallbackStepper> make_runtime_stepper(std::shared_ptr<const NetworkOperator> shared,
                                                      const CvodeSettings& settings = {});

}  // namespace spindle_twin::rom
