#pragma once

#include <cstdint>
#include <limits>

namespace spindle_twin::correction {

enum class HealthState : std::uint8_t {
  good,       ///< its readings are used
  suspect,    ///< this reading is withheld, the channel is not judged yet
  failed,     ///< no reading is used until the fault has gone
  returning,  ///< the fault has gone; on probation, not used yet
};

/// Why a channel is not good.
enum class HealthFault : std::uint8_t {
  none,
  open,          ///< at or above open_above_K
  shorted,       ///< at or below short_below_K
  out_of_range,  ///< outside the channel's own range
  jump,          ///< left its course at once and stays away
  spikes,        ///< single readings far from its course, too many of them
  stuck,         ///< does not move while the model does
  drift,         ///< leaves slowly; stays failed until acknowledged
  swapped,       ///< shows another channel's temperature; stays failed until acknowledged
  implausible,   ///< the estimator has rejected it too often in a row
};

/// Limits of all detectors; times in model time. Valid: all positive, counts at least 1.
struct HealthLimits {
  // Electrical. A PT100 or PT1000 (IEC 60751) reads 850 degC at 3.9 times its nominal resistance: a broken wire leaves
  // the input at the end of its scale; a shorted one has hardly the 60 % of -100 degC. A PT1000 on an input for PT100
  // looks open, a PT100 on one for PT1000 shorted.
  double open_above_K = 673.15;
  double short_below_K = 173.15;

  // Jump and spike.
  double jump_K = 0.3;      ///< least deviation from its course that counts, besides 6 deviations of its own noise
  double jump_share = 1.0;  ///< and this share of what the model has moved during the last samples
  int spikes = 4;           ///< so many within spike_window_s fail the channel
  double spike_window_s = 600.0;

  // Stuck.
  double stuck_K = 0.1;            ///< the model has moved by this
  double stuck_resolutions = 8.0;  ///< and by so many steps of the channel's resolution
  double stuck_window_s = 120.0;   ///< within this time

  // Drift: evidence that a channel contradicts all others (leave_one_out.hpp).
  double drift_limit = 30.0;
  double drift_lead = 8.0;      ///< and so much more than of the next channel
  double drift_wait_s = 120.0;  ///< between two failures by drift
  int rejected = 2;             ///< updates in a row by then: it went too fast for a drift, and is implausible

  // Swapped.
  double swap_K = 0.3;      ///< rms by which a channel misses its own movement
  double swap_share = 0.1;  ///< its partner's it meets with so little of the square of that
  double swap_window_s = 300.0;
  double exchange_share = 0.5;     ///< of their misfits is left when two channels that drift together are exchanged;
  double exchange_alike = 0.65;    ///< the smaller misfit of the larger
  double exchange_evidence = 7.5;  ///< least of the second,
  double exchange_s = 120.0;       ///< and the first has risen from that so fast: a slow drift is no exchange

  // Return.
  double return_after_s = 300.0;                                     ///< without any sign of a fault
  double return_within_K = std::numeric_limits<double>::infinity();  ///< of its old course; finite where no estimator
                                                                     ///< learns the offset anew
  double return_offset_K = 0.2;  ///< 1σ of its offset then, and what it has moved off its old course besides
  int failures = 3;              ///< so many failures latch the channel until it is acknowledged
};

}  // namespace spindle_twin::correction
