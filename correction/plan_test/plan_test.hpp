#pragma once

#include <functional>
#include <vector>

#include "correction/plan_test/drive_cycle.hpp"
#include "correction/plan_test/test_worth.hpp"

namespace spindle_twin::correction {

/// What a temporary sensor adds, or a permanent one holds.
struct SensorWorth {
  std::size_t sensor = 0;  ///< index into the sensors of the options
  Worth worth;             ///< with it
};

inline constexpr double early_s = 1800.0;

struct TestPlan {
  DriveCycle cycle;
  Worth worth;                          ///< with the permanent sensors and the probe
  Worth early;                          ///< of the first early_s
  std::vector<SensorWorth> temporary;   ///< one after another, each the best of all that are left
  std::vector<SensorWorth> candidates;  ///< each alone beside the permanent ones, best first
  std::vector<SensorWorth> without;     ///< each sensor that is used left out of the test
  int evaluated = 0;                    ///< drive cycles
};

/// Looks for the drive cycle that leaves the smallest deviation in service with the permanent sensors: of
/// σ^0.9 σ_first^0.1, σ after the whole test and σ_first after its first `early_s`, as a test may be broken off.
/// Steps: the best of a few known forms in equal stages; each stage at each other speed, one after another, the best is
/// kept, until nothing is gained or twice round; each switching time half a stage earlier and later, likewise; then,
/// again and again until nothing is gained or 300 cycles were evaluated, stage by stage another speed in a part of it,
/// in all of it, and the switch to the next one 2 and 5 min earlier and later. A search of a family, no proof of an
/// optimum. The same result every time, whatever the number of threads. `progress`: after each batch of cycles, how
/// many were evaluated and the best deviation in m.
TestPlan plan_cycle(const TestWorth& worth, const DriveLimits& limits, const rom::Boundaries& boundaries,
                    const std::vector<std::size_t>& permanent, const std::function<void(int, double)>& progress = {});

/// Adds to the plan up to `count` temporary sensors of `candidates`, and what each sensor tells. `prediction`: of the
/// plan's cycle, with all sensors.
void plan_sensors(const TestWorth& worth, const TestPrediction& prediction, const std::vector<std::size_t>& permanent,
                  std::size_t candidates, int count, TestPlan& plan);

/// Options as `calibrate` has them, with one reading each interval_s that stands for those between.
CalibrateOptions thinned(CalibrateOptions options, double interval_s);

}  // namespace spindle_twin::correction
