#include "rom/laws/evaluate.hpp"
#include "tests/rom/laws/law_checks.hpp"

/// What it does to a body that its own heat follows its temperature.
namespace spindle_twin::rom::test {
namespace laws_feedback_test {

struct SteadyState {
  double temperature_K = 0.0;
  int iterations = 0;
};

/// T of (T − T_env)/R = heat(T) by Newton with the law's own slope; `both` puts the body at both temperatures of the
/// law.
SteadyState steady(const PhysicalLaw& law, LawState state, double resistance_K_per_W, double environment_K, bool both) {
  SteadyState found{environment_K, 0};
  for (; found.iterations < 50; ++found.iterations) {
    state[LawInput::first_K] = found.temperature_K;
    if (both) state[LawInput::second_K] = found.temperature_K;
    const LawEvaluation heat = evaluate(law, state);
    const double slope = heat.by(LawInput::first_K) + (both ? heat.by(LawInput::second_K) : 0.0);
    const double residual = (found.temperature_K - environment_K) / resistance_K_per_W - heat.value;
    const double step = residual / (1.0 / resistance_K_per_W - slope);
    found.temperature_K -= step;
    if (std::abs(step) < 1e-10) break;
  }
  return found;
}

/// Copper of P₂₀ at 20 °C behind R against 20 °C: the rise P₂₀ R grows by 1/(1 − a P₂₀ R), without limit at P₂₀ R =
/// 1/a.
TEST(Feedback, copper_amplifies_its_own_rise) {
  CopperLaw copper;
  copper.copper.resistance_20_ohm = 250.0 / 3.0;
  LawState state;
  state.current_A = 1.0;
  const SteadyState found = steady({LawMode::standard, copper}, state, 0.15, 293.15, false);
  EXPECT_NEAR((found.temperature_K - 293.15) / (250.0 * 0.15), 1.172849, 5e-7);
  EXPECT_LE(found.iterations, 2);  // linear in T: one step of Newton
  EXPECT_NEAR(1.0 / copper.copper.temperature_per_K, 254.5, 0.06);
}

BearingHeatLaw warm_bearing() {
  BearingHeatLaw bearing;
  bearing.friction.pitch_diameter_m = 0.065;
  bearing.friction.static_rating_N = 20000.0;
  bearing.friction.contact_angle_rad = 25.0 * std::numbers::pi / 180.0;
  bearing.preload = {18.0, 9.525e-3, bearing.friction.contact_angle_rad, 250.0, 0.0, 0.0275, 0.0375};
  bearing.oil = lubricant_through(313.15, 32e-6, 373.15, 5.4e-6);
  bearing.assembly_K = room_K;
  return bearing;
}

TEST(Feedback, bearing_settles_below_what_its_cold_heat_would_give_and_newton_finds_it_quadratically) {
  const PhysicalLaw law{LawMode::standard, warm_bearing()};
  LawState state;
  state[LawInput::first_K] = state[LawInput::second_K] = room_K;
  state[LawInput::speed_rpm] = 6000.0;
  const double cold_W = evaluate(law, state).value;
  const SteadyState found = steady(law, state, 0.2, room_K, true);
  state[LawInput::first_K] = state[LawInput::second_K] = found.temperature_K;
  EXPECT_NEAR(found.temperature_K - room_K, 0.2 * evaluate(law, state).value, 1e-9);
  EXPECT_LT(found.temperature_K - room_K, 0.75 * 0.2 * cold_W);
  EXPECT_LE(found.iterations, 7);
}

/// A rigid pair whose inner ring rises by half as much again as the outer one: the preload grows to 2.7 times, yet
/// thinner oil wins, and heat falls with temperature.
TEST(Feedback, viscosity_outweighs_thermal_preload) {
  const BearingHeatLaw bearing = warm_bearing();
  const auto heat = [&](const auto& T) {
    using Scalar = std::decay_t<decltype(T)>;
    const auto axial_N = preload_N(bearing.preload, Scalar(0.5 * (T - room_K)), Scalar(0.0), Scalar(0.0), Scalar(0.0));
    const auto nu = lubricant_viscosity_m2_per_s(LawMode::standard, bearing.oil, T);
    return bearing_heat_W(LawMode::standard, bearing.friction, nu.value, axial_N.value, 0.0, Scalar(6000.0)).value;
  };
  EXPECT_NEAR(slope(heat, 313.15), -1.21, 0.005);
  EXPECT_NEAR(preload_N(bearing.preload, 6.5, 0.0, 0.0, 0.0).value / 250.0, 2.66, 0.01);
}

}  // namespace laws_feedback_test
}  // namespace spindle_twin::rom::test
