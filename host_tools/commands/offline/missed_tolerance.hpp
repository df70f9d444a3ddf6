#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "fem_offline/reduce/choose_size.hpp"

namespace spindle_twin::host_tools {

/// Exit code of `build` where a network was written that misses the tolerance.
inline constexpr int tolerance_missed = 3;

/// What to say of a network that misses `tolerance`: which outputs err by how much against what is wanted of them
/// (K, um; those that miss most first), and what would help: more nodes, the tolerance that this network keeps, the
/// small box where `box` is the whole. Several lines, without one at the end.
std::string missed_tolerance_text(const fem_offline::SizeChoice& choice, const fem_offline::Tolerance& tolerance,
                                  const std::string& box);

/// {kept, nodes_likely_enough, missed: [{output, worst, wanted, unit}]}; the last two only where it is not kept.
nlohmann::ordered_json missed_tolerance_json(const fem_offline::SizeChoice& choice);

/// The smallest tolerance of two digits that is not below `tolerance` and that this network keeps with the margin of
/// the search, as --tolerance takes it.
std::string kept_tolerance(const fem_offline::SizeChoice& choice, const fem_offline::Tolerance& tolerance);

}  // namespace spindle_twin::host_tools
