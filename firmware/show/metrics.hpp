#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/serve/register_map.hpp"
#include "firmware/show/plant_counts.hpp"
#include "firmware/show/shown_names.hpp"

namespace spindle_twin::firmware {

/// What the HTTP port counts of itself since the start.
struct HttpCounts {
  std::map<int, std::uint64_t> answers;  ///< by status
  std::uint64_t dropped = 0;             ///< clients that were too slow, or made room for others
  std::uint64_t connections = 0;         ///< open now
  std::uint64_t viewers = 0;             ///< of these, with an event stream
};

/// The registers of one spindle, for the time of a call.
struct ShownRegisters {
  const RegisterImage& image;
  const ShownNames& names;
  std::string_view name = {};  ///< of the spindle among several, as label `spindle_name`; empty: no such label
};

/// All registers but the command block in Prometheus' text format 0.0.4, in base units, then the counts. Names are
/// metric_name(); slots have their names as label, bits are one sample each (0 or 1) with the label `bit`; what is not
/// present has no sample. `plant`: null where nothing is published. Allocates.
std::string metrics_text(const std::vector<ShownRegisters>& spindles, const HttpCounts& counts,
                         const PlantCounts* plant = nullptr);

/// "nose_float32" in um: "spindle_twin_nose_meters"; counters end in _total.
std::string metric_name(const RegisterEntry& entry);

}  // namespace spindle_twin::firmware
