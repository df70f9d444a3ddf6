#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <memory>
#include <random>

#include "correction/estimator/estimator_correction.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/outputs.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::correction::test {

/// Four plates, contacts, films, a friction heat at the first and a motor heat on the last; a sensor on each plate.
inline rom::Network plates() {
  rom::Network network = rom::tests::make_synthetic_network({4, 3, 3, true}, 7);
  network.boundaries.sources[0].law = {0.0, {{0.5, 1.0}, {0.5, 1.6}}, 0.0, false};
  network.boundaries.sources[0].friction = true;
  network.certificate = {};
  return network;
}

/// Only environments are read wrong, for good, by 0.5 K: the readings are linear in all unknowns.
inline EstimatorOptions environments_alone() {
  EstimatorOptions options;
  options.priors.heat = options.priors.contact = options.priors.film = options.priors.speed_exponent = 0.0;
  options.priors.bearing_per_K = options.priors.expansion = options.priors.start_K = options.priors.disturbance = 0.0;
  options.priors.environment_K = 0.5;
  options.priors.environment_memory_s = 0.0;
  options.lag_deviation_s = 0.0;
  return options;
}

/// One model: the network with parameters of its own.
struct Model {
  explicit Model(const rom::Network& the_network)
      : network(the_network),
        stepper(std::make_shared<const rom::NetworkOperator>(the_network)),
        values(make_boundary_values(the_network.boundaries)),
        outputs(rom::make_network_outputs(the_network)) {
    rom::evaluate_outputs(network, stepper.temperatures_K(), outputs);
  }
  void advance(double period_s, const rom::OperatingState& operating, const rom::CorrectionFactors& factors) {
    evaluate_boundaries(network.boundaries, operating, factors, values);
    ASSERT_EQ(stepper.advance(period_s, values), rom::StepStatus::ok);
    rom::evaluate_outputs(network, stepper.temperatures_K(), outputs, factors.expansion);
  }
  const rom::Network& network;
  rom::CvodeStepper stepper;
  rom::BoundaryValues values;
  rom::NetworkOutputs outputs;
};

/// A plant with hidden parameters and the twin that follows it, in cycles of cycle_s.
struct Pair {
  Pair(const rom::Network& the_network, const EstimatorOptions& options)
      : network(the_network),
        plant(the_network),
        twin(the_network),
        estimator(the_network, options),
        operating(the_network.boundaries.operating),
        truth(estimator.parameters().neutral()),
        plant_factors(estimator.parameters().make_factors(the_network)),
        plant_bias_K(Eigen::VectorXd::Zero(operating.environment_K.size())),
        rises_K(Eigen::VectorXd::Zero(plant_factors.heat.size())),
        offset_K(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(estimator.sensors().size()))),
        measured_K(offset_K),
        valid(Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(offset_K.size(), true)) {}

  int parameter(const std::string& name) const {
    const auto& list = estimator.parameters().list();
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i].name == name) return static_cast<int>(i);
    }
    ADD_FAILURE() << "no parameter " << name;
    return 0;
  }

  EstimatorStep cycle() {
    read();
    const EstimatorStep made = step();
    advance();
    return made;
  }

  void read() {
    for (Eigen::Index s = 0; s < measured_K.size(); ++s) {
      measured_K[s] = estimator.sensors()[static_cast<std::size_t>(s)].row.dot(plant.stepper.temperatures_K()) +
                      offset_K[s] + noise_K * normal(random);
    }
    if (tamper) tamper(measured_K);
  }

  EstimatorStep step() {
    const EstimatorStep made =
        estimator.step({time_s, measured_K, valid, twin.stepper.temperatures_K(), operating}, cycle_s);
    if (made.state_corrected) {
      twin.stepper.set_temperatures(estimator.corrected_nodes_K());
      rom::evaluate_outputs(network, twin.stepper.temperatures_K(), twin.outputs, estimator.factors().expansion);
    }
    return made;
  }

  void advance() {
    rom::OperatingState biased = operating;
    biased.environment_K += estimator.environment_bias_K();
    twin.advance(cycle_s, biased, estimator.factors());
    advance_plant();
  }

  void advance_plant() {
    for (Eigen::Index i = 0; i < rises_K.size(); ++i) {
      rises_K[i] = network.source_distribution.col(i).dot(plant.stepper.temperatures_K()) -
                   network.boundaries.reference_temperature_K;
    }
    estimator.parameters().apply(truth, operating.speed_rpm, rises_K, plant_factors, plant_bias_K);
    rom::OperatingState biased = operating;
    biased.environment_K += plant_bias_K;
    plant.advance(cycle_s, biased, plant_factors);
    time_s += cycle_s;
  }

  void run_until(double end_s) {
    while (time_s < end_s - 1e-9) cycle();
  }
  double nose_error_m() const { return twin.outputs.deformations_m[0] - plant.outputs.deformations_m[0]; }
  double sensor_error_K() const {
    return (twin.outputs.key_points_K - plant.outputs.key_points_K).lpNorm<Eigen::Infinity>();
  }

  const rom::Network& network;
  Model plant, twin;
  EstimatorCorrection estimator;
  rom::OperatingState operating;
  Eigen::VectorXd truth;
  rom::CorrectionFactors plant_factors;
  Eigen::VectorXd plant_bias_K, rises_K, offset_K, measured_K;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid;
  std::function<void(Eigen::VectorXd&)> tamper;  ///< changes the readings before they are handed over
  double cycle_s = 2.0;
  double noise_K = 0.0;
  double time_s = 0.0;
  std::mt19937_64 random{11};
  std::normal_distribution<double> normal{0.0, 1.0};
};

}  // namespace spindle_twin::correction::test
