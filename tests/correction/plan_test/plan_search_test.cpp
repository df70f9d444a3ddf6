#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "correction/plan_test/plan_test.hpp"
#include "correction/plan_test/vary_cycle.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"

namespace spindle_twin::correction::test {
namespace plan_search_test {

/// The search by its description, one cycle after another.
class SearchByDescription {
 public:
  SearchByDescription(const TestWorth& worth, const DriveLimits& limits, const rom::Boundaries& boundaries)
      : worth_(worth), limits_(limits), boundaries_(boundaries) {}

  TestPlan search() {
    begin();
    for (int round = 0; round < 2; ++round) {
      bool gained = false;
      for (std::size_t stage = 0; stage < stages(); ++stage) {
        if (offer(other_speeds(plan_.cycle, stage, limits_), 0.998)) gained = true;
      }
      if (!gained) break;
    }
    const std::size_t switches = joined(plan_.cycle).size();
    for (std::size_t stage = 0; stage + 1 < switches; ++stage) {
      const DriveCycle now = joined(plan_.cycle);
      if (stage + 1 >= now.size()) continue;
      const double shorter_s = std::min(now[stage].length_s, now[stage + 1].length_s);
      offer(other_times(now, stage, limits_, {half_in_minutes_s(shorter_s)}), 0.998);
    }
    while (plan_.evaluated < 300 && refine()) {
    }
    plan_.cycle = joined(plan_.cycle);
    return plan_;
  }

 private:
  std::size_t stages() const {
    const double fit = std::max(1.0, std::floor(limits_.length_s / limits_.shortest_s));
    return static_cast<std::size_t>(std::min(fit, std::clamp(std::round(limits_.length_s / 1200.0), 4.0, 8.0)));
  }
  void begin() {
    std::vector<double> rising = limits_.shares;
    std::sort(rising.begin(), rising.end());
    const double low = rising.front(), top = rising.back(), middle = rising[rising.size() / 2];
    const std::vector<double> falling(rising.rbegin(), rising.rend());
    const std::vector<std::vector<double>> forms{{top}, {top, low}, {top, low, middle}, rising, falling};
    for (const std::vector<double>& form : forms) {
      offer({in_stages(stages(), form, limits_)}, 0.998);
    }
  }
  bool refine() {
    bool gained = false;
    const auto take = [&](const std::vector<DriveCycle>& cycles) {
      if (offer(cycles, 0.9995)) gained = true;
    };
    const auto now = [&] { return joined(plan_.cycle); };
    for (std::size_t stage = 0; stage < now().size() && plan_.evaluated < 300; ++stage) {
      take(splits(now(), stage, limits_));
      if (stage < now().size()) take(other_speeds(now(), stage, limits_));
      if (stage + 1 < now().size()) take(other_times(now(), stage, limits_, {120.0, 300.0}));
    }
    return gained;
  }
  /// Takes each that is better than the best so far; whether one was.
  bool offer(const std::vector<DriveCycle>& cycles, double enough) {
    bool better = false;
    for (const DriveCycle& cycle : cycles) {
      const TestPrediction test = worth_.linearise(schedule_of(cycle, limits_, boundaries_));
      const Worth whole = worth_.of(test, {{0}, true}), early = worth_.of(test, {{0}, true, 1800.0});
      const double score_m = std::pow(whole.with_sensors_m, 0.9) * std::pow(early.with_sensors_m, 0.1);
      if (plan_.evaluated++ > 0 && score_m >= enough * best_m_) continue;
      best_m_ = score_m;
      plan_.cycle = cycle;
      plan_.worth = whole;
      plan_.early = early;
      better = true;
    }
    return better;
  }

  const TestWorth& worth_;
  const DriveLimits& limits_;
  const rom::Boundaries& boundaries_;
  TestPlan plan_;
  double best_m_ = 0.0;
};

/// plates() with one sensor in service, in steps of 25 minutes.
WorthOptions coarse_options(const rom::Network& network) {
  WorthOptions options;
  options.calibrate = thinned(calibrate_options(network), 1500.0);
  options.calibrate.held_s = 1500.0;
  options.calibrate.sensors.resize(2);
  options.permanent = 1;
  return options;
}

struct Wish {
  double length_s, shortest_s;
  std::vector<double> shares;
};

/// Lengths of one, two and eleven usual stages, of which four to eight are taken, or as many as there is time for.
TEST(PlanSearch, is_the_one_that_is_described) {
  const rom::Network network = plates();
  DriveLimits limits;
  limits.top_rpm = 9000.0;
  const TestWorth worth(network, coarse_options(network),
                        schedule_of({{1800.0, 6000.0}, {1800.0, 0.0}}, limits, network.boundaries));
  for (const Wish& wish : {Wish{1500.0, 300.0, {0.0, 0.5, 1.0}},
                           {2400.0, 900.0, {1.0, 0.0}},
                           {13500.0, 1500.0, {0.0, 1.0}},
                           {600.0, 900.0, {0.5, 1.0}}}) {
    limits.length_s = wish.length_s;
    limits.shortest_s = wish.shortest_s;
    limits.shares = wish.shares;
    SearchByDescription description(worth, limits, network.boundaries);
    const TestPlan expected = description.search();
    int told = 0;
    double told_m = 0.0;
    const auto progress = [&](int evaluated, double best_m) {
      EXPECT_GT(evaluated, told);
      told = evaluated;
      told_m = best_m;
    };
    const TestPlan plan = plan_cycle(worth, limits, network.boundaries, {0}, progress);
    EXPECT_EQ(plan.evaluated, expected.evaluated) << wish.length_s;
    EXPECT_EQ(plan.cycle, expected.cycle) << wish.length_s;
    EXPECT_EQ(plan.worth.with_sensors_m, expected.worth.with_sensors_m);
    EXPECT_EQ(plan.early.with_sensors_m, expected.early.with_sensors_m);
    EXPECT_EQ(told, plan.evaluated);
    EXPECT_EQ(told_m, plan.worth.with_sensors_m);
  }
}

TEST(PlanSearch, options_for_less_than_a_minute_hold_what_is_commanded_as_long_as_a_reading_stands_for) {
  const CalibrateOptions usual = calibrate_options(plates());
  EXPECT_EQ(thinned(usual, 60.0).held_s, 60.0);
  EXPECT_EQ(thinned(usual, 61.0).held_s, 60.0);
  EXPECT_EQ(thinned(usual, 59.0).held_s, 59.0);
}

}  // namespace plan_search_test
}  // namespace spindle_twin::correction::test
