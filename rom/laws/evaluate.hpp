#pragma once

#include <array>

#include "rom/laws/law_list.hpp"

namespace spindle_twin::rom {

/// A heat source or a conductance of the network that follows physics.
struct PhysicalLaw {
  LawMode mode = LawMode::standard;
  LawParameters parameters;
};

/// What the law says of itself. Cycle-safe.
const LawTraits& traits_of(const PhysicalLaw& law);
/// Whether its value is a heat [W]; otherwise a conductance [W/m²K].
bool is_heat(const PhysicalLaw& law);
/// Whether it is the film of a coolant circuit's segments.
bool is_channel(const PhysicalLaw& law);
/// Whether it reads a contact pressure in place of temperatures.
bool reads_pressure(const PhysicalLaw& law);

/// Value [W or W/m²K], its slope by each LawInput in that input's unit, and LawFlag bits.
struct LawEvaluation {
  double value = 0.0;
  std::array<double, law_inputs> slope{};
  std::uint16_t flags = in_range;

  double by(LawInput input) const { return slope[static_cast<std::size_t>(input)]; }
};

/// For the right-hand side and its Jacobian inside a step: no heap, and no exception, since a variant of plain numbers
/// is never without a value. Finite for finite inputs in the standard mode.
LawEvaluation evaluate(const PhysicalLaw& law, const LawState& state);

}  // namespace spindle_twin::rom
