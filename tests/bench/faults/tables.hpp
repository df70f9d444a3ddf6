#pragma once

#include <cstdint>
#include <vector>

#include "tests/bench/faults/follow.hpp"

namespace spindle_twin::bench {

/// All runs of one virtual spindle: the healthy one, then per sensor the withdrawn one before its faults.
struct SpindleRuns {
  std::uint64_t seed = 0;
  Followed unwatched;  ///< the healthy one, every reading believed
  std::vector<Followed> followed;
};

void print_run(std::uint64_t seed, const Followed& run);

/// Prints tables and limits. Returns how many limits were missed.
int print_tables(const std::vector<SpindleRuns>& all, double cycle_s);

/// The table of sensors that were exchanged from the start. Returns how many healthy channels failed.
int print_exchanges(const std::vector<SpindleRuns>& all);

}  // namespace spindle_twin::bench
