#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/bench/campaign/campaign.hpp"

namespace spindle_twin::bench {

struct SetUp {
  const char* name;
  int sensors;
  bool touch_off;
};
inline constexpr std::array<SetUp, 3> set_ups{{{"3", 3, false}, {"6", 6, false}, {"6 + touch-off", 6, true}}};

struct RunResult {
  std::uint64_t seed = 0;
  HeatErrors heats = HeatErrors::independent;
  double span_um = 0.0;
  Score open_loop;
  std::array<Score, set_ups.size()> paper;
  std::array<Score, set_ups.size()> estimator;
  std::array<double, set_ups.size()> bound_um{};
};

/// make_truth, or the same from an earlier campaign in the folder `cache` (empty: none).
Truth cached_truth(const std::string& cache, const fem_offline::AffineModel& model,
                   const correction::ParameterModel& parameters, std::uint64_t seed, HeatErrors heats);

void print_tables(const std::vector<RunResult>& results);

/// Prints every limit with what was reached. Returns how many were missed.
int print_limits(const std::vector<RunResult>& results);

}  // namespace spindle_twin::bench
