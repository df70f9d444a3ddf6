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
  double heat_mean = 0.0;    ///< of the hidden ln factors of the heats
  double heat_spread = 0.0;  ///< their deviation from that mean, rms
  Score open_loop;
  std::array<Score, set_ups.size()> paper;            ///< as published: the model's state is kept
  std::array<Score, set_ups.size()> paper_corrected;  ///< with our correction of the state
  std::array<Score, set_ups.size()> estimator;
  std::array<double, set_ups.size()> bound_um{};
};

/// make_truth of a run as usual but for `speed_exponent` (Conditions), or the same from an earlier campaign in the
/// folder `cache` (empty: none).
Truth cached_truth(const std::string& cache, const fem_offline::AffineModel& model,
                   const correction::ParameterModel& parameters, std::uint64_t seed, HeatErrors heats,
                   double speed_exponent = 0.0);

/// Mean and spread of the hidden ln factors of the heats.
void describe_heats(const correction::ParameterModel& parameters, const Truth& truth, RunResult& result);

void print_tables(const std::vector<RunResult>& results);

struct ConditionRuns {
  int light = 4;  ///< runs of a condition
  int heavy = 2;  ///< of one with many times the steps
  int threads = 2;
  std::uint64_t first_seed = 0;
};

/// Lagging sensors, standstill, wrong speed laws, updates every second and a whole day, each with the same virtual
/// spindles. Returns in how many of them less than 90 % of the truth lies within +-2 sigma.
int print_conditions(const rom::Network& network, const fem_offline::AffineModel& model,
                     const correction::EstimatorOptions& options, const ConditionRuns& runs);

/// Prints every limit with what was reached. Returns how many were missed.
int print_limits(const std::vector<RunResult>& results);

}  // namespace spindle_twin::bench
