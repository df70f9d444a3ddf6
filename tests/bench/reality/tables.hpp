#pragma once

#include <vector>

#include "tests/bench/reality/score_file.hpp"

namespace spindle_twin::bench {

/// A line per family.
void print_families(const std::vector<Family>& families, const Scores& scores, const Scores& present);

/// Every limit of the issue with what was reached; one that needs what was not run is said to be open. Returns how many
/// were missed.
int print_reality_limits(const std::vector<Family>& families, const Scores& scores, const Scores& present);

/// Limits that hold even for coarse models and a single run. Returns how many were missed.
int print_short_limits(const std::vector<Family>& families, const Scores& scores);

/// Where pairs were unplugged: how many of those that differ were found as exchanged, by family, and what is asked of
/// all families together. Returns how many limits were missed.
int print_pairs(const std::vector<Family>& families, const Scores& scores, const Unplugging& unplugging);

void print_run(const std::string& family, const RealityScore& score);

}  // namespace spindle_twin::bench
