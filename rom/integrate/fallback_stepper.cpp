#include "rom/integrate/fallback_stepper.hpp"

#include <utility>

#include "rom/integrate/exact_stepper.hpp"

namespace spindle_twin::rom {

FallbackStepper::FallbackStepper(std::unique_ptr<Stepper> first, std::unique_ptr<Stepper> second)
    : first_(std::move(first)), second_(std::move(second)) {}

void FallbackStepper::set_temperatures(const Eigen::VectorXd& temperatures_K) {
  first_->set_temperatures(temperatures_K);
}

StepStatus FallbackStepper::advance(double period_s, const BoundaryValues& values) {
  first_status_ = first_->advance(period_s, values);
  if (first_status_ == StepStatus::ok) return StepStatus::ok;
  ++fallbacks_;
  second_->set_temperatures(first_->temperatures_K());
  const StepStatus status = second_->advance(period_s, values);
  if (status == StepStatus::ok) first_->set_temperatures(second_->temperatures_K());
  return status;
}

std::unique_ptr<FallbackStepper> make_runtime_stepper(const Network& network, const CvodeSettings& settings) {
  return make_runtime_stepper(std::make_shared<const NetworkOperator>(network), settings);
}

std::unique_ptr<FallbackStepper> make_runtime_stepper(std::shared_ptr<const NetworkOperator> shared,
                                                      const CvodeSettings& settings) {
  auto first = std::make_unique<CvodeStepper>(shared, settings);
  return std::make_unique<FallbackStepper>(std::move(first), std::make_unique<ExactStepper>(std::move(shared)));
}

}  // namespace spindle_twin::rom
