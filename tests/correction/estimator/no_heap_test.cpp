#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace estimator_no_heap_test {

/// 201 nodes, as large as a spindle's network; the second with as many parameters as one has, too.
class EstimatorOfShape : public testing::TestWithParam<rom::tests::SyntheticShape> {};

/// Which a service recalls in every update.
std::shared_ptr<const CalibratedPrior> two_parameters_of_a_test(const rom::Network& network) {
  const ParameterModel parameters(network, {});
  auto test = std::make_shared<CalibratedPrior>();
  test->names = {parameters.list()[0].name, parameters.list()[1].name};
  test->mean = Eigen::Vector2d::Zero();
  test->covariance = 0.04 * Eigen::Matrix2d::Identity();
  return test;
}

TEST_P(EstimatorOfShape, step_never_calls_the_heap) {
  const rom::Network network = rom::tests::make_synthetic_network(GetParam(), 5);
  EstimatorOptions options;
  options.priors.calibrated = two_parameters_of_a_test(network);
  EstimatorCorrection estimator(network, options);
  const auto sensors = static_cast<Eigen::Index>(estimator.sensors().size());
  const auto valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(sensors, true).eval();
  rom::OperatingState operating = network.boundaries.operating;
  const Eigen::VectorXd nodes_K = Eigen::VectorXd::Constant(network.capacity_J_per_K.rows(), 305.0);
  const Eigen::VectorXd measured_K = Eigen::VectorXd::Constant(sensors, 305.1);
  EstimatorState state;
  estimator.reset(0.0, nodes_K, operating);
  estimator.save(state);
  int updates = 0;
  const long before = rom::tests::heap_calls();
  for (int second = 0; second <= 60; ++second) {
    if (second == 25) estimator.note_displacement(0, 1e-5, 1e-6);
    if (second == 35) estimator.note_contradiction();
    operating.speed_rpm = second < 33 ? 6000.0 : 9000.0;
    updates += estimator.step({static_cast<double>(second), measured_K, valid, nodes_K, operating}, 1.0).corrected;
  }
  for (int second = 61; second <= 90; ++second) {
    estimator.stand_by(static_cast<double>(second), nodes_K, operating, 1.0);
  }
  estimator.save(state);
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
  EXPECT_EQ(updates, 6);
  EXPECT_EQ(estimator.loosened(), 1) << "a loosening is among the steps";
  EXPECT_EQ(estimator.failures(), 0);
}

TEST_P(EstimatorOfShape, a_second_pass_never_calls_the_heap) {
  const rom::Network network = rom::tests::make_synthetic_network(GetParam(), 5);
  Pair pair(network, {});
  pair.cycle_s = 10.0;
  pair.truth = pair.estimator.parameters().mean();
  pair.truth[0] += 0.5;
  long calls = 0;
  while (pair.estimator.relinearised() == 0 && pair.time_s < 2400.0) {
    pair.read();
    if (pair.time_s == 1400.0) pair.estimator.note_displacement(0, pair.plant.outputs.deformations_m[0], 1e-6);
    const long before = rom::tests::heap_calls();
    pair.step();
    if (pair.time_s > 0.0) calls += rom::tests::heap_calls() - before;
    pair.advance();
  }
  EXPECT_EQ(pair.estimator.relinearised(), 1);
  EXPECT_EQ(calls, 0);
}

INSTANTIATE_TEST_SUITE_P(Networks, EstimatorOfShape,
                         testing::Values(rom::tests::SyntheticShape{8, 5, 5, true},
                                         rom::tests::SyntheticShape{40, 5, 1, true}),
                         [](const auto& shape) { return std::to_string(shape.param.bodies) + "_bodies"; });

}  // namespace estimator_no_heap_test
}  // namespace spindle_twin::correction::test
