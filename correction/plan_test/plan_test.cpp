#include "correction/plan_test/plan_test.hpp"

#include <algorithm>
#include <cmath>
#include <future>
#include <thread>

#include "correction/plan_test/vary_cycle.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double usual_stage_s = 1200.0;
constexpr std::size_t most_stages = 8, least_stages = 4;
constexpr int rounds = 2;
constexpr double worth_while = 0.998;      // of the best so far: less is no gain
constexpr double worth_refining = 0.9995;  // the same of small moves
constexpr int most_cycles = 300;           // from which on nothing is refined
constexpr double early_weight = 0.1;       // of the first part of a test

/// Cycles with their worth, evaluated in threads, remembered.
class CycleSearch {
 public:
  CycleSearch(const TestWorth& worth, const DriveLimits& limits, const rom::Boundaries& boundaries,
              const std::vector<std::size_t>& permanent, const std::function<void(int, double)>& progress)
      : worth_(worth), limits_(limits), boundaries_(boundaries), progress_(progress) {
    taken_.sensors = permanent;
  }

  struct Found {
    Worth whole, early;

    double score_m() const {
      return std::pow(whole.with_sensors_m, 1.0 - early_weight) * std::pow(early.with_sensors_m, early_weight);
    }
  };

  /// Takes the best of these where it is better than what was.
  bool improve(const std::vector<DriveCycle>& cycles, double enough = worth_while) {
    bool better = false;
    const std::size_t at_once = std::max(1u, std::thread::hardware_concurrency());
    for (std::size_t first = 0; first < cycles.size(); first += at_once) {
      std::vector<std::future<Found>> running;
      const std::size_t end = std::min(cycles.size(), first + at_once);
      for (std::size_t i = first; i < end; ++i) {
        running.push_back(std::async(std::launch::async, [this, &cycle = cycles[i]] {
          const TestPrediction test = worth_.linearise(schedule_of(cycle, limits_, boundaries_));
          TakenReadings early = taken_;
          early.until_s = early_s;
          return Found{worth_.of(test, taken_), worth_.of(test, early)};
        }));
      }
      for (std::size_t i = first; i < end; ++i) {
        const Found found = running[i - first].get();
        ++count_;
        const double gain = cycle_.empty() ? 1.0 : enough;
        if (!cycle_.empty() && found.score_m() >= gain * best_.score_m()) continue;
        best_ = found;
        cycle_ = cycles[i];
        better = true;
      }
      if (progress_) progress_(count_, best_.whole.with_sensors_m);
    }
    return better;
  }

  const DriveCycle& cycle() const { return cycle_; }
  const Found& best() const { return best_; }
  int count() const { return count_; }

 private:
  const TestWorth& worth_;
  const DriveLimits& limits_;
  const rom::Boundaries& boundaries_;
  const std::function<void(int, double)>& progress_;
  TakenReadings taken_;
  DriveCycle cycle_;
  Found best_;
  int count_ = 0;
};

/// Stage by stage: another speed in a part of it, another speed in all of it, another time to switch to the next one.
/// Whether anything was gained.
bool refine(CycleSearch& evaluate, const DriveLimits& limits) {
  bool gained = false;
  const auto improve = [&](const std::vector<DriveCycle>& cycles) {
    gained = evaluate.improve(cycles, worth_refining) || gained;
  };
  const auto now = [&] { return joined(evaluate.cycle()); };
  for (std::size_t stage = 0; stage < now().size() && evaluate.count() < most_cycles; ++stage) {
    improve(splits(now(), stage, limits));
    if (stage < now().size()) improve(other_speeds(now(), stage, limits));
    if (stage + 1 < now().size()) improve(other_times(now(), stage, limits, {120.0, 300.0}));
  }
  return gained;
}

TakenReadings with(const std::vector<std::size_t>& permanent, const std::vector<SensorWorth>& temporary) {
  TakenReadings taken;
  taken.sensors = permanent;
  for (const SensorWorth& one : temporary) taken.sensors.push_back(one.sensor);
  return taken;
}

}  // namespace

