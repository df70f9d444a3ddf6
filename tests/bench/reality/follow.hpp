#pragma once

#include <cstdint>
#include <iosfwd>

#include "rom/network.hpp"
#include "tests/bench/reality/families.hpp"
#include "tests/bench/reality/machine_side.hpp"

namespace spindle_twin::bench {

constexpr double first_judged_s = 900.0;  ///< after the twin's start

/// How the daemon's cycle followed one truth. The nose is the published one; from first_judged_s on where nothing else
/// stands.
struct RealityScore {
  std::uint64_t seed = 0;
  double cycle_s = 0.0;
  double error_um = 0.0;      ///< rms
  double deviation_um = 0.0;  ///< rms of the published 1σ
  double inside = 0.0;        ///< share of the cycles with the truth inside ±2σ
  double open_um = 0.0;       ///< rms without correction
  double worst_um = 0.0;
  double failed_s = 0.0;         ///< longest time that a healthy sensor was failed or on probation, of the whole run
  double failed_at_end_s = 0.0;  ///< for how long a healthy sensor has been so at the end
  double degraded_s = 0.0;       ///< time that the twin was not `running`, of the whole run
  bool ends_degraded = false;
  unsigned quality_at_end = 0;
  unsigned faults = 0;         ///< all bits of the run
  double step_um_per_s = 0.0;  ///< fastest change of the published nose, of the whole run
  double rejected = 0.0;       ///< share of the readings taken to an update, of the whole run
  double back_s = 0.0;         ///< after the event: last moment of half an hour outside ±2σ; 0: never outside
  double at_15_min_um = 0.0;   ///< error
  double inside_from_1_min = 0.0;
  // Of an unplugged pair; not in score files.
  double pair_apart_K = 0.0;     ///< how far its places differ when it comes back
  double pair_swapped_s = -1.0;  ///< after that, when both are failed as swapped; below 0: never
};

/// `trace`: null, or where the time series goes as CSV.
RealityScore follow_reality(const rom::Network& network, const RealityTruth& truth, const Family& family,
                            double cycle_s, const Unplugging& unplugging, std::ostream* trace);

}  // namespace spindle_twin::bench
