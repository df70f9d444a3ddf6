#include "rom/laws/evaluate.hpp"

#include <bit>
#include <random>
#include <stdexcept>

#include "rom/laws/law_fields.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/laws/law_checks.hpp"

namespace spindle_twin::rom::test {
namespace laws_evaluate_test {

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

/// The example of every law there is, and a contact of a fit, which has inputs of its own.
std::vector<NamedLaw> every_law() {
  std::vector<NamedLaw> laws;
  for (const LawTraits& traits : law_traits) laws.push_back({std::string(traits.kind), *example_law(traits.kind)});
  ContactLaw fitted = ContactLaw::example();
  fitted.fit = InterferenceFit{0.037, 0.04, 0.05, 219e9, 0.3, 1.2e-5, 209e9, 0.269, 1.17e-5, 4e-6, 1e-12};
  laws.push_back({"contact of a fit", fitted});
  return laws;
}

/// The law of that name, as an integrator has it.
PhysicalLaw standard(const std::string& name) {
  for (const NamedLaw& law : every_law()) {
    if (law.name == name) return {LawMode::standard, law.parameters};
  }
  throw std::invalid_argument(name);
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

TEST(LawFlags, are_a_bit_each) {
  std::uint16_t taken = in_range;
  for (const LawFlag flag :
       {below_range, above_range, temperature_clamped, joint_open, thin_film, shape_out_of_range, undefined}) {
    EXPECT_TRUE(std::has_single_bit(static_cast<unsigned>(flag))) << flag;
    EXPECT_EQ(taken & flag, 0) << flag;
    taken = static_cast<std::uint16_t>(taken | flag);
  }
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

TEST(Evaluate, anything_finite_gives_something_finite_and_not_negative) {
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
    if (is_heat({LawMode::standard, item.parameters}) && item.name != "iron_loss") {
      EXPECT_EQ(evaluate({LawMode::standard, item.parameters}, still).value, 0.0) << item.name;  // iron keeps its slip
    }
  }
}

TEST(Evaluate, heat_follows_the_temperature_with_the_sign_that_physics_gives) {
  const LawState state = warm_state();
  EXPECT_LT(evaluate(standard("bearing_friction"), state).by(LawInput::second_K), 0.0);  // thinner oil, less preload
  EXPECT_GT(evaluate(standard("copper_loss"), state).by(LawInput::first_K), 0.0);
  EXPECT_GT(evaluate(standard("contact of a fit"), state).by(LawInput::first_K), 0.0);
  EXPECT_LT(evaluate(standard("contact of a fit"), state).by(LawInput::second_K), 0.0);
}

TEST(Evaluate, measured_current_takes_the_place_of_the_rated_one) {
  LawState state = warm_state();
  const PhysicalLaw copper = standard("copper_loss");
  const double by_load = evaluate(copper, state).value;
  state.current_A = 14.0;
  expect_close(evaluate(copper, state).value, by_load, "0.7 of 20 A");
}

TEST(Evaluate, measured_power_takes_the_place_of_the_rated_one) {
  LawState state = warm_state();
  const PhysicalLaw motor = standard("motor_efficiency");
  expect_close(evaluate(motor, state).value, 0.08 * 0.7 * 9000.0, "by load");
  state.power_W = -5000.0;  // braking loses as much
  expect_close(evaluate(motor, state).value, 400.0, "measured");
}

TEST(Evaluate, every_example_has_numbers_that_a_file_may_hold) {
  for (const LawTraits& traits : law_traits) {
    const LawParameters example = *example_law(traits.kind);
    EXPECT_EQ(law_fault(example), "") << traits.kind;
    const LawParameters read = law_from_numbers(std::string(traits.kind), law_numbers(example));
    EXPECT_EQ(evaluate({LawMode::standard, read}, warm_state()).value,
              evaluate({LawMode::standard, example}, warm_state()).value)
        << traits.kind;
  }
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

}  // namespace laws_evaluate_test
}  // namespace spindle_twin::rom::test
