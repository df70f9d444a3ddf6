#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tests/correction/health/drive.hpp"

/// Two sensors that are swapped are read for each other's places, until somebody acknowledges.
namespace spindle_twin::correction::test {
namespace health_read_for_partner_test {

/// Channels 3 and 4 are swapped until `swapped` is false.
struct Swapped {
  explicit Swapped(std::uint64_t seed, HealthLimits limits = {}) : drive(seed, limits) {
    drive.tamper = [this](std::vector<HealthSample>& samples) {
      if (swapped) std::swap(samples[3].reading_K, samples[4].reading_K);
      if (tamper) tamper(samples);
    };
  }
  bool found() {
    while (drive.failed() == 0 && drive.time_s < 7200.0) drive.step();
    drive.run_until(drive.time_s + 10.0);
    return drive.failed() == 2;
  }
  void go_on(double for_s) { drive.run_until(drive.time_s + for_s); }
  bool crossed() const { return drive.health.reader_of(3) == 4 && drive.health.reader_of(4) == 3; }
  bool own() const { return drive.health.reader_of(3) == 3 && drive.health.reader_of(4) == 4; }

  Drive drive;
  bool swapped = true;
  std::function<void(std::vector<HealthSample>&)> tamper;
};

TEST(ReadForPartner, two_that_move_like_each_others_places_are_and_no_other_is) {
  for (std::uint64_t n = 0; n < 5; ++n) {
    Swapped run(drive_seed + n);
    EXPECT_TRUE(run.own());
    ASSERT_TRUE(run.found()) << n;
    EXPECT_TRUE(run.crossed()) << n;
    for (const std::size_t i : {0U, 1U, 2U, 5U}) EXPECT_EQ(run.drive.health.reader_of(i), i);
    for (const std::size_t i : {3U, 4U}) {
      EXPECT_TRUE(run.drive.health.record(i).read_for_partner);
      EXPECT_FALSE(run.drive.health.record(i).usable) << "for its own place";
      EXPECT_TRUE(run.drive.health.kept(i).read_for_partner);
    }
  }
}

TEST(ReadForPartner, none_is_where_that_is_not_wanted) {
  HealthLimits limits;
  limits.read_swapped = false;
  Swapped run(drive_seed, limits);
  ASSERT_TRUE(run.found());
  EXPECT_TRUE(run.own());
}

TEST(ReadForPartner, a_reading_that_shows_another_fault_is_not_used_and_a_broken_wire_ends_it) {
  Swapped run(drive_seed);
  ASSERT_TRUE(run.found());
  run.tamper = [](std::vector<HealthSample>& samples) { samples[4].reading_K += 5.0; };
  run.go_on(1.0);
  EXPECT_FALSE(run.drive.health.record(4).read_for_partner) << "a spike";
  EXPECT_TRUE(run.drive.health.record(3).read_for_partner);
  run.tamper = nullptr;
  run.go_on(30.0);
  EXPECT_TRUE(run.drive.health.record(4).read_for_partner);
  run.tamper = [](std::vector<HealthSample>& samples) { samples[4].present = false; };
  run.go_on(1.0);
  EXPECT_FALSE(run.drive.health.record(4).read_for_partner) << "no reading";
  EXPECT_TRUE(run.crossed());
  run.tamper = [](std::vector<HealthSample>& samples) { samples[4].reading_K = 1123.15; };
  run.go_on(5.0);
  EXPECT_EQ(run.drive.health.record(4).fault, HealthFault::open);
  EXPECT_EQ(run.drive.health.reader_of(3), 3U);
  EXPECT_FALSE(run.drive.health.record(4).read_for_partner);
}

TEST(ReadForPartner, ends_with_the_acknowledgement_and_who_was_mended_stays_good) {
  Swapped run(drive_seed);
  ASSERT_TRUE(run.found());
  run.swapped = false;
  run.drive.health.acknowledge();
  run.go_on(10.0);
  EXPECT_TRUE(run.own());
  EXPECT_FALSE(run.drive.health.record(3).read_for_partner);
  run.go_on(600.0);
  EXPECT_EQ(run.drive.failed(), 0);
  run.go_on(4.0 * 3600.0);
  EXPECT_EQ(run.drive.failed(), 0);
}

TEST(ReadForPartner, what_was_seen_before_it_was_mended_counts_no_more) {
  HealthLimits limits;
  limits.swap_limit = 1e9;  // only a contradiction makes it a verdict
  Swapped run(drive_seed, limits);
  run.go_on(7200.0);
  ASSERT_EQ(run.drive.health.note_contradiction().failed, 3);
  run.swapped = false;
  run.drive.health.acknowledge();
  run.go_on(310.0);
  ASSERT_EQ(run.drive.failed(), 0) << "its probation is over";
  EXPECT_EQ(run.drive.health.note_contradiction().failed, -1);
}

TEST(ReadForPartner, who_was_not_mended_is_found_again) {
  Swapped run(drive_seed);
  ASSERT_TRUE(run.found());
  run.drive.health.acknowledge();
  run.go_on(7200.0);
  EXPECT_EQ(run.drive.failed(), 2);
  EXPECT_TRUE(run.crossed());
}

TEST(ReadForPartner, ends_where_the_others_contradict_it_behind_the_time_in_which_the_estimate_settles) {
  for (const std::size_t contradicted : {3U, 4U, 0U}) {
    Swapped run(drive_seed);
    ASSERT_TRUE(run.found());
    std::vector<HealthUpdate> updates(6, {true, 0.0, 0});
    run.drive.health.note_update(updates);  // tells of the pair
    updates[contradicted].evidence = 31.0;
    run.go_on(600.0);
    EXPECT_EQ(run.drive.health.note_update(updates).partner, -1);
    EXPECT_TRUE(run.crossed()) << "it settles";
    run.go_on(400.0);
    updates[contradicted].evidence = 29.0;
    EXPECT_EQ(run.drive.health.note_update(updates).partner, -1);
    updates[contradicted].evidence = 31.0;
    const HealthVerdict verdict = run.drive.health.note_update(updates);
    const bool one_of_them = contradicted != 0;
    EXPECT_EQ(verdict.partner, one_of_them ? static_cast<int>(7 - contradicted) : -1);
    EXPECT_EQ(run.own(), one_of_them);
    EXPECT_EQ(run.drive.health.record(3).fault, HealthFault::swapped);
    EXPECT_EQ(run.drive.health.kept(3).read_for_partner, !one_of_them);
    EXPECT_EQ(run.drive.health.note_update(updates).partner, -1) << "told once";
  }
}

TEST(ReadForPartner, ends_with_a_contradiction_behind_that_time) {
  Swapped run(drive_seed);
  ASSERT_TRUE(run.found());
  EXPECT_EQ(run.drive.health.note_contradiction().failed, -1) << "it settles";
  run.go_on(1000.0);
  const HealthVerdict verdict = run.drive.health.note_contradiction();
  EXPECT_EQ(verdict.failed, 3);
  EXPECT_EQ(verdict.partner, 4);
  EXPECT_TRUE(run.own());
  EXPECT_EQ(run.drive.failed(), 2);
}

TEST(ReadForPartner, two_that_only_others_say_are_swapped_are_not) {
  SensorHealth health(std::vector<HealthChannel>(4, {true, 253.15, 423.15}), {});
  std::vector<HealthSample> samples(4, {true, 300.0, 300.0});
  for (int t = 0; t <= 1000; ++t) {
    for (HealthSample& sample : samples) sample.reading_K = 300.0 + 0.02 * (t % 2);
    health.step(samples, t, t == 0 ? 0.0 : 1.0);
  }
  std::vector<HealthUpdate> updates(4, {true, 0.0, 0, 300.0, 0.0});
  health.note_update(updates);
  updates[0] = {true, 40.0, 0, 302.0, 2.0};
  updates[2] = {true, 38.0, 0, 300.0, -2.0};
  EXPECT_EQ(health.note_update(updates).partner, 2);
  EXPECT_EQ(health.record(0).fault, HealthFault::swapped);
  EXPECT_EQ(health.reader_of(0), 0U);
}

TEST(ReadForPartner, two_that_a_contradiction_says_are_swapped_are_once_movement_alone_would_say_so) {
  HealthLimits limits;
  limits.swap_limit = 100.0;
  Swapped run(drive_seed, limits);
  while (run.drive.health.note_contradiction().failed < 0 && run.drive.time_s < 7200.0) run.go_on(1.0);
  ASSERT_EQ(run.drive.failed(), 2);
  EXPECT_TRUE(run.own());
  while (run.own() && run.drive.time_s < 7200.0) run.go_on(1.0);
  EXPECT_TRUE(run.crossed());
  EXPECT_EQ(run.drive.health.note_update(std::vector<HealthUpdate>(6, {true, 0.0, 0})).failed, -1)
      << "what the estimator learnt from them is forgotten already";
}

TEST(ReadForPartner, what_was_kept_begins_again_only_where_it_is_wanted) {
  for (const bool wanted : {true, false}) {
    HealthLimits limits;
    limits.read_swapped = wanted;
    SensorHealth health(std::vector<HealthChannel>(3, {true, 253.15, 423.15}), limits);
    health.resume(0, {HealthFault::swapped, true, 2, 1, true}, 0.0);
    health.resume(2, {HealthFault::swapped, true, 0, 1, true}, 0.0);
    EXPECT_EQ(health.reader_of(0), wanted ? 2U : 0U);
  }
}

TEST(ReadForPartner, is_kept_and_wants_both_of_the_pair) {
  for (const bool other_too : {true, false}) {
    SensorHealth health(std::vector<HealthChannel>(3, {true, 253.15, 423.15}), {});
    health.resume(0, {HealthFault::swapped, true, 2, 1, true}, 0.0);
    health.resume(2, {HealthFault::swapped, true, other_too ? 0 : 1, 1, true}, 0.0);
    EXPECT_EQ(health.reader_of(0), other_too ? 2U : 0U);
    EXPECT_TRUE(health.kept(0).read_for_partner);
    EXPECT_EQ(health.reader_of(1), 1U);
  }
}

}  // namespace health_read_for_partner_test
}  // namespace spindle_twin::correction::test
