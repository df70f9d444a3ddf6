#include "correction/health/electrical_detector.hpp"

#include <gtest/gtest.h>

namespace spindle_twin::correction::test {
namespace health_electrical_detector_test {

TEST(ElectricalDetector, the_value_alone_tells_broken_shorted_and_out_of_range) {
  const HealthLimits limits;
  const auto judged = [&](double reading_K) { return ElectricalDetector::judge(reading_K, 253.15, 423.15, limits); };
  EXPECT_EQ(judged(limits.open_above_K), HealthFault::open);
  EXPECT_EQ(judged(limits.open_above_K - 0.01), HealthFault::out_of_range);
  EXPECT_EQ(judged(423.15), HealthFault::none);
  EXPECT_EQ(judged(253.15), HealthFault::none);
  EXPECT_EQ(judged(limits.short_below_K + 0.01), HealthFault::out_of_range);
  EXPECT_EQ(judged(limits.short_below_K), HealthFault::shorted);
}

TEST(ElectricalDetector, one_wrong_reading_is_a_spike_and_the_second_in_a_row_a_fault) {
  const HealthLimits limits;
  ElectricalDetector detector;
  EXPECT_FALSE(detector.note_right());
  EXPECT_FALSE(detector.note_fault(limits));
  EXPECT_FALSE(detector.is_right());
  EXPECT_TRUE(detector.note_right());
  EXPECT_TRUE(detector.is_right());
  EXPECT_FALSE(detector.note_fault(limits));
  EXPECT_TRUE(detector.note_fault(limits));
  EXPECT_TRUE(detector.note_fault(limits));
}

TEST(ElectricalDetector, the_limits_themselves_are_told_where_the_range_of_the_channel_is_wider) {
  const HealthLimits limits;
  const auto judged = [&](double reading_K) { return ElectricalDetector::judge(reading_K, 100.0, 1000.0, limits); };
  EXPECT_EQ(judged(673.15), HealthFault::open);
  EXPECT_EQ(judged(673.14), HealthFault::none);
  EXPECT_EQ(judged(173.15), HealthFault::shorted);
  EXPECT_EQ(judged(173.16), HealthFault::none);
}

}  // namespace health_electrical_detector_test
}  // namespace spindle_twin::correction::test
