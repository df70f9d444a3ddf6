#include "rom/laws/evaluate.hpp"

#include <random>

#include "tests/rom/heap_calls.hpp"
#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {
namespace {

LawState warm_state() {
  LawState state;
  state[LawInput::first_K] = 318.0;
  state[LawInput::second_K] = 306.0;
  state[LawInput::pressure_Pa] = 1.3e6;
  state[LawInput::displacement_m] = -1e-6;
  state[LawInput::speed_rpm] = 5200.0;
  state[LawInput::flow_kg_per_s] = 0.03;
  state.load = 0.7;
  return state;
}

struct NamedLaw {
  std::string name;
  LawParameters parameters;
};

std::vector<NamedLaw> every_law() {
  BearingHeatLaw bearing;
  bearing.friction.pitch_diameter_m = 0.065;
  bearing.friction.static_rating_N = 20000.0;
  bearing.friction.contact_angle_rad = 0.436;
  bearing.preload = {18.0, 9.525e-3, 0.436, 250.0, 0.0, 0.0275, 0.0375};
  bearing.oil = lubricant_through(313.15, 32e-6, 373.15, 5.4e-6);
  CopperLaw copper;
  copper.copper.resistance_20_ohm = 0.35;
  copper.rated_current_A = 20.0;
  IronLaw iron{{}, 2.0, 3.0, 1.1, 6000.0};
  ContactLaw pressed;
  pressed.surfaces.conductivity_W_per_mK = 45.9;
  pressed.surfaces.roughness_m = 1.13e-6;
  pressed.surfaces.slope = 0.141;
  pressed.surfaces.young_Pa = 116e9;
  ContactLaw fitted = pressed;
  fitted.fit = InterferenceFit{0.037, 0.04, 0.05, 219e9, 0.3, 1.2e-5, 209e9, 0.269, 1.17e-5, 4e-6, 1e-12};
  ChannelLaw channel;
  channel.shape.hydraulic_diameter_m = 0.008;
  channel.shape.perimeter_m = 0.0251;
  channel.shape.length_m = 3.0;
  return {{"bearing heat", bearing},
          {"windage", WindageLaw{{0.04, 0.0005, 0.15}}},
          {"copper", copper},
          {"motor efficiency", MotorEfficiencyLaw{0.92, 9000.0}},
          {"iron", iron},
          {"contact under a pressure output", pressed},
          {"contact of a fit", fitted},
          {"channel", channel},
          {"cylinder", CylinderLaw{{RotationFormula::standard, 0.04}}},
          {"disc", DiscLaw{{RotationFormula::standard, 0.05}}},
          {"still cylinder", StillCylinderLaw{0.088}},
          {"air gap", AirGapLaw{{0.04, 0.0005, 1.17e-5}}},
          {"end winding", EndWindingLaw{{}, 0.04}},
          {"rings through the balls", BearingPathLaw{{18.0, 9.52e-3, 0.025}, 0.01}}};
}

/// Fourth-order difference of the value itself, so that inputs and their directions cannot be mixed up.
double difference(const PhysicalLaw& law, const LawState& at, LawInput input) {
  const double step = 1e-4 * std::abs(at[input]);
  const auto value = [&](double steps) {
    LawState state = at;
    state[input] += steps * step;
    return evaluate(law, state).value;
  };
  return (8.0 * (value(1.0) - value(-1.0)) - (value(2.0) - value(-2.0))) / (12.0 * step);
}

TEST(Evaluate, slopes_by_every_input_are_those_of_the_value) {
  for (const NamedLaw& item : every_law()) {
    const PhysicalLaw law{LawMode::standard, item.parameters};
    const LawState state = warm_state();
    const LawEvaluation found = evaluate(law, state);
    EXPECT_GT(found.value, 0.0) << item.name;
    EXPECT_EQ(found.flags, in_range) << item.name;
    for (std::size_t i = 0; i < law_inputs; ++i) {
      const auto input = static_cast<LawInput>(i);
      const double expected = difference(law, state, input);
      EXPECT_NEAR(found.by(input), expected, 1e-7 * std::abs(expected) + 1e-10 * found.value / std::abs(state[input]))
          << item.name << " by input " << i;
    }
  }
}

/// The whole range of every input, far beyond what a spindle sees, the others at two states.
TEST(Evaluate, every_law_is_continuous_in_value_and_slope_over_every_input) {
  constexpr std::array<std::pair<double, double>, law_inputs> ranges = {
      {{150.0, 700.0}, {150.0, 700.0}, {-1e7, 1e8}, {-2e-4, 2e-4}, {-40000.0, 40000.0}, {-0.5, 0.5}}};
  LawState slow = warm_state();
  slow[LawInput::speed_rpm] = 90.0;
  slow[LawInput::flow_kg_per_s] = 0.013;
  slow[LawInput::second_K] = 317.9;
  for (const NamedLaw& item : every_law()) {
    const PhysicalLaw law{LawMode::standard, item.parameters};
    for (const LawState& state : {warm_state(), slow}) {
      for (std::size_t i = 0; i < law_inputs; ++i) {
        const auto input = static_cast<LawInput>(i);
        const auto at = [&](double x) {
          LawState moved = state;
          moved[input] = x;
          return evaluate(law, moved);
        };
        const Jumps jumps = scan([&](double x) { return at(x).value; }, [&](double x) { return at(x).by(input); },
                                 ranges[i].first, ranges[i].second, 150);
        EXPECT_LT(jumps.value, 1e-6) << item.name << " by input " << i << " near " << jumps.at;
        EXPECT_LT(jumps.slope, 1e-6) << item.name << " by input " << i << " near " << jumps.at;
      }
    }
  }
}

TEST(Evaluate, anything_finite_gives_something_finite) {
  constexpr unsigned seed = 11;
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto laws = every_law();
  for (int k = 0; k < 2000; ++k) {
    LawState state;
    state[LawInput::first_K] = 1000.0 + 1000.0 * unit(engine);
    state[LawInput::second_K] = 1000.0 + 1000.0 * unit(engine);
    state[LawInput::pressure_Pa] = std::pow(10.0, 12.0 * unit(engine)) * unit(engine);
    state[LawInput::displacement_m] = 1e-2 * unit(engine);
    state[LawInput::speed_rpm] = std::pow(10.0, 6.0 * unit(engine)) * unit(engine);
    state[LawInput::flow_kg_per_s] = std::pow(10.0, 6.0 * unit(engine)) * unit(engine);
    state.load = 10.0 * unit(engine);
    for (const NamedLaw& item : laws) {
      const LawEvaluation found = evaluate({LawMode::standard, item.parameters}, state);
      EXPECT_TRUE(std::isfinite(found.value)) << item.name << ", seed " << seed << ", draw " << k;
      EXPECT_GE(found.value, 0.0) << item.name << ", seed " << seed << ", draw " << k;
      for (const double by : found.slope) EXPECT_TRUE(std::isfinite(by)) << item.name << ", draw " << k;
    }
  }
}

TEST(Evaluate, every_mode_is_finite_at_standstill_without_flow_or_pressure) {
  LawState still;
  still[LawInput::first_K] = still[LawInput::second_K] = room_K;
  for (const NamedLaw& item : every_law()) {
    for (const LawMode mode : {LawMode::standard, LawMode::as_published, LawMode::as_printed}) {
      const LawEvaluation found = evaluate({mode, item.parameters}, still);
      EXPECT_TRUE(std::isfinite(found.value)) << item.name;
      if (mode != LawMode::standard) continue;
      for (const double by : found.slope) EXPECT_TRUE(std::isfinite(by)) << item.name;
    }
    if (is_heat({LawMode::standard, item.parameters}) && item.name != "iron") {
      EXPECT_EQ(evaluate({LawMode::standard, item.parameters}, still).value, 0.0) << item.name;  // iron keeps its slip
    }
  }
}

TEST(Evaluate, heat_follows_the_temperature_with_the_sign_that_physics_gives) {
  const LawState state = warm_state();
  const auto laws = every_law();
  const LawEvaluation bearing = evaluate({LawMode::standard, laws[0].parameters}, state);
  EXPECT_LT(bearing.by(LawInput::second_K), 0.0);  // thinner oil and less preload
  EXPECT_GT(evaluate({LawMode::standard, laws[2].parameters}, state).by(LawInput::first_K), 0.0);
  EXPECT_GT(evaluate({LawMode::standard, laws[6].parameters}, state).by(LawInput::first_K), 0.0);
  EXPECT_LT(evaluate({LawMode::standard, laws[6].parameters}, state).by(LawInput::second_K), 0.0);
}

TEST(Evaluate, measured_current_takes_the_place_of_the_rated_one) {
  LawState state = warm_state();
  const PhysicalLaw copper{LawMode::standard, every_law()[2].parameters};
  const double by_load = evaluate(copper, state).value;
  state.current_A = 14.0;
  expect_close(evaluate(copper, state).value, by_load, "0.7 of 20 A");
}

TEST(Evaluate, measured_power_takes_the_place_of_the_rated_one) {
  LawState state = warm_state();
  const PhysicalLaw motor{LawMode::standard, MotorEfficiencyLaw{0.92, 9000.0}};
  expect_close(evaluate(motor, state).value, 0.08 * 0.7 * 9000.0, "by load");
  state.power_W = -5000.0;  // braking loses as much
  expect_close(evaluate(motor, state).value, 400.0, "measured");
}

TEST(Evaluate, takes_nothing_from_the_heap) {
  const auto laws = every_law();
  const LawState state = warm_state();
  double sum = 0.0;
  const long before = rom::tests::heap_calls();
  for (const NamedLaw& item : laws) {
    const PhysicalLaw law{LawMode::standard, item.parameters};
    for (int k = 0; k < 10; ++k) sum += evaluate(law, state).value;
  }
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace spindle_twin::rom::test
