#include "rom/laws/evaluate.hpp"

namespace spindle_twin::rom {
namespace {

using Number = Dual<static_cast<int>(law_inputs)>;

/// The input of an instant as a direction of its own.
Number variable(const LawState& state, LawInput input) {
  return Number::variable(state[input], static_cast<int>(input));
}

template <class... Laws>
constexpr bool all_are_laws(const std::variant<Laws...>*) {
  return (IsLaw<Laws> && ...);
}
static_assert(all_are_laws(static_cast<const LawParameters*>(nullptr)), "a law of the list lacks what IsLaw asks for");

}  // namespace

const LawTraits& traits_of(const PhysicalLaw& law) {
  return std::visit([]<class Law>(const Law&) -> const LawTraits& { return Law::traits; }, law.parameters);
}

bool is_heat(const PhysicalLaw& law) { return traits_of(law).role == LawRole::heat; }
bool is_channel(const PhysicalLaw& law) { return traits_of(law).role == LawRole::channel; }

bool reads_pressure(const PhysicalLaw& law) {
  return std::visit(
      [](const auto& parameters) {
        if constexpr (requires { parameters.reads_pressure(); }) return parameters.reads_pressure();
        return false;
      },
      law.parameters);
}

LawEvaluation evaluate(const PhysicalLaw& law, const LawState& state) {
  const LawInputs<Number> inputs{law.mode,
                                 state,
                                 variable(state, LawInput::first_K),
                                 variable(state, LawInput::second_K),
                                 variable(state, LawInput::pressure_Pa),
                                 variable(state, LawInput::displacement_m),
                                 variable(state, LawInput::speed_rpm),
                                 variable(state, LawInput::flow_kg_per_s)};
  const LawValue<Number> result =
      std::visit([&](const auto& parameters) { return parameters.value(inputs); }, law.parameters);
  return {result.value.value, result.value.slope, result.flags};
}

}  // namespace spindle_twin::rom
