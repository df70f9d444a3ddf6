#pragma once

#include <cmath>
#include <vector>

#include "correction/calibrate/predict_test.hpp"
#include "correction/estimator/estimator_correction.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::correction::test {

/// One node with a sensor and a probe, in two tests of different lengths. What was read is what the model says with a
/// heat and a film that are not the means of the priors, and a bit besides, the same every time.
struct FittedNode {
  FittedNode() : network(rom::tests::make_single_node()) {
    options.sensors = key_point_sensors(network, {});
    options.priors = test_priors(options.priors);
    options.starts = 1;
    options.held_s = 10.0;
    options.interval_s = 20.0;
    options.lag_deviation_s = 1e-3;  // below no lag at all readings would not follow it
  }
  static ThermalTest drive(const rom::Network& network, double length_s) {
    ThermalTest test;
    test.name = "drive";
    test.start_K = network.boundaries.reference_temperature_K;
    for (double time_s = 0.0; time_s <= length_s; time_s += 10.0) {
      test.time_s.push_back(time_s);
      test.operating.push_back(network.boundaries.operating);
      test.operating.back().speed_rpm = time_s < 0.5 * length_s ? 6000.0 : 3000.0;
      test.operating.back().load = 1.0;
    }
    const auto rows = static_cast<Eigen::Index>(test.time_s.size());
    test.measured_K = Eigen::MatrixXd::Zero(rows, 1);
    test.deformation_m = Eigen::MatrixXd::Zero(rows, 1);
    return test;
  }
  /// Readings that the model with these parameters would give, each off by a step of a fixed pattern.
  void read(const TestPredictor& predictor, double off_K, double off_m) {
    Eigen::VectorXd theta = predictor.parameters().mean();
    theta[predictor.parameters().heat(0)] += 0.3;
    theta[predictor.parameters().conductance(0)] -= 0.2;
    for (const double length_s : {400.0, 300.0}) {
      ThermalTest test = drive(network, length_s);
      CalibrateOptions each = options;  // a reading of each instant
      each.interval_s = each.held_s = 0.0;
      const TestPrediction model = TestPredictor(network, each).predict(test, theta, Eigen::VectorXd::Zero(1));
      for (const TestReading& reading : model.readings) {
        const auto row = static_cast<Eigen::Index>(std::lround(reading.time_s / 10.0));
        const double pattern = std::sin(2.3 * static_cast<double>(row) + reading.channel);
        if (reading.channel == 0) test.measured_K(row, 0) = -reading.residual + off_K * pattern;
        if (reading.channel == 1) test.deformation_m(row, 0) = -reading.residual + off_m * pattern + 3e-6;
      }
      tests.push_back(test);
    }
  }
  rom::Network network;
  CalibrateOptions options;
  std::vector<ThermalTest> tests;
};

}  // namespace spindle_twin::correction::test
