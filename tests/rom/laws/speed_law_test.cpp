#include "rom/laws/speed_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace spindle_twin::rom {
namespace laws_speed_law_test {

TEST(SpeedLaw, default_is_one_everywhere) {
  for (const double speed_rpm : {-24000.0, 0.0, 24000.0}) {
    EXPECT_EQ(evaluate_speed_law({}, speed_rpm, 6000.0, 0.3), 1.0);
  }
}

TEST(SpeedLaw, sum_of_powers_of_the_speed_ratio_and_load_squared) {
  const SpeedLaw law{0.1, {{0.5, 1.0}, {0.3, 1.5}}, 0.4, false};
  EXPECT_NEAR(evaluate_speed_law(law, 24000.0, 6000.0, 0.5), 0.1 + 0.5 * 4.0 + 0.3 * 8.0 + 0.4 * 0.25, 1e-14);
  EXPECT_NEAR(evaluate_speed_law(law, 6000.0, 6000.0, 1.0), 0.1 + 0.5 + 0.3 + 0.4, 1e-15);
}

TEST(SpeedLaw, direction_of_rotation_does_not_matter) {
  const SpeedLaw law{0.0, {{1.0, 0.7}}, 0.0, true};
  EXPECT_EQ(evaluate_speed_law(law, -9000.0, 6000.0, 1.0), evaluate_speed_law(law, 9000.0, 6000.0, 1.0));
}

TEST(SpeedLaw, standstill_gives_zero_only_where_asked) {
  SpeedLaw law{0.2, {{0.8, 0.7}}, 0.5, false};
  EXPECT_NEAR(evaluate_speed_law(law, 0.0, 6000.0, 1.0), 0.7, 1e-15);
  law.zero_at_standstill = true;
  EXPECT_EQ(evaluate_speed_law(law, 0.0, 6000.0, 1.0), 0.0);
  EXPECT_GT(evaluate_speed_law(law, 1.0, 6000.0, 1.0), 0.7);
}

}  // namespace laws_speed_law_test
}  // namespace spindle_twin::rom
