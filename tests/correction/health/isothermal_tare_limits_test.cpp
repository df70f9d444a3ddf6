#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "correction/health/isothermal_tare.hpp"

namespace spindle_twin::correction {
namespace health_isothermal_tare_limits_test {

constexpr double common = std::numeric_limits<double>::quiet_NaN();

/// Channels that read what they are told without any noise, second by second. All numbers are exact as binary ones.
struct Still {
  Still(std::vector<double> values_K, const TareLimits& limits)
      : tare(values_K.size(), limits), readings_K(std::move(values_K)), models_K(readings_K.size(), 295.0) {}
  void rest(int seconds) {
    for (int n = 0; n < seconds; ++n) step(false);
  }
  void step(bool heated, double h_s = 1.0) {
    std::vector<TareSample> samples;
    for (std::size_t i = 0; i < readings_K.size(); ++i) {
      samples.push_back({!std::isnan(readings_K[i]), readings_K[i], models_K[i]});
    }
    tare.step(samples, heated, h_s);
  }
  TareWait waits_for() const { return tare.outlook().waits_for; }
  IsothermalTare tare;
  std::vector<double> readings_K, models_K;
};

/// Two blocks of a minute, and a rest that is over before; changes of 0.25 K between blocks.
TareLimits short_limits() {
  TareLimits limits;
  limits.rest_s = 60.0;
  limits.block_s = 60.0;
  limits.rate_K_per_h = 15.0;
  limits.model_spread_K = 0.0625;
  return limits;
}

TEST(IsothermalTare, is_offered_with_the_block_that_ends_the_rest_and_no_second_earlier) {
  Still still({295.0, 295.5}, TareLimits{});
  EXPECT_FALSE(still.tare.offered());
  EXPECT_EQ(still.waits_for(), TareWait::rest);
  for (int run = 0; run < 2; ++run) {
    still.rest(1000);
    EXPECT_EQ(still.tare.outlook().left_s, 6200.0);
    still.rest(6199);
    EXPECT_FALSE(still.tare.offered());
    EXPECT_EQ(still.tare.outlook().left_s, 1.0);
    EXPECT_EQ(still.tare.outlook().channel, -1);
    still.rest(1);
    EXPECT_TRUE(still.tare.offered());
    still.rest(100);
    EXPECT_EQ(still.waits_for(), TareWait::nothing);
    EXPECT_EQ(still.tare.outlook().left_s, 200.0) << "the end of the block";
    EXPECT_EQ(still.tare.outlook().channel, -1);
    still.step(true);
    EXPECT_FALSE(still.tare.offered()) << "and after heat all of it once more";
    EXPECT_EQ(still.tare.outlook().channel, -1);
  }
  still.rest(1000);
  EXPECT_EQ(still.tare.outlook().left_s, 6200.0);
}

TEST(IsothermalTare, needs_two_whole_blocks_however_short_the_rest) {
  TareLimits limits = short_limits();
  limits.block_s = 300.0;
  Still still({295.0, 295.5}, limits);
  for (int run = 0; run < 2; ++run) {
    still.rest(100);
    EXPECT_EQ(still.tare.outlook().left_s, 500.0);
    still.rest(300);
    EXPECT_EQ(still.tare.outlook().left_s, 200.0);
    EXPECT_EQ(still.waits_for(), TareWait::rest);
    still.rest(199);
    still.step(false, 0.5);
    EXPECT_EQ(still.tare.outlook().left_s, 0.5);
    EXPECT_FALSE(still.tare.offered());
    still.step(false, 0.5);
    EXPECT_TRUE(still.tare.offered());
    still.step(true);
  }
}

TEST(IsothermalTare, is_not_offered_where_one_sensor_changes_by_more_than_the_rate_up_or_down) {
  for (const double change_K : {0.25, 0.2501, -0.25, -0.2501}) {
    Still still({295.0, 295.0, 295.0}, short_limits());
    still.rest(60);
    still.readings_K[1] += change_K;
    still.rest(60);
    const bool allowed = std::abs(change_K) == 0.25;
    EXPECT_EQ(still.waits_for(), allowed ? TareWait::nothing : TareWait::change) << change_K;
    EXPECT_EQ(still.tare.outlook().channel, allowed ? -1 : 1);
    still.rest(120);
    EXPECT_EQ(still.waits_for(), TareWait::nothing) << "it has come to rest";
    EXPECT_EQ(still.tare.outlook().channel, -1);
  }
}

TEST(IsothermalTare, readings_and_model_may_be_apart_up_to_their_limits_in_whatever_order) {
  for (const std::array<int, 3> order : {std::array{0, 1, 2}, {1, 0, 2}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}}) {
    for (const double wider_K : {0.0, 0.015625}) {
      Still still({295.0, 295.0, 295.0}, short_limits());
      const std::array<double, 3> readings_K{294.25, 294.75, 295.25 + wider_K}, models_K{295.0, 295.03125, 295.0625};
      for (std::size_t i = 0; i < 3; ++i) {
        still.readings_K[i] = readings_K[static_cast<std::size_t>(order[i])];
        still.models_K[i] = models_K[static_cast<std::size_t>(order[i])];
      }
      still.rest(120);
      EXPECT_EQ(still.waits_for(), wider_K > 0.0 ? TareWait::apart : TareWait::nothing);
      if (wider_K > 0.0) {
        EXPECT_EQ(order.at(static_cast<std::size_t>(still.tare.outlook().channel)), 2) << "the furthest";
      }
      still.readings_K = {295.0, 295.0, 295.0};
      for (double& model_K : still.models_K) model_K += model_K == 295.0625 ? wider_K : 0.0;
      still.rest(240);
      EXPECT_EQ(still.waits_for(), wider_K > 0.0 ? TareWait::model : TareWait::nothing);
    }
  }
}

/// Channel 2 reads in the second block alone and channel 3 never: nothing is known of them.
TEST(IsothermalTare, takes_offsets_of_what_read_in_both_blocks_and_leaves_those_of_others) {
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  Still still({295.25, 295.75, no_number, no_number}, short_limits());
  for (int n = 0; n < 60; ++n) {
    still.readings_K[1] = n % 4 == 0 ? 295.75 : no_number;
    still.step(false);
  }
  still.readings_K = {295.25, 295.75, 299.0, no_number};
  still.rest(60);
  SensorTare fresh, before{3, {9.0, 9.0, 0.25, 0.5}, {9.0, 9.0, 0.01, 0.02}};
  ASSERT_TRUE(still.tare.take(common, 0.3, fresh));
  ASSERT_TRUE(still.tare.take(295.0, 0.3, before));
  EXPECT_EQ(fresh.count, 1U);
  EXPECT_EQ(before.count, 4U);
  EXPECT_EQ(fresh.offset_K, (std::vector<double>{-0.25, 0.25, 0.0, 0.0}));
  EXPECT_EQ(before.offset_K, (std::vector<double>{0.25, 0.75, 0.25, 0.5}));
  for (SensorTare* tare : {&fresh, &before}) {
    EXPECT_DOUBLE_EQ(tare->deviation_K[0], std::sqrt(0.3 * 0.3 / 120.0 + 0.015 * 0.015));
    EXPECT_DOUBLE_EQ(tare->deviation_K[1], std::sqrt(0.3 * 0.3 / 75.0 + 0.015 * 0.015));
  }
  EXPECT_EQ(fresh.deviation_K[2], 0.0);
  EXPECT_EQ(fresh.deviation_K[3], 0.0);
  EXPECT_EQ(before.deviation_K[2], 0.01);
  EXPECT_EQ(before.deviation_K[3], 0.02);
}

TEST(IsothermalTare, a_sample_that_is_no_number_counts_no_more_than_one_that_is_not_valid) {
  IsothermalTare tare(2, short_limits());
  for (int n = 0; n < 120; ++n) {
    const bool good = n % 3 == 0;
    tare.step({{true, good ? 295.0 : common, 295.0}, {good, good ? 295.0 : 20.0, 295.0}}, false, 1.0);
  }
  SensorTare taken;
  ASSERT_TRUE(tare.take(common, 0.3, taken));
  EXPECT_EQ(taken.offset_K, (std::vector<double>{0.0, 0.0}));
  for (const double deviation_K : taken.deviation_K) {
    EXPECT_DOUBLE_EQ(deviation_K, std::sqrt(0.3 * 0.3 / 40.0 + 0.015 * 0.015));
  }
}

TEST(IsothermalTare, one_reading_in_each_block_is_enough_and_one_in_the_first_alone_is_none) {
  const double no_number = std::numeric_limits<double>::quiet_NaN();
  Still still({295.0, 295.5, 299.0}, short_limits());
  for (int n = 0; n < 120; ++n) {
    still.readings_K = {295.0, n % 60 == 7 ? 295.5 : no_number, n < 60 ? 299.0 : no_number};
    still.step(false);
  }
  SensorTare taken;
  ASSERT_TRUE(still.tare.take(common, 0.3, taken));
  EXPECT_EQ(taken.offset_K, (std::vector<double>{-0.25, 0.25, 0.0}));
}

TEST(IsothermalTare, an_offset_is_the_mean_of_both_blocks) {
  Still still({295.0, 295.0}, short_limits());
  still.rest(60);
  still.readings_K = {295.25, 295.0};
  still.rest(60);
  SensorTare taken;
  ASSERT_TRUE(still.tare.take(295.0, 0.03, taken));
  EXPECT_EQ(taken.offset_K, (std::vector<double>{0.125, 0.0}));
}

}  // namespace health_isothermal_tare_limits_test
}  // namespace spindle_twin::correction
