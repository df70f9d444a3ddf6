#pragma once

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

// A network's laws where temperatures, pressures and displacements are not known: at their nominal values, with
// environments, speed, load and flow as they are. All cycle-safe.

/// What `bound` reads, with nominal values for everything that only a network's state can tell.
LawState nominal_state(const BoundLaw& bound, const LawDrive& drive, const Eigen::VectorXd& environment_K);

/// factor · nominal · scale(speed, load), or factor · physics at its nominal inputs. [W]
double held_heat_W(const HeatSource& source, double reference_speed_rpm, double factor, const LawDrive& drive,
                   const Eigen::VectorXd& environment_K);

/// Likewise, of a circuit's segment the film itself. [W/m²K]
double held_conductance_W_per_m2K(const Conductance& conductance, double reference_speed_rpm, double factor,
                                  const LawDrive& drive, const Eigen::VectorXd& environment_K);

/// Speed, load, flow and the machine's signals of an operating state; factors are left alone. No allocation where the
/// flows have their size.
void set_machine(const OperatingState& state, LawDrive& drive);

/// Places of the sources whose watts are measured, in the order of OperatingState::heat_W. Allocates.
std::vector<std::size_t> measured_heats(const Boundaries& boundaries);

/// OperatingState::heat_W while none is known: NaN for each measured heat. Allocates.
Eigen::VectorXd unread_heats_W(const Boundaries& boundaries);

bool has_physics(const Boundaries& boundaries);

/// Whether any heat reads the motor's current (copper_loss) or its power (motor_efficiency).
bool follows_current(const Boundaries& boundaries);
bool follows_power(const Boundaries& boundaries);
/// Whether this one reads either of them.
bool reads_electricity(const HeatSource& source);

}  // namespace spindle_twin::rom
