#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <variant>

#include "rom/laws/air_gap.hpp"
#include "rom/laws/bearing_friction.hpp"
#include "rom/laws/bearing_preload.hpp"
#include "rom/laws/contact_conductance.hpp"
#include "rom/laws/coolant_channel.hpp"
#include "rom/laws/interference_fit.hpp"
#include "rom/laws/motor_loss.hpp"
#include "rom/laws/rotating_surface.hpp"
#include "rom/laws/windage.hpp"

namespace spindle_twin::rom {

/// What a law may depend on and an integrator differentiates by. `first` and `second` are the mean temperatures of two
/// parts, or of a part and what it gives its heat to; each law below says which.
enum class LawInput : std::size_t { first_K, second_K, pressure_Pa, displacement_m, speed_rpm, flow_kg_per_s };
constexpr std::size_t law_inputs = 6;

/// One instant, as a law sees it.
struct LawState {
  std::array<double, law_inputs> inputs{};
  double load = 0.0;                ///< fraction of the rated load
  std::optional<double> current_A;  ///< measured phase current, rms; otherwise rated current times load
  std::optional<double> power_W;    ///< measured electrical power; otherwise rated power times load

  double& operator[](LawInput input) { return inputs[static_cast<std::size_t>(input)]; }
  double operator[](LawInput input) const { return inputs[static_cast<std::size_t>(input)]; }
};

/// Friction of one row [W]: first = inner ring, second = outer ring, displacement = axial closing of the rings.
/// Lubricant and balls have the mean temperature of both rings.
struct BearingHeatLaw {
  BearingFriction friction;
  BearingPreload preload;
  Lubricant oil;
  double radial_N = 0.0;
  double assembly_K = 293.15;
};

/// Air friction of gap and ends [W]: first = rotor, second = stator; air at their mean.
struct WindageLaw {
  WindageShape shape;
};

/// [W]: first = winding.
struct CopperLaw {
  CopperLoss copper;
  double rated_current_A = 0.0;
};

/// The motor's loss as a whole [W]: (1 − efficiency) |P|, P its electrical power. Depends on no temperature.
struct MotorEfficiencyLaw {
  double efficiency = 0.9;
  double rated_power_W = 0.0;
};

/// [W]: f = pole_pairs n/60 + slip. Depends on no temperature.
struct IronLaw {
  IronLoss iron;
  double pole_pairs = 1.0;
  double slip_Hz = 0.0;
  double base_flux_T = 1.0;
  double base_speed_rpm = 1e9;
};

/// [W/m²K]: first = inner body, second = outer body of the fit; without a fit the pressure input decides.
struct ContactLaw {
  ContactSurfaces surfaces;
  std::optional<InterferenceFit> fit;
  double assembly_K = 293.15;
};

/// [W/m²K]: first = wall, second = liquid. The channel law makes the segment's effective value of it.
struct ChannelLaw {
  ChannelShape shape;
  Liquid liquid;
};

/// [W/m²K]: first = surface, second = air around it.
struct CylinderLaw {
  RotatingSurface surface;
};
struct DiscLaw {
  RotatingSurface surface;
};
struct StillCylinderLaw {
  double radius_m = 0.0;
};

/// [W/m²K], wall to wall: first = rotor, second = stator.
struct AirGapLaw {
  AirGap gap;
};

/// [W/m²K]: speed of the rotor's surface at radius_m.
struct EndWindingLaw {
  EndWinding winding;
  double radius_m = 0.0;
};

/// [W/m²K] over area_m2: rings through the balls.
struct BearingPathLaw {
  BearingConductance bearing;
  double area_m2 = 1.0;
};

using LawParameters =
    std::variant<BearingHeatLaw, WindageLaw, CopperLaw, MotorEfficiencyLaw, IronLaw, ContactLaw, ChannelLaw,
                 CylinderLaw, DiscLaw, StillCylinderLaw, AirGapLaw, EndWindingLaw, BearingPathLaw>;

/// A heat source or a conductance of the network that follows physics.
struct PhysicalLaw {
  LawMode mode = LawMode::standard;
  LawParameters parameters;
};

/// Whether its value is a heat [W]; otherwise a conductance [W/m²K].
bool is_heat(const PhysicalLaw& law);

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
