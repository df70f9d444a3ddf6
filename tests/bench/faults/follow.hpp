#pragma once

#include "firmware/cycle/snapshot.hpp"
#include "tests/bench/campaign/campaign.hpp"
#include "tests/bench/faults/faults.hpp"

namespace spindle_twin::bench {

/// How the daemon's cycle with its defaults followed one truth with one fault. Errors from the fault on.
struct Followed {
  Fault fault;
  double error_um = 0.0;      ///< rms
  double deviation_um = 0.0;  ///< rms of the published 1σ
  double largest_um = 0.0;
  double step_um = 0.0;             ///< largest change of the published nose in one cycle
  double raw_step_um = 0.0;         ///< of the prediction, before the slew limit
  double moving_s = -1.0;           ///< until the truth at the faulty sensor begins to move; -1: it does not
  double delay_s = -1.0;            ///< until the faulty channel failed; -1: never
  double withheld_s = -1.0;         ///< until its first reading was withheld
  double inside_until_found = 1.0;  ///< share of the cycles before that with the truth inside ±2σ
  double largest_until_found = 0.0;
  double returned_s = -1.0;  ///< after the fault's end; -1: not
  firmware::SensorFault named = firmware::SensorFault::none;
  int false_alarms = 0;  ///< failures of other channels, and of this one before the fault
  int withheld = 0;      ///< readings of channels without a fault that were withheld
};

struct FollowOptions {
  double cycle_s = 1.0;
  double resolution_K = 0.01;
  bool with_health = true;  ///< false: every reading is believed
  correction::EstimatorPriors priors;
};

/// Readings between the truth's samples lie on straight lines; noise is drawn anew for each.
Followed follow(const rom::Network& network, const Truth& truth, const Fault& fault, const FollowOptions& options);

}  // namespace spindle_twin::bench
