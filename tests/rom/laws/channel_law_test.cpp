#include "rom/laws/channel_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::rom {
namespace laws_channel_law_test {

TEST(ChannelLaw, fast_flow_is_the_plain_film) { EXPECT_NEAR(channel_W_per_m2K(548.0, 0.05, 1e9), 548.0, 548.0 * 1e-7); }

TEST(ChannelLaw, slow_flow_takes_all_it_can_carry) {
  const double area_m2 = 0.05;
  for (const double flow_W_per_K : {1e-2, 1e-9, 1e-300, 5e-324}) {
    EXPECT_NEAR(channel_W_per_m2K(548.0, area_m2, flow_W_per_K) * area_m2, flow_W_per_K, 1e-12 * flow_W_per_K);
  }
  EXPECT_EQ(channel_W_per_m2K(548.0, area_m2, 0.0), 0.0);
  EXPECT_EQ(channel_W_per_m2K(0.0, area_m2, 0.0), 0.0);
  EXPECT_EQ(channel_W_per_m2K(0.0, area_m2, 10.0), 0.0);
}

TEST(ChannelLaw, equals_the_exponential_of_a_channel_with_a_uniform_wall) {
  // hA = 200 W/K at W = 69.3 W/K.
  const double flow_W_per_K = 69.3, area_m2 = 0.4;
  EXPECT_NEAR(channel_W_per_m2K(500.0, area_m2, flow_W_per_K) * area_m2, flow_W_per_K * (1.0 - std::exp(-200.0 / 69.3)),
              1e-12 * flow_W_per_K);
}

TEST(ChannelLaw, a_flow_of_one_is_a_flow_as_any_other) {
  for (const double flow_W_per_K : {0.5, 1.0, 2.0}) {
    EXPECT_NEAR(channel_W_per_m2K(4.0, 0.25, flow_W_per_K) * 0.25, flow_W_per_K * (1.0 - std::exp(-1.0 / flow_W_per_K)),
                1e-15);
  }
}

TEST(ChannelLaw, acts_on_segments_only_and_knows_no_direction) {
  Boundaries boundaries;
  Conductance film;
  film.nominal_W_per_m2K = 300.0;
  film.area_m2 = 0.1;
  film.environment = 0;
  boundaries.conductances = {film, film};
  boundaries.environments = {{"coolant", EnvironmentKind::coolant}};
  boundaries.circuits = {{"jacket", 0, 4000.0, {1}}};
  boundaries.reference_speed_rpm = 1000.0;
  boundaries.operating.environment_K = Eigen::VectorXd::Constant(1, 293.15);
  boundaries.operating.flow_kg_per_s = Eigen::VectorXd::Constant(1, 0.01);
  BoundaryValues forwards = rom::make_boundary_values(boundaries), backwards = forwards;
  OperatingState state = boundaries.operating;
  rom::evaluate_boundaries(boundaries, state, rom::no_correction(boundaries), forwards);
  state.flow_kg_per_s *= -1.0;
  rom::evaluate_boundaries(boundaries, state, rom::no_correction(boundaries), backwards);
  EXPECT_EQ(forwards.conductance_W_per_m2K[0], 300.0);
  EXPECT_NEAR(forwards.conductance_W_per_m2K[1] * 0.1, 40.0 * (1.0 - std::exp(-30.0 / 40.0)), 1e-12);
  EXPECT_EQ(forwards.conductance_W_per_m2K, backwards.conductance_W_per_m2K);
  EXPECT_EQ(forwards.coolant_W_per_K[0], 40.0);
  EXPECT_EQ(backwards.coolant_W_per_K[0], -40.0);
}

}  // namespace laws_channel_law_test
}  // namespace spindle_twin::rom