TestPlan plan_cycle(const TestWorth& worth, const DriveLimits& limits, const rom::Boundaries& boundaries,
                    const std::vector<std::size_t>& permanent, const std::function<void(int, double)>& progress) {
  CycleSearch evaluate(worth, limits, boundaries, permanent, progress);
  const auto fit = static_cast<std::size_t>(std::max(1.0, std::floor(limits.length_s / limits.shortest_s)));
  const auto usual = static_cast<std::size_t>(std::lround(limits.length_s / usual_stage_s));
  const std::size_t stages = std::min(fit, std::clamp(usual, least_stages, most_stages));
  const auto top = *std::max_element(limits.shares.begin(), limits.shares.end());
  const auto low = *std::min_element(limits.shares.begin(), limits.shares.end());
  std::vector<double> rising = limits.shares;
  std::sort(rising.begin(), rising.end());
  const std::vector<double> falling(rising.rbegin(), rising.rend());
  const double middle = rising[rising.size() / 2];

  evaluate.improve({in_stages(stages, {top}, limits), in_stages(stages, {top, low}, limits),
                    in_stages(stages, {top, low, middle}, limits), in_stages(stages, rising, limits),
                    in_stages(stages, falling, limits)});
  for (int round = 0; round < rounds; ++round) {
    bool gained = false;
    for (std::size_t stage = 0; stage < stages; ++stage) {
      gained = evaluate.improve(other_speeds(evaluate.cycle(), stage, limits)) || gained;
    }
    if (!gained) break;
  }
  const std::size_t shifts = joined(evaluate.cycle()).size();
  for (std::size_t stage = 0; stage + 1 < shifts; ++stage) {
    const DriveCycle now = joined(evaluate.cycle());
    if (stage + 1 >= now.size()) continue;
    const double step_s = half_in_minutes_s(std::min(now[stage].length_s, now[stage + 1].length_s));
    evaluate.improve(other_times(now, stage, limits, {step_s}));
  }
  while (evaluate.count() < most_cycles && refine(evaluate, limits)) {
  }
  TestPlan plan;
  plan.cycle = joined(evaluate.cycle());
  plan.worth = evaluate.best().whole;
  plan.early = evaluate.best().early;
  plan.evaluated = evaluate.count();
  return plan;
}

void plan_sensors(const TestWorth& worth, const TestPrediction& prediction, const std::vector<std::size_t>& permanent,
                  std::size_t candidates, int count, TestPlan& plan) {
  std::vector<std::size_t> left(candidates);
  for (std::size_t i = 0; i < candidates; ++i) left[i] = permanent.size() + i;
  const auto better = [](const SensorWorth& a, const SensorWorth& b) {
    return a.worth.with_sensors_m < b.worth.with_sensors_m;
  };
  while (!left.empty()) {
    std::vector<SensorWorth> each;
    for (const std::size_t sensor : left) {
      TakenReadings taken = with(permanent, plan.temporary);
      taken.sensors.push_back(sensor);
      each.push_back({sensor, worth.of(prediction, taken)});
    }
    std::stable_sort(each.begin(), each.end(), better);
    if (plan.candidates.empty()) plan.candidates = each;
    if (static_cast<int>(plan.temporary.size()) >= count) break;
    plan.temporary.push_back(each.front());
    left.erase(std::find(left.begin(), left.end(), each.front().sensor));
    if (static_cast<int>(plan.temporary.size()) >= count) break;
  }
  const TakenReadings all = with(permanent, plan.temporary);
  for (const std::size_t sensor : all.sensors) {
    TakenReadings others = all;
    others.sensors.erase(std::find(others.sensors.begin(), others.sensors.end(), sensor));
    plan.without.push_back({sensor, worth.of(prediction, others)});
  }
}

CalibrateOptions thinned(CalibrateOptions options, double interval_s) {
  const double share = std::sqrt(options.interval_s / interval_s);
  options.interval_s = interval_s;
  options.held_s = std::min(60.0, interval_s);
  options.longest_step_s = interval_s;
  options.probe_noise_m *= share;
  options.sensor_error_K *= share;
  options.sensor_error_share *= share;
  for (EstimatorSensor& sensor : options.sensors) sensor.noise_K *= share;
  return options;
}

}  // namespace spindle_twin::correction
