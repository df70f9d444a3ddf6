#include "correction/identify/identify.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rom/read/input_error.hpp"
#include "rom/units.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::correction::test {
namespace identify_identify_test {

TEST(Identify, one_node_with_one_unknown_heat_has_the_closed_form) {
  // C dT/dt = -G T + e^θ q: dT/dθ = (q/G)(1 - e^(-t/τ)), and the posterior of one parameter is a sum of squares.
  const rom::Network network = rom::tests::make_single_node();
  IdentifyOptions options;
  options.priors = constant_priors();
  options.priors.film = 0.0;
  options.priors.contact = 0.0;
  options.correlation_s = 0.0;
  options.placements = 0;
  const Identification found =
      identify(network, sensor_places(network), rom::constant_schedule(network.boundaries, 600.0), options);
  constexpr double rise_K = 4.0, tau_s = 40.0, expansion_m_per_K = 2e-6;
  double information = 1.0 / (0.5 * 0.5);
  for (int k = 1; k <= 60; ++k) {
    const double sensitivity_K = rise_K * (1.0 - std::exp(-10.0 * k / tau_s));
    // Key point, part mean and node are the same place.
    information += 3.0 * sensitivity_K * sensitivity_K / (0.03 * 0.03);
  }
  ASSERT_EQ(found.parameters.size(), 1u);
  EXPECT_NEAR(found.parameters[0].estimate.deviation, 1.0 / std::sqrt(information), 1e-3 / std::sqrt(information));
  EXPECT_NEAR(found.prior_m, 0.5 * rise_K * expansion_m_per_K, 1e-9);
  EXPECT_NEAR(found.posterior_m, rise_K * expansion_m_per_K / std::sqrt(information), 1e-11);
  EXPECT_NEAR(found.growth_m, rise_K * expansion_m_per_K, 1e-9);
}

TEST(Identify, equals_what_the_filter_publishes_on_a_run_without_surprises) {
  const rom::Network network = plates();
  IdentifyOptions options;
  options.priors = constant_priors();
  options.offset_deviation_K = 0.02;
  options.floor_K = 0.03;
  options.placements = 0;
  const Identification found = identify(network, find_places(network, {"point 0", "point 2"}, "sensors"),
                                        rom::constant_schedule(network.boundaries, rom::seconds_per_hour), options);
  EstimatorOptions filter;
  filter.priors = options.priors;
  filter.offset_walk_K_per_root_hour = 0.0;
  filter.lag_deviation_s = 0.0;
  filter.curvature = 0.0;
  filter.sensors = key_point_sensors(network, filter);
  filter.sensors = {filter.sensors[0], filter.sensors[2]};
  Pair pair(network, filter);
  pair.cycle_s = 10.0;
  pair.run_until(rom::seconds_per_hour + 10.0);
  const double published_m = pair.estimator.deviations().deformations_m[0];
  EXPECT_NEAR(found.posterior_m, published_m, 0.03 * published_m);
  for (Eigen::Index i = 0; i < pair.estimator.parameters().count(); ++i) {
    const ParameterEstimate estimate = pair.estimator.estimate(i);
    EXPECT_NEAR(found.parameters[static_cast<std::size_t>(i)].estimate.deviation, estimate.deviation,
                0.05 * estimate.deviation)
        << found.parameters[static_cast<std::size_t>(i)].name;
  }
}

TEST(Identify, the_next_sensor_is_the_best_of_all_and_its_promise_holds) {
  const rom::Network network = plates();
  IdentifyOptions options;
  options.priors = constant_priors();
  options.placements = 2;
  const rom::Schedule schedule = rom::constant_schedule(network.boundaries, rom::seconds_per_hour);
  const std::vector<SensorPlace> one = find_places(network, {"point 0"}, "sensors");
  const Identification found = identify(network, one, schedule, options);
  ASSERT_EQ(found.placements.size(), 2u);
  EXPECT_LT(found.placements[0].deformation_m, found.posterior_m);
  EXPECT_LT(found.placements[1].deformation_m, found.placements[0].deformation_m);
  EXPECT_EQ(found.first_placement.front().deformation_m, found.placements[0].deformation_m);
  EXPECT_EQ(found.first_placement.size(), sensor_places(network).size());

  std::vector<SensorPlace> two = one;
  two.push_back(found.placements[0].place);
  options.placements = 0;
  const double with_it_m = identify(network, two, schedule, options).posterior_m;
  EXPECT_NEAR(with_it_m, found.placements[0].deformation_m, 1e-6 * with_it_m);
}

TEST(Identify, a_yardstick_knows_heats_joints_and_films_only_and_nothing_of_it_wanders) {
  rom::Network by_hand = spindle_twin::tests::small_network();
  by_hand.hand_written = true;
  for (const rom::Network& network : {plates(), by_hand}) {
    const ParameterModel parameters(network, constant_priors());
    ASSERT_GT(parameters.count(), 1);
    for (const Parameter& parameter : parameters.list()) {
      const bool factor = parameter.kind == ParameterKind::heat || parameter.kind == ParameterKind::contact ||
                          parameter.kind == ParameterKind::film;
      EXPECT_TRUE(factor || parameter.kind == ParameterKind::capacity) << parameter.name;
      EXPECT_EQ(parameter.walk_per_root_s, 0.0) << parameter.name;
      EXPECT_EQ(parameter.mean, 0.0) << parameter.name << ": as described";
    }
  }
}

TEST(Identify, one_place_has_one_sensor) {
  const rom::Network network = plates();
  EXPECT_THROW(find_places(network, {"point 0", "point 0"}, "--sensors"), rom::InputError);
}

TEST(Identify, unknown_places_are_refused_with_the_known_ones) {
  const rom::Network network = plates();
  try {
    find_places(network, {"nowhere"}, "--sensors");
    ADD_FAILURE();
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("point 0, "), std::string::npos) << error.what();
  }
}

}  // namespace identify_identify_test
}  // namespace spindle_twin::correction::test
