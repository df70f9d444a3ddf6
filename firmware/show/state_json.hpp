#pragma once

#include <string>

#include "firmware/serve/register_map.hpp"
#include "firmware/show/shown_names.hpp"

namespace spindle_twin::firmware {

/// Every register but the command block as one JSON object on one line:
///   {"spindle": ..., "version": ..., "map_version": ..., "registers": {NAME: {"value": 1.5, "unit": "um"}, ...}, more}
/// Numbers are in the register's unit with the digits that it resolves, null where it holds "not present". Slots with
/// names are {"values": {"nose": 1.5, ...}} up to as many as the network has, others {"values": [...]}. A code has its
/// name beside it ("name", "names"), bits the names of those that are set ("set"). `more`:
/// members of what no register has, with their commas between them; empty: none. Allocates.
std::string state_json(const RegisterImage& image, const ShownNames& names, const std::string& more = "");

}  // namespace spindle_twin::firmware
