#pragma once

#include "rom/network.hpp"

namespace spindle_twin::rom::tests {

/// A synthetic network of 65 nodes with a coolant circuit, in which every kind of physical law stands once: bearing
/// heat (with a deformation output), windage, copper, efficiency and iron as sources; a contact of a fit, one under a
/// pressure output, an air gap, a path through the balls, end windings, a cylinder, a disc, a still cylinder, and the
/// film of every segment. Same seed, same network.
Network make_network_with_laws();

/// One node of 1000 J/K with 25 W/K to an ambient of 300 K and copper loss of three phases of 0.4 ohm at 20 °C and 10
/// A.
Network make_copper_node();

}  // namespace spindle_twin::rom::tests
