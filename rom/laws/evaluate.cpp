#include "rom/laws/evaluate.hpp"

namespace spindle_twin::rom {
namespace {

using Number = Dual<static_cast<int>(law_inputs)>;

/// The inputs of an instant, each a direction of its own.
struct Inputs {
  explicit Inputs(const LawState& state)
      : first_K(variable(state, LawInput::first_K)),
        second_K(variable(state, LawInput::second_K)),
        pressure_Pa(variable(state, LawInput::pressure_Pa)),
        displacement_m(variable(state, LawInput::displacement_m)),
        speed_rpm(variable(state, LawInput::speed_rpm)),
        flow_kg_per_s(variable(state, LawInput::flow_kg_per_s)) {}

  static Number variable(const LawState& state, LawInput input) {
    return Number::variable(state[input], static_cast<int>(input));
  }
  Number mean_K() const { return 0.5 * (first_K + second_K); }

  Number first_K, second_K, pressure_Pa, displacement_m, speed_rpm, flow_kg_per_s;
};

/// One overload per law.
struct Evaluator {
  LawMode mode;
  const LawState& state;
  Inputs in;

  LawValue<Number> operator()(const BearingHeatLaw& law) const {
    const Number oil_K = in.mean_K();
    const auto nu = lubricant_viscosity_m2_per_s(mode, law.oil, oil_K);
    const auto axial_N =
        preload_N(law.preload, Number(in.first_K - law.assembly_K), Number(in.second_K - law.assembly_K),
                  Number(oil_K - law.assembly_K), in.displacement_m);
    auto heat = bearing_heat_W(mode, law.friction, nu.value, axial_N.value, law.radial_N, in.speed_rpm);
    heat.flags |= nu.flags;
    heat.flags |= axial_N.flags;
    return heat;
  }
  LawValue<Number> operator()(const WindageLaw& law) const {
    auto heat = gap_windage_W(mode, law.shape, in.speed_rpm, in.mean_K());
    const auto ends = end_windage_W(mode, law.shape, in.speed_rpm, in.mean_K());
    heat.value += ends.value;
    heat.flags |= ends.flags;
    return heat;
  }
  LawValue<Number> operator()(const CopperLaw& law) const {
    return copper_loss_W(mode, law.copper, Number(state.current_A.value_or(law.rated_current_A * state.load)),
                         in.first_K);
  }
  LawValue<Number> operator()(const MotorEfficiencyLaw& law) const {
    const double power_W = std::abs(state.power_W.value_or(law.rated_power_W * state.load));
    return {Number((1.0 - law.efficiency) * power_W), in_range};
  }
  LawValue<Number> operator()(const IronLaw& law) const {
    const Number frequency_Hz = law.pole_pairs / 60.0 * in.speed_rpm + law.slip_Hz;
    return iron_loss_W(mode, law.iron, frequency_Hz, core_flux_T(law.base_flux_T, law.base_speed_rpm, in.speed_rpm));
  }
  LawValue<Number> operator()(const ContactLaw& law) const {
    if (!law.fit) return contact_conductance_W_per_m2K(mode, law.surfaces, in.pressure_Pa, Number(0.0));
    const auto fit = fit_state(mode, *law.fit, Number(in.first_K - law.assembly_K),
                               Number(in.second_K - law.assembly_K), Number(in.speed_rpm * (std::numbers::pi / 30.0)));
    auto conductance = contact_conductance_W_per_m2K(mode, law.surfaces, fit.pressure_Pa, fit.gap_m);
    conductance.flags |= fit.flags;
    return conductance;
  }
  LawValue<Number> operator()(const ChannelLaw& law) const {
    return channel_film_W_per_m2K(mode, law.shape, law.liquid, in.flow_kg_per_s, in.first_K, in.second_K);
  }
  LawValue<Number> operator()(const CylinderLaw& law) const {
    return rotating_cylinder_W_per_m2K(mode, law.surface, in.speed_rpm, in.mean_K(), Number(in.first_K - in.second_K));
  }
  LawValue<Number> operator()(const DiscLaw& law) const {
    return rotating_disc_W_per_m2K(mode, law.surface, in.speed_rpm, in.mean_K(), Number(in.first_K - in.second_K));
  }
  LawValue<Number> operator()(const StillCylinderLaw& law) const {
    return still_cylinder_W_per_m2K(law.radius_m, in.mean_K(), Number(in.first_K - in.second_K));
  }
  LawValue<Number> operator()(const AirGapLaw& law) const {
    return air_gap_W_per_m2K(mode, law.gap, in.speed_rpm, in.first_K, in.second_K);
  }
  LawValue<Number> operator()(const EndWindingLaw& law) const {
    return end_winding_W_per_m2K(mode, law.winding, Number(in.speed_rpm * (std::numbers::pi / 30.0 * law.radius_m)));
  }
  LawValue<Number> operator()(const BearingPathLaw& law) const {
    auto path = bearing_conductance_W_per_K(mode, law.bearing, in.speed_rpm);
    path.value = path.value / law.area_m2;
    return path;
  }
};

}  // namespace

bool is_heat(const PhysicalLaw& law) {
  const LawParameters& parameters = law.parameters;
  return std::holds_alternative<BearingHeatLaw>(parameters) || std::holds_alternative<WindageLaw>(parameters) ||
         std::holds_alternative<CopperLaw>(parameters) || std::holds_alternative<MotorEfficiencyLaw>(parameters) ||
         std::holds_alternative<IronLaw>(parameters);
}

LawEvaluation evaluate(const PhysicalLaw& law, const LawState& state) {
  const LawValue<Number> result = std::visit(Evaluator{law.mode, state, Inputs(state)}, law.parameters);
  return {result.value.value, result.value.slope, result.flags};
}

}  // namespace spindle_twin::rom
