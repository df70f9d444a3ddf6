#include "firmware/acquire/channel_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace spindle_twin::firmware {
namespace acquire_channel_filter_test {

constexpr std::int64_t ms = 1'000'000;

TEST(ChannelFilter, without_one_each_sample_is_a_reading) {
  ChannelFilter filter({});
  const auto reading = filter.take({3.0, 5});
  ASSERT_TRUE(reading.has_value());
  EXPECT_EQ(reading->value, 3.0);
  EXPECT_EQ(reading->time_ns, 5);
}

TEST(ChannelFilter, a_mean_takes_one_reading_a_window_from_1_kHz_and_leaves_no_ripple) {
  ChannelFilter filter({FilterPlan::Kind::mean, 1.0});
  std::vector<Reading> made;
  for (int i = 0; i < 5000; ++i) {
    const double t_s = 1e-3 * i;
    const double power_W = 500.0 + 300.0 * std::sin(2.0 * std::numbers::pi * 50.0 * t_s);
    if (const auto reading = filter.take({power_W, 1 + i * ms})) made.push_back(*reading);
  }
  ASSERT_EQ(made.size(), 4U);
  for (std::size_t n = 0; n < made.size(); ++n) {
    EXPECT_NEAR(made[n].value, 500.0, 1e-6);
    EXPECT_NEAR(1e-9 * static_cast<double>(made[n].time_ns), static_cast<double>(n) + 0.4995, 1e-6)
        << "of the middle of its samples";
  }
}

TEST(ChannelFilter, a_mean_leaves_out_what_is_no_number_and_is_none_only_where_all_are) {
  ChannelFilter filter({FilterPlan::Kind::mean, 0.01});
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(filter.take({i % 2 == 0 ? 4.0 : not_a_value, 1 + i * ms}).has_value());
  EXPECT_DOUBLE_EQ(filter.take({not_a_value, 1 + 10 * ms})->value, 4.0);
  for (int i = 11; i < 20; ++i) filter.take({not_a_value, 1 + i * ms});
  EXPECT_TRUE(std::isnan(filter.take({4.0, 1 + 20 * ms})->value));
}

TEST(ChannelFilter, a_low_pass_follows_a_step_as_the_exponential_does_whatever_the_distance_of_its_samples) {
  for (const std::int64_t step_ms : {1, 7, 100}) {
    ChannelFilter filter({FilterPlan::Kind::low_pass, 2.0});
    filter.take({0.0, 1});
    std::optional<Reading> last;
    for (std::int64_t t_ms = step_ms; t_ms <= 4200; t_ms += step_ms) last = filter.take({1.0, 1 + t_ms * ms});
    EXPECT_NEAR(last->value, 1.0 - std::exp(-2.1), 1e-9) << step_ms;
    EXPECT_EQ(last->time_ns, 1 + 2200 * ms) << "a reading is as old as the low pass is late";
  }
}

TEST(ChannelFilter, a_low_pass_ends_with_what_is_no_number_and_begins_anew) {
  ChannelFilter filter({FilterPlan::Kind::low_pass, 2.0});
  filter.take({0.0, 1});
  EXPECT_TRUE(std::isnan(filter.take({not_a_value, 1 + ms})->value));
  EXPECT_EQ(filter.take({5.0, 1 + 2 * ms})->value, 5.0);
}

}  // namespace acquire_channel_filter_test
}  // namespace spindle_twin::firmware
