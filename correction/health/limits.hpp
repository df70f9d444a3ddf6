#pragma once

#include <limits>

#include "rom/option.hpp"
#include "rom/units.hpp"

namespace spindle_twin::correction {

/// Limits of all detectors, each with where it comes from; times in model time. Options, not state, which is why it is
/// open. Valid: all positive, counts at least 1.
/// "Measured" is tests/bench/fault_campaign.
struct HealthLimits {  // NOLINT(public-members): a table of options, which `each` names one by one
  // Electrical. A PT100 or PT1000 (IEC 60751) reads 850 degC at 3.9 times its nominal resistance: a broken wire leaves
  // the input at the end of its scale; a shorted one has hardly the 60 % of -100 degC. A PT1000 on an input for PT100
  // looks open, a PT100 on one for PT1000 shorted.
  double open_above_K = 673.15;
  double short_below_K = 173.15;
  int electrical = 2;  ///< such readings in a row: one may be a disturbed telegram

  // Course. After a gap in the readings nothing is known of it: the model may err by jump_K in 30 s, at 0.01 K/s.
  double gap_s = 30.0;
  double gap_intervals = 5.0;  ///< or so many intervals of a channel that is read seldom

  // Jump and spike.
  double jump_K = 0.3;      ///< least deviation from its course that counts: 10 σ of a PT100 channel (0.03 K)
  double jump_share = 1.0;  ///< and this share of what the model has moved during the last samples: heats may be wrong
                            ///< by a factor of two in the seconds after a step of speed
  int outliers = 3;         ///< in a row make a jump: two may be one disturbance that meets two samples
  int spikes = 4;           ///< so many within spike_window_s fail the channel: a loose contact, no more bad luck
  double spike_window_s = 600.0;

  // Stuck. An amplitude of 0.1 K is three σ of a channel; eight steps of resolution cannot be missed by rounding.
  double stuck_K = 0.1;            ///< the model has moved by this
  double stuck_resolutions = 8.0;  ///< and by so many steps of the channel's resolution
  double stuck_window_s = 120.0;   ///< within this time; a place in a spindle that moves does so in minutes
  double stuck_evidence = 15.0;    ///< and noise would hide that once in e^15 times, as for drift_limit: four readings
                                   ///< may agree by chance
  double stuck_lag_s = 30.0;       ///< and so would a sensor show it that is later by this than it is said to be: twice
                                   ///< the deviation of the lags that the estimator reckons with

  // Drift and implausible readings: evidence that a channel contradicts all others (leave_one_out.hpp), −2 ln of a
  // ratio of likelihoods. 30 is odds of e^15; healthy channels reached 15 (measured), half of it.
  double drift_limit = 30.0;
  double drift_lead = 8.0;      ///< and so much more than of the next channel: odds of e^4 that it is this one
  double drift_wait_s = 120.0;  ///< between two such failures: twelve updates, in which the others' evidence settles
  int rejected = 2;             ///< updates in a row by then: it went too fast for a drift, and is implausible

  // What keeps a wrong model from being laid to a sensor.
  double settle_s = 900.0;       ///< after the start or a restart of the estimator drift is no verdict: it begins with
                                 ///< priors that the first 15 minutes contradict, whatever the sensors do
  double drift_least_s = 120.0;  ///< evidence that rose faster is no drift: of 10 K/h that is 0.3 K, a jump
  double second_opinion_s = 7200.0;  ///< a first verdict within this time loosens the estimate instead: two hours, as
                                     ///< long as a spindle takes to settle after a step
  double opinion_least_s = 300.0;    ///< an opinion so young is none: thirty updates
  double opinion_deviations = 2.0;   ///< a sensor fails by one only where it says by so many σ that the sensor is off
  double doubt_share = 0.5;          ///< of drift_limit: if half of the channels are above it the model is in doubt
  double review_s = 600.0;           ///< so young a verdict of drift is looked at again,
  double review_deviations = 3.0;    ///< and taken back where the misfit is within so many σ,
  double review_share = 0.5;         ///< and no more than this share of what it was, for return_after_s

