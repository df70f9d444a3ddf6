#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "firmware/cycle/integrate.hpp"
#include "rom/integrate/exact_stepper.hpp"

namespace spindle_twin::firmware {

/// Makes exact steppers that say which steps they were asked for; of each stepper in the order in which it was made.
class RecordedSteps {
 public:
  MakeStepper maker() {
    return [this](const rom::Network& network) {
      const auto shared = std::make_shared<const rom::NetworkOperator>(network);
      steps_.push_back(std::make_unique<std::vector<double>>());
      auto first = std::make_unique<Recording>(shared, *steps_.back());
      return std::make_unique<rom::FallbackStepper>(std::move(first), std::make_unique<rom::ExactStepper>(shared));
    };
  }

  /// Periods [s] of the stepper that was made as the n-th since they were asked for last.
  std::vector<double> take(std::size_t n) { return std::exchange(*steps_[n], {}); }

 private:
  class Recording final : public rom::Stepper {
   public:
    Recording(std::shared_ptr<const rom::NetworkOperator> shared, std::vector<double>& steps)
        : inner_(std::move(shared)), steps_(steps) {}
    void set_temperatures(const Eigen::VectorXd& temperatures_K) override { inner_.set_temperatures(temperatures_K); }
    rom::StepStatus advance(double period_s, const rom::BoundaryValues& values) override {
      steps_.push_back(period_s);
      return inner_.advance(period_s, values);
    }
    const Eigen::VectorXd& temperatures_K() const override { return inner_.temperatures_K(); }

   private:
    rom::ExactStepper inner_;
    std::vector<double>& steps_;
  };

  std::vector<std::unique_ptr<std::vector<double>>> steps_;
};

}  // namespace spindle_twin::firmware
