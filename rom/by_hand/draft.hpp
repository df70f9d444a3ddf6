#pragma once

#include <string>
#include <vector>

#include "rom/network.hpp"
#include "rom/read/names.hpp"
#include "rom/read/strict_toml.hpp"
#include "rom/read_laws/read_physical_law.hpp"
#include "rom/units.hpp"

/// The pieces of read_by_hand, one function per group of tables; used there only. All throw InputError.
namespace spindle_twin::rom {

/// The network as far as it is read, with the names that its tables may use.
struct Draft {
  Network network;
  Names nodes{"node"};
  Names surroundings{"surrounding"};
  Names conductances{"contact or film"};
  std::vector<TomlTable> node_tables;            ///< for errors that show later
  std::vector<std::string> parts;                ///< in the order of their first node
  std::vector<std::vector<std::size_t>> linked;  ///< per node, the nodes that it exchanges heat with
  std::vector<bool> cooled;                      ///< per node, whether a film leads to a surrounding
  std::vector<PendingLaw> laws;                  ///< read last, when all that they may name is known

  Eigen::Index size() const { return static_cast<Eigen::Index>(network.nodes.size()); }
};

inline constexpr double metre_per_mm = 1e-3;
inline constexpr double square_metre_per_mm2 = 1e-6;
inline constexpr Range area_mm2{0.0, 1e9, true, false};
/// Where W/K are given instead of W/m²K: then the numbers are the same.
inline constexpr double area_of_W_per_K_m2 = 1.0;

/// [[node]]: names, places and capacities.
void read_nodes(const TomlTable& root, Draft& draft);

/// [[surrounding]] and [operating].
void read_operating(const TomlTable& root, Draft& draft);

/// [[conduction]], [[contact]], [[gap_film]], [[film]], [[coolant_circuit]].
void read_exchanges(const TomlTable& root, Draft& draft);

/// [[heat]], [[key_point]], [[deformation]], [[contact_pressure]], and mean and maximum of each part.
void read_inputs_and_outputs(const TomlTable& root, Draft& draft);

/// The tables `law` of heats, contacts, films and circuits.
void read_laws(Draft& draft);

/// Every node must reach every other, and heat must reach a surrounding.
void check_connected(const TomlTable& root, const Draft& draft);

}  // namespace spindle_twin::rom
