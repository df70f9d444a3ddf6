#include "correction/health/model_movement.hpp"

#include <gtest/gtest.h>

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

}  // namespace health_model_movement_test
}  // namespace spindle_twin::correction::test