  // Swap by movement (swap_detector.hpp), measured on 32 virtual spindles.
  double swap_limit = 30.0;       ///< −2 ln of the ratio of likelihoods, as drift_limit
  double swap_support = 8.0;      ///< does where a channel is blamed already: odds of e^4, as drift_lead
  double swap_K = 0.1;            ///< rms movement at which a gain is known to its own size: three times the noise
  double swap_fit = 0.3;          ///< each explains the partner's movement up to this share of its rms,
  double swap_floor = 0.07;       ///< and none better than this: own places are met to 0.04 to 0.16
  double swap_gain = 0.35;        ///< 1σ of ln of a gain: heats and films are unknown by a third
  double swap_memory_s = 3600.0;  ///< of what has been seen
  double swap_least_s = 180.0;    ///< three of the shortest scale
  bool read_swapped = true;       ///< each for the other's place, until acknowledged
  // Swap over a gap (course_over_gap.hpp).
  double replug_s = 1800.0;  ///< no older is a course that is held against what comes behind a gap. Chosen; measured by
                             ///< hand on the drives of its test, all six away for 28 min and put back right: one of
                             ///< 500 was taken for swapped, where the models' gains are wrong by a quarter
  // Swap by evidence (isolation.hpp), measured.
  double swap_share = 0.5;     ///< of their misfits is left when two channels that drift together are swapped;
  double swap_alike = 0.65;    ///< the smaller misfit of the larger
  double swap_evidence = 7.5;  ///< least of the second: a quarter of drift_limit,
  double swap_s = 120.0;       ///< and the first has risen from that so fast: a slow drift is no swap

  // Return.
  double return_after_s = 300.0;                                     ///< without any sign of a fault
  double return_within_K = std::numeric_limits<double>::infinity();  ///< of its old course; finite where no estimator
                                                                     ///< learns the offset anew
  double return_offset_deviation_K = 0.2;  ///< 1σ of its offset then, of an untared class A PT100 (IEC 60751: 0.15 K +
                                           ///< 0.002 t), and what it has moved off its old course besides
  int failures = 3;                        ///< so many failures latch the channel until it is acknowledged

  /// Those that a person may set.
  template <class Options, class Visit>
  static void each(Options& limits, Visit&& visit) {
    constexpr rom::Range kelvin = rom::between(1e-3, 100.0), seconds = rom::between(1.0, 86400.0),
                         ratio = rom::between(1e-3, 1000.0);
    visit(
        {"open_above_degC", "a broken wire reads at the upper end", rom::between(100.0, 1e4), false, rom::zero_degC_K},
        limits.open_above_K);
    visit({"short_below_degC", "a shorted one at the lower end", rom::between(-273.0, 0.0), false, rom::zero_degC_K},
          limits.short_below_K);
    visit({"jump_K", "least deviation of a reading from its course, besides 6 times its noise", kelvin}, limits.jump_K);
    visit({"jump_share", "and this share of what the model has moved in four readings", rom::between(0.0, 100.0)},
          limits.jump_share);
    visit({"spikes", "so many single outliers within spike_window_s fail a sensor", rom::between(1.0, 16.0)},
          limits.spikes);
    visit({"spike_window_s", "", seconds}, limits.spike_window_s);
    visit({"stuck_K", "no change while the model moves by this, and by 8 steps of resolution_K,", kelvin},
          limits.stuck_K);
    visit({"stuck_window_s", "within this time", seconds}, limits.stuck_window_s);
    visit({"drift_limit", "evidence that a sensor contradicts all others, as -2 ln of a likelihood ratio,", ratio},
          limits.drift_limit);
    visit({"drift_lead", "and so much more than of the next one", ratio}, limits.drift_lead);
    visit({"rejected", "updates rejected in a row by then: implausible, may return by itself", rom::between(1.0, 1e5)},
          limits.rejected);
    visit({"swap_K", "rms movement from which on a gain counts for telling swapped sensors", kelvin}, limits.swap_K);
    visit({"swap_limit", "evidence that two sensors are swapped, as drift_limit", ratio}, limits.swap_limit);
    visit({"read_swapped", "such sensors are read for each other's places until acknowledged; false: not at all"},
          limits.read_swapped);
    visit({"return_after_s", "without any sign of the fault", seconds}, limits.return_after_s);
    visit({"return_offset_K",
           "what its offset may then be, besides what it shows; a drift of up to 3 times this opens it first", kelvin},
          limits.return_offset_deviation_K);
    visit({"failures", "then it waits for an acknowledgement (command_sensors = 3)", rom::between(1.0, 1000.0)},
          limits.failures);
  }
};

}  // namespace spindle_twin::correction
