#include "rom/integrate/coolant_outputs.hpp"

#include <gtest/gtest.h>

#include "rom/laws/evaluate.hpp"
#include "tests/rom/operating_values.hpp"
#include "tests/rom/shared_operator.hpp"
#include "tests/rom/synthetic_network.hpp"

namespace spindle_twin::rom::tests {
namespace coolant_outputs_test {

/// A bearing in the cold, whose oil is so thick that its heat falls by a hundredth with each tenth of a kelvin:
/// Newton's whole steps go to and fro between frozen oil and hot oil for ever.
TEST(SteadyTemperatures, are_found_where_whole_steps_of_newton_go_to_and_fro) {
  Network network = make_single_node();
  BearingHeatLaw bearing = BearingHeatLaw::example();
  bearing.preload.initial_N = 20.0;
  BoundLaw law;
  law.law.parameters = bearing;
  law.first = law.second = {0, -1, 300.0};
  network.boundaries.sources[0].physics = law;
  const auto shared = share(network);
  BoundaryValues values = operating_values(network);
  for (const double speed_rpm : {600.0, 1000.0, 1500.0, 2000.0, 2500.0, 3000.0}) {
    for (const double film_W_per_K : {2.5, 3.0, 4.0, 8.0, 25.0}) {
      values.laws.speed_rpm = speed_rpm;
      values.environment_K[0] = 240.0;
      values.conductance_W_per_m2K[0] = film_W_per_K / 0.5;
      const double steady_K = steady_temperatures_K(shared, values)[0];
      LawState state;
      state[LawInput::first_K] = state[LawInput::second_K] = steady_K;
      state[LawInput::speed_rpm] = speed_rpm;
      const double heat_W = evaluate(law.law, state).value;
      EXPECT_NEAR(film_W_per_K * (steady_K - 240.0), heat_W, 1e-8 * heat_W) << speed_rpm << " rpm " << film_W_per_K;
    }
  }
}

}  // namespace coolant_outputs_test
}  // namespace spindle_twin::rom::tests
