#include "correction/health/isolation.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/correction/health/drive.hpp"

namespace spindle_twin::correction::test {
namespace health_isolation_test {

/// Channels whose estimator began a quarter of an hour ago and more, the first verdict laid to the model.
SensorHealth settled(std::size_t channels) {
  SensorHealth health(std::vector<HealthChannel>(channels, {true, 253.15, 423.15, 0.01}), {});
  health.step(std::vector<HealthSample>(channels), 1000.0, 1000.0);
  spend_first_verdict(health, channels);
  health.step(std::vector<HealthSample>(channels), 1200.0, 200.0);
  return health;
}

/// Updates every ten seconds, in which evidence goes in a straight line. The first verdict was laid to the model, which
/// began anew.
struct Rising {
  explicit Rising(std::size_t channels) : isolation(channels), updates(channels) {
    for (HealthUpdate& update : updates) update = {true, 0.0, 0, 300.0, 1.0};
    std::vector<HealthUpdate> contradicting = updates;
    contradicting[1] = {true, 40.0, 2, 300.0, 1.0};
    first = isolation.judge(contradicting, in_doubt, time_s, {});
    isolation.note_restart(time_s);
  }
  /// Until the evidence has become `to`; the first blame on the way.
  Blame go(const std::vector<double>& to, double seconds) {
    std::vector<double> from;
    for (const HealthUpdate& update : updates) from.push_back(update.evidence);
    const double end_s = time_s + seconds, begin_s = time_s;
    while (time_s < end_s) {
      time_s += 10.0;
      const double share = (time_s - begin_s) / seconds;
      for (std::size_t i = 0; i < updates.size(); ++i) updates[i].evidence = from[i] + share * (to[i] - from[i]);
      const Blame blame = isolation.judge(updates, in_doubt, time_s, {});
      if (blame.channel >= 0) return blame;
    }
    return {};
  }
  Isolation isolation;
  std::vector<HealthUpdate> updates;
  bool in_doubt = false;
  double time_s = 1000.0;
  Blame first;
};

TEST(Isolation, the_first_verdict_is_laid_to_the_model_and_only_a_second_one_within_two_hours_blames_the_channel) {
  const HealthLimits limits;
  for (const double pause_s : {1000.0, 0.5 * limits.second_opinion_s, 1.1 * limits.second_opinion_s}) {
    Rising rising(4);
    EXPECT_TRUE(rising.first.first);
    EXPECT_TRUE(rising.first.model_in_doubt);
    EXPECT_EQ(rising.first.fault, HealthFault::none);
    rising.go({0, 0, 0, 0}, pause_s);
    rising.updates[1].rejected_in_a_row = 2;
    const Blame second = rising.go({0, 40, 0, 0}, 100.0);
    EXPECT_EQ(second.channel, 1);
    EXPECT_EQ(second.first, pause_s > limits.second_opinion_s) << pause_s;
    EXPECT_EQ(second.fault, second.first ? HealthFault::none : HealthFault::implausible);
  }
  // What health makes of it: nobody fails, the estimate is to be loosened.
  SensorHealth health(std::vector<HealthChannel>(4, {true, 253.15, 423.15, 0.01}), {});
  health.step(std::vector<HealthSample>(4), 1000.0, 1000.0);
  std::vector<HealthUpdate> updates(4, {true, 0.0, 0});
  updates[1] = {true, 40.0, 0};
  const HealthVerdict verdict = health.note_update(updates);
  EXPECT_EQ(verdict.failed, -1);
  EXPECT_TRUE(verdict.loosen);
  EXPECT_EQ(verdict.suspect, 1);
  EXPECT_EQ(health.record(1).state, HealthState::good);
}

TEST(Isolation, a_suspect_that_was_at_fault_has_its_offset_opened_once_where_that_may_be_and_drifts_else) {
  SensorHealth health(std::vector<HealthChannel>(4, {true, 253.15, 423.15, 0.01}), {});
  health.step(std::vector<HealthSample>(4), 1000.0, 1000.0);
  const HealthVerdict opened = health.note_suspect(2, 0.59, 0.1);
  EXPECT_EQ(opened.opened, 2);
  EXPECT_EQ(opened.failed, -1);
  EXPECT_EQ(health.record(2).state, HealthState::good);
  EXPECT_EQ(health.note_suspect(1, 0.61, 0.31).failed, -1) << "less than two deviations";
  EXPECT_EQ(health.note_suspect(1, 0.61, 0.31).opened, -1);
  EXPECT_EQ(health.note_suspect(1, 0.61, 0.3).failed, 1) << "more than three times 0.2 K";
  EXPECT_EQ(health.record(1).fault, HealthFault::drift);
  const HealthVerdict again = health.note_suspect(2, -0.1, 0.04);
  EXPECT_EQ(again.opened, -1);
  EXPECT_EQ(again.failed, 2);
  EXPECT_EQ(health.record(2).state, HealthState::failed);
  EXPECT_EQ(health.record(2).fault, HealthFault::drift);
}

TEST(Isolation, drift_is_no_verdict_in_the_first_quarter_of_an_hour_nor_after_a_restart_of_the_estimator) {
  Rising rising(4);
  EXPECT_EQ(rising.go({0, 60, 0, 0}, 890.0).channel, -1);
  EXPECT_EQ(rising.go({0, 60, 0, 0}, 1200.0).channel, -1) << "what the start has said counts no more";
  EXPECT_EQ(rising.go({0, 100, 0, 0}, 1200.0).fault, HealthFault::drift);
  Rising restarted(4);
  restarted.go({0, 0, 0, 0}, 3600.0);
  restarted.isolation.note_restart(restarted.time_s);
  EXPECT_EQ(restarted.go({0, 60, 0, 0}, 890.0).channel, -1);
}

TEST(Isolation, of_channels_that_say_nothing_none_counts_as_one_that_agrees) {
  for (const bool third_reads : {false, true}) {
    Rising rising(6);
    for (std::size_t i = 3; i < 6; ++i) rising.updates[i] = HealthUpdate{};
    if (!third_reads) rising.updates[2] = HealthUpdate{};
    rising.go(std::vector<double>(6, 0.0), 1200.0);
    EXPECT_EQ(rising.go({40, 0, 0, 0, 0, 0}, 600.0).channel, third_reads ? 0 : -1) << "of two nobody knows which";
  }
}

TEST(Isolation, what_the_start_has_said_is_forgotten_within_an_hour) {
  const HealthLimits limits;
  Rising rising(4);
  const double begin_s = rising.time_s;
  rising.go({0, 60, 0, 0}, 890.0);
  EXPECT_EQ(rising.go({0, 60, 0, 0}, 7000.0).channel, 1);
  // 60 of which 60 e^(−t/3600 s) do not count reach the limit of 30.
  EXPECT_NEAR(rising.time_s - begin_s - 890.0, 3600.0 * std::log(60.0 / (60.0 - limits.drift_limit)), 10.0);
}

TEST(Isolation, at_the_start_only_what_moves_like_anothers_place_is_blamed) {
  for (const int moves_like : {-1, 3}) {
    Rising rising(4);
    rising.updates[1].rejected_in_a_row = 2;
    rising.updates[1].moves_like = moves_like;
    const Blame blame = rising.go({12, 35, 12, 12}, 300.0);
    EXPECT_EQ(blame.channel, moves_like < 0 ? -1 : 1);
    EXPECT_EQ(blame.partner, moves_like);
  }
}

TEST(Isolation, what_was_there_at_the_start_already_has_not_come_fast) {
  Rising rising(4);
  rising.go({0, 60, 60, 0}, 890.0);
  rising.updates[1] = {true, 60.0, 0, 302.0, 2.0};
  rising.updates[2] = {true, 60.0, 0, 300.0, -2.0};
  const Blame blame = rising.go({0, 140, 60, 0}, 100.0);
  EXPECT_EQ(blame.fault, HealthFault::drift) << "not implausible, and no swap by the evidence of two minutes";
}

TEST(Isolation, a_misfit_that_came_within_two_minutes_is_no_drift) {
  for (const double rise_s : {100.0, 300.0}) {
    Rising rising(4);
    rising.go({0, 0, 0, 0}, 1200.0);
    const Blame blame = rising.go({0, 31, 0, 0}, rise_s);
    EXPECT_EQ(blame.channel, 1);
    EXPECT_EQ(blame.fault, rise_s < 120.0 ? HealthFault::implausible : HealthFault::drift) << rise_s;
  }
}

/// 0.6 K: three deviations of a class A PT100 that was never tared.
TEST(Isolation, what_may_be_an_offset_opens_it_once_and_then_fails_the_channel) {
  for (const double misfit_K : {-0.59, 0.59, 0.61}) {
    Rising rising(4);
    for (HealthUpdate& update : rising.updates) update.misfit_K = misfit_K;
    const auto verdict = [&] {
      rising.go({0, 0, 0, 0}, 1200.0);
      return rising.go({0, 40, 0, 0}, 600.0);
    };
    const Blame one = verdict();
    EXPECT_EQ(one.channel, 1);
    EXPECT_EQ(one.offset, std::abs(misfit_K) < 0.6) << misfit_K;
    EXPECT_EQ(one.fault, one.offset ? HealthFault::none : HealthFault::drift);
    rising.isolation.note_restart(rising.time_s);
    const Blame next = verdict();
    EXPECT_FALSE(next.offset) << "has been opened, whatever restarts";
    EXPECT_EQ(next.fault, HealthFault::drift);
    rising.isolation.acknowledge();
    EXPECT_EQ(verdict().offset, one.offset) << "a person says that it is right now";
  }
}

TEST(Isolation, what_came_too_fast_for_a_drift_is_no_offset_however_small) {
  Rising rising(4);
  for (HealthUpdate& update : rising.updates) update.misfit_K = 0.3;
  rising.go({0, 0, 0, 0}, 1200.0);
  EXPECT_EQ(rising.go({0, 40, 0, 0}, 60.0).fault, HealthFault::implausible);
}

TEST(Isolation, while_the_model_is_in_doubt_only_what_explains_the_misfit_alone_is_blamed) {
  for (const bool in_doubt : {false, true}) {
    for (const double next : {7.0, 21.0}) {
      Rising rising(6);
      rising.go(std::vector<double>(6, 0.0), 1200.0);
      rising.in_doubt = in_doubt;
      const Blame blame = rising.go({40, next, 7, 7, 7, 0}, 600.0);
      EXPECT_EQ(blame.channel, in_doubt && next > 10.0 ? -1 : 0);
      EXPECT_EQ(blame.model_in_doubt, in_doubt && blame.channel == 0);
      EXPECT_EQ(rising.isolation.model_in_doubt(), in_doubt);
    }
  }
}

TEST(Isolation, when_half_of_the_channels_have_evidence_against_them_it_is_the_model) {
  for (const bool half : {false, true}) {
    Rising rising(6);
    rising.go(std::vector<double>(6, 0.0), 1200.0);
    const Blame blame = rising.go({40, 22, half ? 20.0 : 7.0, 0, 0, 0}, 1200.0);
    EXPECT_EQ(blame.channel, half ? -1 : 0);
    EXPECT_EQ(rising.isolation.model_in_doubt(), half);
  }
  Rising two_of_three(3);
  two_of_three.go({0, 0, 0}, 1200.0);
  two_of_three.go({16, 0, 0}, 600.0);
  EXPECT_FALSE(two_of_three.isolation.model_in_doubt()) << "one is no half, whatever the others are";
  two_of_three.go({16, 16, 0}, 600.0);
  EXPECT_TRUE(two_of_three.isolation.model_in_doubt());
}

TEST(Isolation, a_pair_that_fits_each_others_places_is_swapped_even_where_it_is_half_of_all) {
  Rising rising(4);
  rising.go({0, 0, 0, 0}, 1200.0);
  rising.updates[0] = {true, 0.0, 0, 302.0, 2.0};
  rising.updates[2] = {true, 0.0, 0, 300.0, -2.0};
  const Blame blame = rising.go({40, 0, 38, 0}, 100.0);
  EXPECT_TRUE(rising.isolation.model_in_doubt());
  EXPECT_EQ(blame.channel, 0);
  EXPECT_EQ(blame.partner, 2);
}

TEST(Isolation, drift_fails_the_channel_that_the_others_contradict_most_and_only_with_three_in_use) {
  for (const std::size_t channels : {std::size_t{2}, std::size_t{3}}) {
    const HealthLimits limits;
    SensorHealth health = settled(channels);
    std::vector<HealthUpdate> updates(channels, {true, 3.0, 0, 300.0, 1.0});
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
  SensorHealth health = settled(4);
  std::vector<HealthUpdate> updates(4, {true, 0.0, 0, 300.0, 1.0});
  for (const auto& [one, other] : {std::pair{1U, 2U}, {2U, 1U}}) {
    updates[one].evidence = 40.0;
    updates[other].evidence = 34.0;
    for (int update = 0; update < 100; ++update) EXPECT_EQ(health.note_update(updates).failed, -1);
  }
  updates[1].evidence = 49.0;
  EXPECT_EQ(health.note_update(updates).failed, 1);
}

TEST(Isolation, two_that_contradict_the_others_together_are_swapped_where_each_fits_the_place_of_the_other) {
  for (const double place_K : {302.0, 310.0}) {
    SensorHealth health = settled(4);
    std::vector<HealthUpdate> updates(4, {true, 0.0, 0, 300.0, 0.0});
    health.note_update(updates);
    updates[0] = {true, 40.0, 0, 302.0, 2.0};           // at its place others expect 300 K
    updates[2] = {true, 38.0, 0, place_K - 2.0, -2.0};  // at its place place_K
    const HealthVerdict verdict = health.note_update(updates);
    const bool swapped = place_K == 302.0;
    EXPECT_EQ(verdict.failed, swapped ? 0 : -1) << "evidence that is as large against another waits";
    EXPECT_EQ(verdict.partner, swapped ? 2 : -1);
    for (const std::size_t channel : {0U, 2U}) {
      EXPECT_EQ(health.record(channel).fault, swapped ? HealthFault::swapped : HealthFault::none);
    }
    EXPECT_EQ(health.record(0).partner, swapped ? 2 : -1);
  }
}

TEST(Isolation, what_has_come_slowly_is_a_drift_even_where_it_fits_the_place_of_a_neighbour) {
  for (const double rise_s : {60.0, 600.0}) {
    Drive drive(drive_seed);
    drive.run_until(1000.0);
    spend_first_verdict(drive.health, 6);
    drive.run_until(1200.0);
    std::vector<HealthUpdate> updates(6, {true, 0.0, 0, 300.0, 0.0});
    updates[0] = {true, 20.0, 0, 300.9, 0.9};
    updates[1] = {true, 10.0, 0, 300.0, -0.75};
    std::vector<HealthUpdate> calm(6, {true, 0.0, 0, 300.0, 0.0});
    drive.health.note_update(calm);
    drive.run_until(1200.0 + rise_s);
    drive.health.note_update(updates);
    updates[0].evidence = 40.0;
    const HealthVerdict verdict = drive.health.note_update(updates);
    EXPECT_EQ(verdict.failed, 0);
    EXPECT_EQ(verdict.partner, rise_s < 120.0 ? 1 : -1);
  }
}

TEST(Isolation, what_the_estimator_rejects_is_implausible_and_may_return) {
  Drive drive(drive_seed);
  drive.run_until(1000.0);
  spend_first_verdict(drive.health, 6);
  drive.run_until(1200.0);
  std::vector<HealthUpdate> updates(6, {true, 0.0, 0});
  updates[4] = {true, 35.0, 2};
  EXPECT_EQ(drive.health.note_update(updates).failed, 4);
  EXPECT_EQ(drive.health.record(4).fault, HealthFault::implausible);
  drive.run_until(1600.0);
  EXPECT_EQ(drive.health.record(4).state, HealthState::good);
}

}  // namespace health_isolation_test
}  // namespace spindle_twin::correction::test
