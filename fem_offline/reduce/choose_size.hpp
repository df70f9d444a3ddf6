#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "fem_offline/reduce/reduce.hpp"
#include "fem_offline/reduce/tolerance.hpp"
#include "rom/network.hpp"

namespace spindle_twin::fem_offline {

struct TriedSize {
  int nodes = 0;
  Tolerance reached;  ///< size_choice_content of all histories err less, with limit_confidence
};

struct SizeChoice {
  rom::Network network;
  bool reached = false;              ///< false: no size keeps the margin; `network` is the one that comes nearest
  std::vector<MissedOutput> missed;  ///< of that network along the histories, against share_of_tolerance
  bool larger_possible = false;      ///< the basis has more than largest_size
  std::vector<TriedSize> tried;
};

/// Nodes at which the outputs missed with `nodes` may be within what is wanted, if errors fall with more of them as
/// usual. `missed` not empty, the one that errs most first.
int nodes_likely_enough(int nodes, const std::vector<MissedOutput>& missed);

/// Histories of the search: drawn for it alone, neither those of the snapshots nor the cases of the certificate.
inline constexpr int size_choice_histories = 64;
/// Share of all histories in which the search asks for it. The largest error of 64 histories is a single draw, and goes
/// up and down with the size; the third largest, which is a limit for nine tenths of them, falls with it.
inline constexpr double size_choice_content = 0.9;
/// Share of the tolerance that the search asks for, since other cases may be worse than its own.
inline constexpr double share_of_tolerance = 0.53;
inline constexpr int size_step = 10;
/// Of search and grow_until_kept: a cycle costs an edge computer as the square of it.
inline constexpr int largest_size = 480;

struct SizeSearch {
  Tolerance tolerance{};
  int histories = size_choice_histories;
};

/// Smallest network, in steps of size_step nodes, that keeps share_of_tolerance of the tolerance along
/// size_choice_content of all histories, by the limiting_rank of those of the search: up at the usual rate of errors
/// over the nested basis until one is enough, then by halves. All sizes have the points of part extremes of the first
/// one tried. Where no size up to largest_size keeps it, the network is the tried one with the smallest excess, and
/// `missed` names its outputs. `report` gets the stages of search and network.
SizeChoice choose_size(const AffineModel& model, const Reduction& reduction, const SizeSearch& search,
                       const ReduceOptions& options, const Progress& progress = {}, ReduceReport* report = nullptr);

/// Makes and judges the networks of grow_until_kept.
struct GrowSteps {
  std::function<rom::Network(int nodes)> network;
  /// Certifies it, and gives what its limits miss, the furthest first; `round` counts from 1.
  std::function<std::vector<MissedOutput>(rom::Network& network, int round)> certify;
};

/// The histories of the search are few: where the certificate of the network that it chose misses the tolerance, larger
/// ones follow, each of the size that nodes_likely_enough names for the one before and size_step more, until one misses
/// nothing or has `largest` nodes. Gives that which misses least, the first of those that miss nothing. `missed`: by
/// `first`.
rom::Network grow_until_kept(rom::Network first, std::vector<MissedOutput> missed, int largest, const GrowSteps& steps);

}  // namespace spindle_twin::fem_offline
