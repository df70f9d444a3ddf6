#pragma once

#include <string>

#include "host_tools/network_files/schedule_course.hpp"
#include "rom/network.hpp"

namespace spindle_twin::host_tools {

struct SpiceTarget {
  std::string data_file;  ///< what ngspice shall write
  std::string file;       ///< the schedule's, for messages
  std::string remark;     ///< a line of the netlist's head, or nothing
};

/// The network as a netlist for ngspice: the voltage of a node is its rise over the reference temperature in K, a
/// current is heat in W, a capacitance J/K, a conductance W/K.
///   - C and what of K stays constant along the schedule: a mutual capacitor or resistor for every pair of nodes
///     (negative ones occur: the nodes are those of a projection, not of a grid); films to their environment's node
///   - conductances that follow the schedule (driven_terms.hpp): a Σ ± c cᵀ T as ± c (a (cᵀ T)), with a a voltage
///   - coolant circuits: the liquid's temperature handed on from segment to segment by controlled sources
///   - heat: current sources, piecewise linear with steps of 1 ms where the schedule jumps
///   - outputs as nodes: key_<name>, mean_<part> (rise in K), deformation_<name> (um), pressure_<name> (MPa)
/// The run starts at rest as `spindle-twin simulate` does, writes target.data_file (time and all outputs) and ends with
/// the schedule. Throws rom::InputError if a circuit's flow changes its sign along the schedule.
std::string spice_netlist(const rom::Network& network, const ScheduleCourse& course, const SpiceTarget& target);

}  // namespace spindle_twin::host_tools
