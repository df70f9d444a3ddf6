#pragma once

#include <optional>
#include <string>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/file/rom.pb.h"
#include "rom/laws/law_fields.hpp"

/// A physical law out of a payload; used by decode_network.cpp only.
namespace spindle_twin::rom {

/// A law as it comes; only behind the message is it known whether there was one.
struct DecodedLaw {
  std::string kind;
  std::vector<NamedNumber> numbers;
};

/// Where nanopb puts what `message` does not hold itself.
void attach_physics(spindle_twin_rom_PhysicalLaw& message, DecodedLaw& decoded);

/// The law; for one that cannot be nothing, and in `fault` why.
std::optional<BoundLaw> decode_physics(const spindle_twin_rom_PhysicalLaw& message, const DecodedLaw& decoded,
                                       std::string& fault);

}  // namespace spindle_twin::rom
