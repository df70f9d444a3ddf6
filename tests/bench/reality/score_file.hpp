#pragma once

#include <map>
#include <string>
#include <utility>

#include "tests/bench/reality/follow.hpp"

namespace spindle_twin::bench {

/// Scores by family and seed.
using Scores = std::map<std::pair<std::string, std::uint64_t>, RealityScore>;

/// One line per run; `heading` goes before it as comments.
void write_scores(const std::string& path, const std::string& heading, const Scores& scores);

/// Empty where there is no such file. Throws std::runtime_error for a line that it cannot read.
Scores read_scores(const std::string& path);

}  // namespace spindle_twin::bench
