#include "rom/boundary_values/environments.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::rom {
namespace boundary_values_environments_test {

struct Surroundings {
  Boundaries boundaries;
  OperatingState state;
};

Surroundings surroundings(const std::vector<Environment>& environments) {
  Surroundings made{.boundaries = {}, .state = {}};
  made.boundaries.environments = environments;
  made.boundaries.reference_temperature_K = 293.0;
  made.state.environment_K = Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(environments.size()), 300.0,
                                                        299.0 + static_cast<double>(environments.size()));
  return made;
}

TEST(Environments, the_first_of_a_kind_counts) {
  const auto [boundaries, state] = surroundings({{"inlet", EnvironmentKind::coolant},
                                                 {"room", EnvironmentKind::ambient},
                                                 {"outdoors", EnvironmentKind::ambient},
                                                 {"second", EnvironmentKind::coolant}});
  EXPECT_EQ(first_environment_K(boundaries, EnvironmentKind::ambient, state), 301.0);
  EXPECT_EQ(first_environment_K(boundaries, EnvironmentKind::coolant, state), 300.0);
  EXPECT_EQ(rest_temperature_K(boundaries, state), 301.0);
}

TEST(Environments, without_ambient_a_spindle_ends_at_the_first_and_without_any_at_the_reference) {
  const auto cooled = surroundings({{"inlet", EnvironmentKind::coolant}});
  EXPECT_FALSE(first_environment_K(cooled.boundaries, EnvironmentKind::ambient, cooled.state));
  EXPECT_EQ(rest_temperature_K(cooled.boundaries, cooled.state), 300.0);
  const auto alone = surroundings({});
  EXPECT_EQ(rest_temperature_K(alone.boundaries, alone.state), 293.0);
}

}  // namespace boundary_values_environments_test
}  // namespace spindle_twin::rom
