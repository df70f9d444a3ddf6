#pragma once

#include <string>

#include "rom/boundary_values/schedule.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

/// What the capacitors of a netlist stand for: the network's nodes, as they are; or its modes (modal_form.hpp), which
/// couple only through what follows the schedule. The same outputs; with modes ngspice moves on where nodes are
/// many and films follow the schedule, but a mode's voltage is nothing that anybody could measure.
enum class SpiceStates { nodes, modes };

/// nodes up to 60 of them, modes beyond.
SpiceStates usual_states(const rom::Network& network);

struct SpiceTarget {
  std::string data_file;  ///< what ngspice shall write
  std::string file;       ///< the schedule's, for messages
  SpiceStates states = SpiceStates::nodes;
};

/// The network as a netlist for ngspice: the voltage of a node is its rise over the reference temperature in K, a
/// current is heat in W, a capacitance J/K, a conductance W/K.
///   - C and what of K stays constant along the schedule: a mutual capacitor or resistor for every pair of nodes
///     (negative ones occur: the nodes are those of a projection, not of a grid); films to their environment's node
///   - conductances that follow the schedule: g F Fᵀ T as F (g (Fᵀ T)), with g a voltage; of F only the columns that
///     carry more than 1e-10 of its largest
///   - of modes: a capacitor of 1 and a resistor each, and of conductances that follow the schedule what they differ by
///     from their mean; modes faster than 20 1/s have no capacitor, and follow at once
///   - coolant circuits: the liquid's temperature handed on from segment to segment by controlled sources
///   - heat: current sources, piecewise linear with steps of 1 ms where the schedule jumps
///   - outputs as nodes: key_<name>, mean_<part> (rise in K), deformation_<name> (um), pressure_<name> (MPa)
/// The run starts at rest as `spindle-twin simulate` does, writes target.data_file (time and all outputs) and ends with
/// the schedule. Throws rom::InputError if a circuit's flow changes its sign along the schedule.
std::string spice_netlist(const rom::Network& network, const rom::Schedule& schedule, const SpiceTarget& target);

}  // namespace spindle_twin::host_tools
