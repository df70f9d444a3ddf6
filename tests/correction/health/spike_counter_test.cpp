#include "correction/health/spike_counter.hpp"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(SpikeCounter, one_at_the_very_beginning_of_the_window_counts) {
  for (const double since_s : {600.0, 600.5}) {
    SpikeCounter counter;
    for (const double time_s : {0.0, 300.0, 400.0}) counter.note(time_s, {});
    EXPECT_EQ(counter.note(since_s, {}), since_s == 600.0);
  }
}

TEST(SpikeCounter, up_to_sixteen_are_counted_however_many_came_before) {
  HealthLimits limits;
  for (const int spikes : {1, 15, 16, 20}) {
    limits.spikes = spikes;
    SpikeCounter counter;
    double time_s = 0.0;
    for (int k = 0; k < 37; ++k) counter.note(time_s += 601.0, limits);
    time_s += 601.0;
    const int needed = std::min(spikes, 16);
    for (int round = 0; round < 2; ++round) {
      for (int k = 1; k <= needed; ++k) EXPECT_EQ(counter.note(time_s += 1.0, limits), k == needed) << spikes;
    }
  }
}

}  // namespace health_spike_counter_test
}  // namespace spindle_twin::correction::test
