#include "correction/health/isolation.hpp"

#include <gtest/gtest.h>

#include "tests/correction/health/drive.hpp"

namespace spindle_twin::correction::test {
namespace {

constexpr std::uint64_t seed = 20;

TEST(Isolation, drift_fails_the_channel_that_the_others_contradict_most_and_only_with_three_in_use) {
  for (const std::size_t channels : {std::size_t{2}, std::size_t{3}}) {
    const HealthLimits limits;
    SensorHealth health(std::vector<HealthChannel>(channels, {true, 253.15, 423.15, 0.01}), limits);
    std::vector<HealthUpdate> updates(channels, {true, 3.0, 0});
    updates[1].evidence = limits.drift_limit;
    EXPECT_EQ(health.note_update(updates).failed, -1);
    updates[1].evidence = limits.drift_limit + 1.0;
    EXPECT_EQ(health.note_update(updates).failed, channels == 3 ? 1 : -1);
    if (channels < 3) continue;
    EXPECT_EQ(health.record(1).fault, HealthFault::drift);
    updates[2].evidence = 100.0;
    EXPECT_EQ(health.note_update(updates).failed, -1) << "two are left";
  }
}

TEST(Isolation, drift_waits_while_two_channels_look_alike) {
  SensorHealth health(std::vector<HealthChannel>(4, {true, 253.15, 423.15, 0.01}), {});
  std::vector<HealthUpdate> updates(4, {true, 0.0, 0});
  for (const auto& [one, other] : {std::pair{1U, 2U}, {2U, 1U}}) {
    updates[one].evidence = 40.0;
    updates[other].evidence = 34.0;
    for (int update = 0; update < 100; ++update) EXPECT_EQ(health.note_update(updates).failed, -1);
  }
  updates[1].evidence = 49.0;
  EXPECT_EQ(health.note_update(updates).failed, 1);
}

TEST(Isolation, two_that_contradict_the_others_together_are_exchanged_where_each_fits_the_place_of_the_other) {
  for (const double place_K : {302.0, 310.0}) {
    SensorHealth health(std::vector<HealthChannel>(4, {true, 253.15, 423.15, 0.01}), {});
    std::vector<HealthUpdate> updates(4, {true, 0.0, 0, 300.0, 0.0});
    updates[0] = {true, 40.0, 0, 302.0, 2.0};           // at its place others expect 300 K
    updates[2] = {true, 38.0, 0, place_K - 2.0, -2.0};  // at its place place_K
    const HealthVerdict verdict = health.note_update(updates);
    const bool exchanged = place_K == 302.0;
    EXPECT_EQ(verdict.failed, exchanged ? 0 : -1) << "evidence that is as large against another waits";
    EXPECT_EQ(verdict.partner, exchanged ? 2 : -1);
    for (const std::size_t channel : {0U, 2U}) {
      EXPECT_EQ(health.record(channel).fault, exchanged ? HealthFault::swapped : HealthFault::none);
    }
    EXPECT_EQ(health.record(0).partner, exchanged ? 2 : -1);
  }
}

TEST(Isolation, what_has_come_slowly_is_a_drift_even_where_it_fits_the_place_of_a_neighbour) {
  for (const double rise_s : {60.0, 600.0}) {
    Drive drive(seed);
    drive.run_until(900.0);
    std::vector<HealthUpdate> updates(6, {true, 0.0, 0, 300.0, 0.0});
    updates[0] = {true, 20.0, 0, 300.3, 0.3};
    updates[1] = {true, 10.0, 0, 300.0, -0.25};
    std::vector<HealthUpdate> calm(6, {true, 0.0, 0, 300.0, 0.0});
    drive.health.note_update(calm);
    drive.run_until(900.0 + rise_s);
    drive.health.note_update(updates);
    updates[0].evidence = 40.0;
    const HealthVerdict verdict = drive.health.note_update(updates);
    EXPECT_EQ(verdict.failed, 0);
    EXPECT_EQ(verdict.partner, rise_s < 120.0 ? 1 : -1);
  }
}

TEST(Isolation, what_the_estimator_rejects_is_implausible_and_may_return) {
  Drive drive(seed);
  drive.run_until(600.0);
  std::vector<HealthUpdate> updates(6, {true, 0.0, 0});
  updates[4] = {true, 35.0, 2};
  EXPECT_EQ(drive.health.note_update(updates).failed, 4);
  EXPECT_EQ(drive.health.record(4).fault, HealthFault::implausible);
  drive.run_until(1200.0);
  EXPECT_EQ(drive.health.record(4).state, HealthState::good);
}

}  // namespace
}  // namespace spindle_twin::correction::test
