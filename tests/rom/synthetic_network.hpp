#pragma once

#include <cstdint>

#include "rom/network.hpp"

namespace spindle_twin::rom::tests {

struct SyntheticShape {
  int bodies = 4;            ///< plates of columns x rows nodes, one beside the other, a contact between neighbours
  int columns = 4;           ///< nodes of a plate towards its neighbour
  int rows = 4;              ///< nodes along each contact
  bool environments = true;  ///< coolant on the first plate, ambient on the last; false: insulated
};

/// A random heat network with everything that a reduced spindle has: a full (not diagonal) capacity matrix, contacts
/// and films of several columns, speed laws, and an air node of 0.3 J/K that makes it stiff against plates of some
/// 10 kJ/K. bodies · columns · rows + 1 nodes. Same seed, same network.
Network make_synthetic_network(const SyntheticShape& shape, std::uint64_t seed);

/// The same with a coolant circuit that wets one row of nodes of every plate, one after another; 0.03 kg/s at the
/// operating state.
Network make_network_with_circuit(const SyntheticShape& shape, std::uint64_t seed);

/// One node of 1000 J/K with a 25 W/K film (50 W/m2K on 0.5 m2) to an ambient of 300 K and one source of 100 W.
Network make_single_node();

}  // namespace spindle_twin::rom::tests
