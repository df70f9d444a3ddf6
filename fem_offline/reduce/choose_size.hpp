#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fem_offline/reduce/reduce.hpp"
#include "fem_offline/reduce/tolerance.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

struct TriedSize {
  int nodes = 0;
  Tolerance reached;  ///< worst over the histories of the search
};

struct SizeChoice {
  rom::Network network;
  bool reached = false;              ///< false: no size keeps the margin; `network` is the one that comes nearest
  std::vector<MissedOutput> missed;  ///< of that network along the histories, against share_of_tolerance
  bool larger_possible = false;      ///< the model has more than largest_size
  std::vector<TriedSize> tried;
};

/// Nodes at which the outputs missed with `nodes` may be within what is wanted, if errors fall with more of them as
/// usual. `missed` not empty, the one that errs most first.
int nodes_likely_enough(int nodes, const std::vector<MissedOutput>& missed);

/// Histories of the search: drawn for it alone, neither those of the snapshots nor the cases of the certificate.
inline constexpr int size_choice_histories = 64;
/// Share of the tolerance that the search asks for, since other cases may be somewhat worse than its own.
inline constexpr double share_of_tolerance = 0.6;
inline constexpr int size_step = 10;
inline constexpr int largest_size = 320;

struct SizeSearch {
  Tolerance tolerance{};
  int histories = size_choice_histories;
};

/// Smallest network, in steps of size_step nodes, that keeps share_of_tolerance of the tolerance along the histories of
/// the search: up at the usual rate of errors over the nested basis until one is enough, then by halves. While it
/// searches, all sizes have the points of part extremes of the first; the chosen one gets its own. Where no size up to
/// largest_size keeps it, the network is the tried one with the smallest excess, and `missed` names its outputs.
/// `report` gets the stages of search and network.
SizeChoice choose_size(const AffineModel& model, const Reduction& reduction, const SizeSearch& search,
                       const ReduceOptions& options, const Progress& progress = {}, ReduceReport* report = nullptr);

}  // namespace spindle_twin::fem_offline
