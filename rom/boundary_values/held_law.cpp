#include "rom/boundary_values/held_law.hpp"

#include <algorithm>
#include <limits>

#include "rom/laws/speed_law.hpp"

namespace spindle_twin::rom {
namespace {

double nominal_K(const LawTemperature& temperature, const Eigen::VectorXd& environment_K) {
  return temperature.environment < 0 ? temperature.nominal_K : environment_K[temperature.environment];
}

bool has_heat_of(MeasuredDrive drive, const Boundaries& boundaries) {
  return std::any_of(boundaries.sources.begin(), boundaries.sources.end(), [&](const HeatSource& source) {
    return source.physics && traits_of(source.physics->law).measured == drive;
  });
}

}  // namespace

LawState nominal_state(const BoundLaw& bound, const LawDrive& drive, const Eigen::VectorXd& environment_K) {
  LawState state;
  state[LawInput::first_K] = nominal_K(bound.first, environment_K);
  state[LawInput::second_K] = nominal_K(bound.second, environment_K);
  state[LawInput::pressure_Pa] = bound.nominal_pressure_Pa;
  state[LawInput::displacement_m] = bound.displacement_sign * bound.nominal_displacement_m;
  state[LawInput::speed_rpm] = drive.speed_rpm;
  state[LawInput::flow_kg_per_s] = bound.circuit < 0 ? 0.0 : drive.flow_kg_per_s[bound.circuit];
  state.load = drive.load;
  state.current_A = drive.current_A;
  state.power_W = drive.power_W;
  return state;
}

double held_heat_W(const HeatSource& source, double reference_speed_rpm, double factor, const LawDrive& drive,
                   const Eigen::VectorXd& environment_K) {
  if (source.physics)
    return factor * evaluate(source.physics->law, nominal_state(*source.physics, drive, environment_K)).value;
  return factor * source.nominal_W * evaluate_speed_law(source.law, drive.speed_rpm, reference_speed_rpm, drive.load);
}

double held_conductance_W_per_m2K(const Conductance& conductance, double reference_speed_rpm, double factor,
                                  const LawDrive& drive, const Eigen::VectorXd& environment_K) {
  if (conductance.physics) {
    return factor * evaluate(conductance.physics->law, nominal_state(*conductance.physics, drive, environment_K)).value;
  }
  return factor * conductance.nominal_W_per_m2K *
         evaluate_speed_law(conductance.law, drive.speed_rpm, reference_speed_rpm, drive.load);
}

void set_machine(const OperatingState& state, LawDrive& drive) {
  drive.speed_rpm = state.speed_rpm;
  drive.load = state.load;
  drive.current_A = state.current_A;
  drive.power_W = state.power_W;
  drive.flow_kg_per_s = state.flow_kg_per_s;
}

std::vector<std::size_t> measured_heats(const Boundaries& boundaries) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    if (boundaries.sources[i].measured) places.push_back(i);
  }
  return places;
}

Eigen::VectorXd unread_heats_W(const Boundaries& boundaries) {
  return Eigen::VectorXd::Constant(static_cast<Eigen::Index>(measured_heats(boundaries).size()),
                                   std::numeric_limits<double>::quiet_NaN());
}

bool has_physics(const Boundaries& boundaries) {
  const auto physical = [](const auto& item) { return item.physics.has_value(); };
  return std::any_of(boundaries.sources.begin(), boundaries.sources.end(), physical) ||
         std::any_of(boundaries.conductances.begin(), boundaries.conductances.end(), physical);
}

bool follows_current(const Boundaries& boundaries) { return has_heat_of(MeasuredDrive::current, boundaries); }

bool reads_electricity(const HeatSource& source) {
  if (!source.physics) return false;
  const MeasuredDrive measured = traits_of(source.physics->law).measured;
  return measured == MeasuredDrive::current || measured == MeasuredDrive::power;
}

bool follows_power(const Boundaries& boundaries) { return has_heat_of(MeasuredDrive::power, boundaries); }

}  // namespace spindle_twin::rom
