#include "firmware/cycle/forecast.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tests/firmware/support/machine.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace cycle_forecast_test {

/// The network with one deformation, wherever its nodes are: the mean of all.
double growth_m(const Machine& machine) { return machine.model.outputs.deformations_m[0]; }

void one_round(Forecast& forecast, const Machine& machine) {
  for (std::size_t k = 0; k < Forecast::strides; ++k) forecast.step(machine.model, machine.operating, machine.factors);
}

TEST(Forecast, says_what_the_same_inputs_then_make_of_the_spindle) {
  const rom::Network network = tests::small_network();
  Machine machine(network, 1.0);
  machine.advance(100.0);
  Forecast forecast(network, {900.0, 1e-6, 1}, runtime);
  EXPECT_TRUE(std::isnan(forecast.change_m()));
  one_round(forecast, machine);
  const double now_m = growth_m(machine);
  for (int n = 0; n < 900; ++n) machine.advance(1.0);
  EXPECT_NEAR(forecast.change_m(), growth_m(machine) - now_m, 0.002 * std::abs(growth_m(machine) - now_m));
}

TEST(Forecast, has_settled_when_the_growth_hardly_changes_in_any_ten_minutes) {
  const rom::Network network = tests::small_network();
  const Machine cold(network, 1.0);
  for (const double settled_m : {5e-7, 2e-6}) {
    Forecast forecast(network, {300.0, settled_m, 1}, runtime);
    one_round(forecast, cold);
    Machine later(network, 1.0);
    double expected_s = 0.0;
    double window_m = growth_m(later), before_m = window_m;
    for (double t_s = 300.0; t_s <= 14400.0; t_s += 300.0) {
      later.advance(300.0);
      const double change_m = std::max(std::abs(growth_m(later) - window_m), std::abs(growth_m(later) - before_m));
      if (change_m > settled_m) expected_s = t_s - 300.0;
      window_m = std::exchange(before_m, growth_m(later));
    }
    EXPECT_NEAR(forecast.settled_after_s(), expected_s, 300.0) << settled_m;
    EXPECT_GT(forecast.settled_after_s(), 0.0);
  }
  Forecast early(network, {300.0, 1e-6, 1}, runtime);
  for (std::size_t k = 1; k < Forecast::strides; ++k) early.step(cold.model, cold.operating, cold.factors);
  EXPECT_TRUE(std::isnan(early.settled_after_s())) << "the round is not over";
}

TEST(Forecast, begins_anew_from_the_present_after_each_round) {
  const rom::Network network = tests::small_network();
  Machine machine(network, 1.0);
  Forecast forecast(network, {600.0, 1e-6, 1}, runtime);
  one_round(forecast, machine);
  const double cold_m = forecast.change_m();
  for (int n = 0; n < 20; ++n) machine.advance(600.0);
  one_round(forecast, machine);
  EXPECT_LT(std::abs(forecast.change_m()), 0.1 * std::abs(cold_m));
}

TEST(Forecast, makes_a_stride_each_so_many_cycles) {
  const rom::Network network = tests::small_network();
  const Machine machine(network, 1.0);
  Forecast forecast(network, {300.0, 1e-6, 10}, runtime);
  for (int n = 0; n < 9; ++n) forecast.step(machine.model, machine.operating, machine.factors);
  EXPECT_TRUE(std::isnan(forecast.change_m()));
  forecast.step(machine.model, machine.operating, machine.factors);
  EXPECT_FALSE(std::isnan(forecast.change_m()));
}

}  // namespace cycle_forecast_test
}  // namespace spindle_twin::firmware
