#include "correction/health/model_movement.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace spindle_twin::correction::test {
namespace health_model_movement_test {

TEST(ModelMovement, what_corrections_keep_taking_back_is_left_out_after_ten_minutes) {
  ModelMovement model;
  double reading_K = 300.0;
  for (int t = 0; t < 6000; ++t) {
    model.add(0.01, 1.0);  // the heat is wrong for good: integration moves, the reading stands
    model.learn(reading_K - model.integrated_K(), 1.0);
  }
  EXPECT_NEAR(model.integrated_K(), 60.0, 1e-9);
  const double before_K = model.steady_K();
  EXPECT_NEAR(before_K, 0.01 * 600.0, 0.1) << "one time constant's worth until it was learnt";
  for (int t = 0; t < 600; ++t) {
    model.add(0.01, 1.0);
    model.learn(reading_K - model.integrated_K(), 1.0);
  }
  EXPECT_NEAR(model.steady_K(), before_K, 0.01);
}

TEST(ModelMovement, nothing_is_learnt_across_an_interruption) {
  ModelMovement model;
  model.learn(0.0, 1.0);
  model.interrupt();
  model.learn(5.0, 1.0);
  model.add(0.0, 100.0);
  EXPECT_EQ(model.steady_K(), 0.0);
}

TEST(ModelMovement, the_rate_is_a_mean_over_ten_minutes_of_what_the_detrended_reading_runs_away_by) {
  ModelMovement model;
  model.learn(0.0, 0.0);
  model.learn(3.0, 2.0);  // 1.5 K/s
  model.learn(3.0, 0.0);  // of no time there is no rate
  model.learn(2.0, 4.0);  // -0.25 K/s
  const double first = 1.5 * (1.0 - std::exp(-2.0 / 600.0));
  const double second = first + (1.0 - std::exp(-4.0 / 600.0)) * (-0.25 - first);
  model.add(0.5, 100.0);
  EXPECT_EQ(model.integrated_K(), 0.5);
  EXPECT_NEAR(model.steady_K(), 0.5 + 100.0 * second, 1e-12);
  model.add(-0.25, 0.0);
  EXPECT_EQ(model.integrated_K(), 0.25);
  EXPECT_NEAR(model.steady_K(), 0.25 + 100.0 * second, 1e-12);
}

TEST(ModelMovement, the_first_reading_tells_of_no_rate) {
  ModelMovement model;
  model.learn(5.0, 1.0);
  model.add(0.0, 100.0);
  EXPECT_EQ(model.steady_K(), 0.0);
}

}  // namespace health_model_movement_test
}  // namespace spindle_twin::correction::test
