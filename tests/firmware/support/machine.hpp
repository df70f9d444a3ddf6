#pragma once

#include <cstdint>
#include <memory>

#include "firmware/cycle/cycle.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {

inline constexpr double start_K = 300.15;

inline std::unique_ptr<rom::FallbackStepper> runtime(const rom::Network& network) {
  return rom::make_runtime_stepper(network);
}

inline CyclePlan open_loop() {
  CyclePlan plan;
  plan.signals[0] = {SignalSource::constant, 6000.0, 0.0, 1e5, 0.0};
  plan.signals[1] = {SignalSource::constant, 1.0, 0.0, 2.0, 0.0};
  plan.signals[2] = plan.signals[3] = {SignalSource::constant, start_K, 200.0, 500.0, 0.0};
  plan.start_temperature_K = start_K;
  return plan;
}

inline CyclePlan with_sensors() {
  CyclePlan plan = open_loop();
  for (std::size_t k = 0; k < 3; ++k) plan.sensors[k].configured = true;
  return plan;
}

/// By the published law.
inline CyclePlan corrected() {
  CyclePlan plan = with_sensors();
  plan.paper = correction::PaperOptions{};
  plan.paper->guards.settle_s = 0.0;
  return plan;
}

inline CyclePlan estimated() {
  CyclePlan plan = with_sensors();
  plan.estimator = correction::EstimatorOptions{};
  return plan;
}

/// Another integration of the same network with other heat stands for the machine.
struct Machine {
  explicit Machine(const rom::Network& of, double heat) : network(of), model(make_model(of, runtime)) {
    factors = rom::no_correction(network.boundaries);
    factors.heat.setConstant(heat);
    operating = network.boundaries.operating;
    model.stepper->set_temperatures(
        Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network.nodes.size()), start_K));
    predict(network, model);
  }

  DeviceFrame frame(std::int64_t now_ns) const {
    DeviceFrame frame;
    frame.connected = true;
    for (Eigen::Index k = 0; k < model.outputs.key_points_K.size(); ++k) {
      frame.sensors[static_cast<std::size_t>(k)] = {model.outputs.key_points_K[k], now_ns};
    }
    return frame;
  }

  void advance(double period_s) {
    integrate(network, operating, factors, period_s, model);
    predict(network, model);
  }

  const rom::Network& network;
  Model model;
  rom::CorrectionFactors factors;
  rom::OperatingState operating;
};

inline std::int64_t at_s(int cycle) { return 1'000'000'000LL * (cycle + 1); }

}  // namespace spindle_twin::firmware
