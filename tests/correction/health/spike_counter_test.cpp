#include "correction/health/spike_counter.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::correction::test {
namespace health_spike_counter_test {

TEST(SpikeCounter, the_fourth_within_the_window_is_too_many_and_counting_begins_anew) {
  const HealthLimits limits;
  SpikeCounter counter;
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(counter.note(200.0 * k, limits));
  EXPECT_TRUE(counter.note(600.0, limits));
  for (int k = 0; k < 3; ++k) EXPECT_FALSE(counter.note(601.0 + k, limits));
  EXPECT_TRUE(counter.note(604.0, limits));
}

TEST(SpikeCounter, those_before_the_window_do_not_count) {
  SpikeCounter counter;
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(counter.note(201.0 * k, {}));
}

}  // namespace health_spike_counter_test
}  // namespace spindle_twin::correction::test
