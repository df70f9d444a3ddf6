#include "correction/estimator/start_shapes.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::correction::test {
namespace estimator_start_shapes_test {

struct Shapes {
  explicit Shapes(rom::Network the_network)
      : network(std::move(the_network)),
        list(start_shapes(network, rom::NetworkOperator(network), thermal_groups(network, 8))),
        values(make_boundary_values(network.boundaries)) {
    evaluate_boundaries(network.boundaries, network.boundaries.operating, no_correction(network.boundaries), values);
    exchange_W_per_K = network.conduction_W_per_K;
    for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
      exchange_W_per_K += values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)] * network.factors_m[j] *
                          network.factors_m[j].transpose();
    }
  }
  Eigen::VectorXd heat_W() const { return network.source_distribution * values.heat_W; }
  rom::Network network;
  std::vector<StartShape> list;
  rom::BoundaryValues values;
  Eigen::MatrixXd exchange_W_per_K;  ///< with the films to the surroundings
};

Shapes plates_and_their_air() { return Shapes(rom::tests::make_synthetic_network({3, 2, 2, true}, 5)); }

TEST(StartShapes, are_one_kelvin_at_their_largest_and_in_order) {
  const Shapes shapes = plates_and_their_air();
  ASSERT_EQ(shapes.list.size(), 7u);  // uniform, running, stopped, three plates, the air
  for (const StartShape& shape : shapes.list) EXPECT_NEAR(shape.rise_K.lpNorm<Eigen::Infinity>(), 1.0, 1e-12);
  EXPECT_EQ(shapes.list[0].name, "uniform");
  EXPECT_EQ(shapes.list[0].rise_K, Eigen::VectorXd::Ones(13));
  EXPECT_EQ(shapes.list[1].name, "running");
  EXPECT_EQ(shapes.list[2].name, "stopped");
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(13);
  for (std::size_t k = 3; k < shapes.list.size(); ++k) sum += shapes.list[k].rise_K;
  EXPECT_EQ(sum, Eigen::VectorXd::Ones(13));
}

TEST(StartShapes, without_heats_there_is_no_running_spindle) {
  rom::Network network = rom::tests::make_synthetic_network({3, 2, 2, true}, 5);
  for (rom::HeatSource& source : network.boundaries.sources) source.nominal_W = 0.0;
  const Shapes shapes(std::move(network));
  ASSERT_EQ(shapes.list.size(), 5u);
  EXPECT_EQ(shapes.list[0].name, "uniform");
  for (std::size_t k = 1; k < 5; ++k) EXPECT_NE(shapes.list[k].name, "running");
}

TEST(StartShapes, running_is_the_steady_state_of_the_nominal_heats) {
  const Shapes shapes = plates_and_their_air();
  const Eigen::VectorXd lost_W = shapes.exchange_W_per_K * shapes.list[1].rise_K;
  const double largest_K = shapes.heat_W().sum() / lost_W.sum();  // all heat goes out through the films
  EXPECT_GT(largest_K, 1.0);
  EXPECT_LT((largest_K * lost_W - shapes.heat_W()).norm(), 1e-8 * shapes.heat_W().norm());
}

TEST(StartShapes, stopped_is_what_is_left_of_it_after_a_quarter_of_an_hour) {
  const Shapes shapes = plates_and_their_air();
  const Eigen::VectorXd& running = shapes.list[1].rise_K;
  // C dT/dt = −K T exactly: T = V e^(−λ t) Vᵀ C T0 with K V = C V λ.
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(shapes.exchange_W_per_K,
                                                                        shapes.network.capacity_J_per_K);
  const Eigen::VectorXd amplitude = modes.eigenvectors().transpose() * shapes.network.capacity_J_per_K * running;
  const Eigen::VectorXd left =
      modes.eigenvectors() * (amplitude.array() * (-900.0 * modes.eigenvalues().array()).exp()).matrix();
  EXPECT_GT(left.minCoeff(), 0.0);
  EXPECT_LT((left - running).maxCoeff(), 0.0);
  const Eigen::VectorXd& stopped = shapes.list[2].rise_K;
  EXPECT_GT(stopped.minCoeff(), 0.0);
  EXPECT_LT((stopped - left / left.lpNorm<Eigen::Infinity>()).lpNorm<Eigen::Infinity>(), 0.03);
}

TEST(StartShapes, without_heat_or_without_a_way_out_there_is_no_running_and_no_stopped) {
  rom::Network cold = rom::tests::make_synthetic_network({3, 2, 2, true}, 5);
  cold.boundaries.operating.speed_rpm = 0.0;
  for (rom::HeatSource& source : cold.boundaries.sources) source.nominal_W = 0.0;
  for (const Shapes& shapes : {Shapes(cold), Shapes(rom::tests::make_synthetic_network({3, 2, 2, false}, 5))}) {
    for (const StartShape& shape : shapes.list) {
      EXPECT_NE(shape.name, "running");
      EXPECT_NE(shape.name, "stopped");
    }
  }
}

TEST(StartShapes, of_two_bodies_are_both_of_them_and_of_heats_that_hardly_warm_it_running_and_stopped_too) {
  rom::Network network = rom::tests::make_synthetic_network({1, 2, 2, true}, 5);
  for (rom::HeatSource& source : network.boundaries.sources) source.nominal_W *= 1e-3;
  const Shapes shapes(std::move(network));
  ASSERT_EQ(shapes.list.size(), 5U);
  EXPECT_EQ(shapes.list[1].name, "running");
  EXPECT_EQ(shapes.list[2].name, "stopped");
  EXPECT_EQ(Eigen::VectorXd(shapes.list[3].rise_K + shapes.list[4].rise_K), Eigen::VectorXd::Ones(5));
}

TEST(StartShapes, of_a_single_body_have_no_groups) {
  const Shapes shapes(rom::tests::make_single_node());
  for (const StartShape& shape : shapes.list) EXPECT_NE(shape.name, "body");
}

}  // namespace estimator_start_shapes_test
}  // namespace spindle_twin::correction::test
