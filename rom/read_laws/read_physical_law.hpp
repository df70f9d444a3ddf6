#pragma once

#include <string>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/read/strict_toml.hpp"

namespace spindle_twin::rom {

/// What a table `law` may name, each list in the network's order.
struct LawPlaces {
  std::vector<std::string> parts;
  std::vector<std::string> environments;
  std::vector<std::string> contact_pressures;
  std::vector<std::string> deformations;
};

/// What a law reads where its table does not say so: the two parts of a contact or gap, the wall and the surrounding of
/// a film, the circuit of its segments.
struct LawDefaults {
  int first_part = -1;
  int second_part = -1;
  int second_environment = -1;
  int circuit = -1;
};

/// A table `law` whose names are not known yet, and where its value belongs.
struct PendingLaw {
  TomlTable table;
  LawRole role = LawRole::heat;
  std::size_t index = 0;
  LawDefaults defaults;
};

/// The table `law = { kind = "...", ... }`: kind and numbers of rom/laws/law_list.hpp, written in mm, um, degrees and
/// degC; the places that it reads; the nominal temperatures of parts. `reference_K` is what the spindle had at assembly
/// unless the table says otherwise. Throws InputError with file, line, key and what is allowed.
BoundLaw read_physical_law(const PendingLaw& pending, const LawPlaces& places, double reference_K);

/// Its value at its nominal inputs and an operating state, which becomes the nominal value of source or conductance. An
/// InputError of `table` if it is negative or not finite.
double nominal_value(const TomlTable& table, const BoundLaw& law, const OperatingState& operating);

/// Whether `owner` has a table `law`; then nothing of `instead` may stand beside it.
bool has_law(const TomlTable& owner, const std::vector<std::string>& instead);
/// The table `law` of `owner` if there is one; then nothing of `instead` may stand beside it.
std::optional<TomlTable> optional_law(const TomlTable& owner, const std::vector<std::string>& instead);

}  // namespace spindle_twin::rom
