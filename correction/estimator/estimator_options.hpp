#pragma once

#include <vector>

#include "correction/estimator/measurement.hpp"
#include "correction/estimator/parameters.hpp"
#include "rom/option.hpp"

namespace spindle_twin::correction {

/// Options, not state: what a person may set, which is why it is open. `each` says what each means.
struct EstimatorOptions {  // NOLINT(public-members): a table of options, which `each` names one by one
  EstimatorPriors priors;
  double period_s = 10.0;
  double noise_K = 0.03;             ///< of the sensors that are made from key points, as the next two
  double offset_deviation_K = 0.02;  ///< key `offset_K`
  double lag_s = 0.0;
  double lag_deviation_s = 14.0;
  double floor_K = 0.03;  ///< 1σ, where the estimated one begins
  double floor_by_hand_K = 0.3;
  double floor_largest_K = 1.0;
  double curvature = 0.5;  ///< κ
  double correlation_s = 60.0;
  double offset_walk_K_per_root_hour = 0.002;
  double gate = 5.0;                     ///< an innovation beyond so many deviations is rejected
  double second_pass = 20.0;             ///< times as fast as they came (SecondPass)
  std::vector<EstimatorSensor> sensors;  ///< empty: one per key point of the network

  template <class Options, class Visit>
  static void each(Options& options, Visit&& visit) {
    using rom::zero_or_some;
    visit({"period_s", "between updates, 1 to 60", rom::between(1.0, 60.0)}, options.period_s);
    visit({"noise_K", "1 sigma of one reading, of sensors that say nothing of their own", noise_range_K},
          options.noise_K);
    visit({"offset_K", "1 sigma of a sensor's constant error: after a tare, 0.2 without one", offset_range_K},
          options.offset_deviation_K);
    visit({"lag_s", "first-order lag between temperature and reading, where its estimate begins", lag_range_s},
          options.lag_s);
    visit(zero_or_some("lag_deviation_s", "1 sigma of what it is wrong by; 0: it is as said", 120.0),
          options.lag_deviation_s);
    visit(zero_or_some("floor_K", "what the network itself is wrong at a sensor: least of the estimated floor", 10.0),
          options.floor_K);
    visit(zero_or_some("floor_by_hand_K", "the same of a hand-written network, which nobody could measure", 10.0),
          options.floor_by_hand_K);
    visit(zero_or_some("floor_largest_K", "most of the estimated floor", 100.0), options.floor_largest_K);
    visit(zero_or_some("curvature", "share that counts of what a straight line leaves out of the ln factors", 100.0),
          options.curvature);
    visit(zero_or_some("correlation_s", "errors closer than this count as one", 3600.0), options.correlation_s);
    visit(zero_or_some("offset_walk_K_per_root_hour", "how fast offsets wander", 1.0),
          options.offset_walk_K_per_root_hour);
    visit({"gate", "a reading further from the prediction than so many deviations is left out",
           rom::between(1.0, 1000.0)},
          options.gate);
    visit(zero_or_some("second_pass",
                       "readings since a start are gone through again so many times faster than they came", 100.0),
          options.second_pass);
  }
};

}  // namespace spindle_twin::correction
