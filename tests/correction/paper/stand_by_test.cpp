#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "tests/correction/paper/one_node.hpp"

namespace spindle_twin::correction::test {
namespace paper_stand_by_test {

PaperOptions without_joint_law() {
  PaperOptions options;
  options.window_s = 0.0;
  options.joint_law = false;
  return options;
}

/// The loop's twin runs with all factors 1 for one cycle, as the daemon's does while the correction is off.
void cycle_off(Loop& loop, double advance_s) {
  loop.correction.stand_by(loop.time_s, loop.twin.temperatures_K(), loop.operating, advance_s);
  rom::evaluate_boundaries(loop.network.boundaries, loop.operating, rom::no_correction(loop.network.boundaries),
                           loop.values);
  loop.twin.advance(advance_s, loop.values);
  loop.factors.heat = loop.true_heat;
  rom::evaluate_boundaries(loop.network.boundaries, loop.operating, loop.factors, loop.values);
  loop.plant.advance(advance_s, loop.values);
  loop.time_s += advance_s;
}

void run_off_until(Loop& loop, double end_s) {
  while (loop.time_s < end_s - 1e-9) cycle_off(loop, 1.0);
}

TEST(StandBy, all_factors_go_back_to_one) {
  Loop loop(375.0, 2.16, without_joint_law());
  loop.run_until(1000.0, 1.0);
  ASSERT_LT(loop.correction.factors().heat[0], 0.5);
  cycle_off(loop, 1.0);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
  EXPECT_EQ(loop.correction.factors().conductance[0], 1.0);
  EXPECT_EQ(loop.correction.ratio(0), 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::waiting);
}

TEST(StandBy, next_step_begins_a_whole_new_period) {
  Loop loop(375.0, 2.16, without_joint_law());
  loop.run_until(1000.0, 1.0);
  run_off_until(loop, 1333.0);
  loop.run_until(1412.0, 1.0);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
  EXPECT_FALSE(loop.cycle(1.0).corrected);
  EXPECT_TRUE(loop.cycle(1.0).corrected);  // at 1333 + 80 s
}

TEST(StandBy, heat_after_switching_on_goes_to_the_true_one_from_above) {
  Loop loop(375.0, 2.16, without_joint_law());
  loop.run_until(1000.0, 1.0);
  run_off_until(loop, 1600.0);
  double smallest = 1.0;
  while (loop.time_s < 3600.0) {
    loop.cycle(1.0);
    smallest = std::min(smallest, loop.heat_ratio());
  }
  EXPECT_NEAR(loop.heat_ratio(), 1.0, 0.02);
  // Counted once, the excess is taken away once; with the factor of before it would be taken away twice, to 0.46.
  EXPECT_GT(smallest, 0.95);
  EXPECT_NEAR(loop.rise_error(), 0.0, 0.02);
}

/// Two bodies with one sensor each; only the first one's heat is corrected.
TEST(StandBy, base_runs_with_the_factors_of_the_model) {
  PaperOptions options = without_joint_law();
  options.groups = {{"first", {0}, {0}}};
  options.guards.minimum_sensors = 1;
  Loop loop(375.0, 2.16, options, 2, 1);
  std::vector<const rom::Stepper*> bases;
  PaperCorrection law(loop.network, options, [&] {
    auto base = std::make_unique<NodeStepper>(375.0, 2);
    bases.push_back(base.get());
    return base;
  });
  ASSERT_EQ(bases.size(), 1U);
  NodeStepper model(375.0, 2);
  NodeStepper second_alone(375.0, 2);  // the oracle: the first heat off, all other factors 1
  rom::BoundaryValues values = rom::make_boundary_values(loop.network.boundaries);
  for (int second = 0; second < 500; ++second) {
    law.stand_by(second, model.temperatures_K(), loop.operating, 1.0);
    rom::evaluate_boundaries(loop.network.boundaries, loop.operating, law.factors(), values);
    model.advance(1.0, values);
    values.heat_W[0] = 0.0;
    second_alone.advance(1.0, values);
  }
  EXPECT_NEAR(bases[0]->temperatures_K()[0], ambient_K, 1e-12);
  EXPECT_DOUBLE_EQ(bases[0]->temperatures_K()[1], second_alone.temperatures_K()[1]);
  EXPECT_DOUBLE_EQ(bases[0]->temperatures_K()[1], model.temperatures_K()[1]);
}

}  // namespace paper_stand_by_test
}  // namespace spindle_twin::correction::test
