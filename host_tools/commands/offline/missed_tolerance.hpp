#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "fem_offline/reduce/choose_size.hpp"

namespace spindle_twin::host_tools {

/// Exit code of `build` where a network was written that misses the tolerance.
inline constexpr int tolerance_missed = 3;

/// Whether a network keeps a tolerance. What certifies it decides, as soon as it has limits; without any, the
/// histories of the size search, with their margin.
struct ToleranceVerdict {
  fem_offline::Tolerance tolerance;
  int nodes = 0;
  int limiting_cases = 0;    ///< cases behind the certificate's limits; 0: the search has judged
  bool margin_kept = false;  ///< of the search
  bool larger_possible = false;
  std::vector<fem_offline::MissedOutput> missed;  ///< empty: kept

  bool kept() const { return missed.empty(); }
};

/// `choice` as choose_size gave it for `tolerance`; `certificate` of its network, or an empty one.
ToleranceVerdict judge_tolerance(const fem_offline::SizeChoice& choice, const fem_offline::AffineModel& model,
                                 const rom::Certificate& certificate, const fem_offline::Tolerance& tolerance);

/// What to say of a network that misses its tolerance: which outputs err by how much against what is wanted of them
/// (K, um; those that miss most first), and what would help: more nodes, the tolerance that this network keeps, the
/// small box where `box` is the whole. Of one that keeps it by its certificate but not with the margin of the search:
/// that. Several lines, without one at the end; empty where there is nothing to say.
std::string tolerance_text(const ToleranceVerdict& verdict, const std::string& box);

/// {kept, judged_by, margin_kept, nodes_likely_enough, missed: [{output, error, wanted, unit}]}; the last two only
/// where it is not kept. `judged_by`: certificate or search.
nlohmann::ordered_json tolerance_json(const ToleranceVerdict& verdict);

/// The smallest tolerance of two digits that is not below the one wanted and that this network keeps by what judged it,
/// as --tolerance takes it.
std::string kept_tolerance(const ToleranceVerdict& verdict);

}  // namespace spindle_twin::host_tools
