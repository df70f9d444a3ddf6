#include <gtest/gtest.h>

#include <cmath>

#include "tests/correction/health/drive.hpp"

namespace spindle_twin::correction::test {
namespace health_sensor_health_limits_test {

/// Channels at 300 K that are never silent.
struct AtRest {
  explicit AtRest(std::size_t channels)
      : health(std::vector<HealthChannel>(channels, {true, 253.15, 423.15, 0.01}), {}), samples(channels) {}
  /// The first `leaving` read so much more.
  void run(int seconds, std::size_t leaving = 0, double by_K = 0.0) {
    for (int k = 0; k < seconds; ++k) {
      for (std::size_t i = 0; i < samples.size(); ++i) {
        const double wobble_K = static_cast<int>(time_s) % 2 == 0 ? 0.02 : -0.02;
        samples[i] = {true, 300.0 + wobble_K + (i < leaving ? by_K : 0.0), 300.0};
      }
      health.step(samples, time_s, time_s > 0.0 ? 1.0 : 0.0);
      time_s += 1.0;
    }
  }
  std::size_t failed() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) count += health.record(i).failures > 0 ? 1 : 0;
    return count;
  }
  SensorHealth health;
  std::vector<HealthSample> samples;
  double time_s = 0.0;
};

TEST(Health, three_and_more_than_half_that_leave_their_course_at_once_are_followed_and_fewer_fail) {
  struct Case {
    std::size_t channels, leaving;
    bool followed;
  };
  for (const Case& c : {Case{2, 2, false},
                        {3, 2, false},
                        {3, 3, true},
                        {4, 3, true},
                        {5, 3, true},
                        {6, 3, false},
                        {6, 4, true},
                        {7, 3, false},
                        {7, 4, true},
                        {8, 4, false}}) {
    AtRest channels(c.channels);
    channels.run(100);
    channels.run(5, c.leaving, 5.0);
    EXPECT_EQ(channels.failed(), c.followed ? 0U : c.leaving) << c.leaving << " of " << c.channels;
    EXPECT_FALSE(channels.health.model_in_doubt()) << "with the next sample they are on their course";
  }
}

TEST(Health, where_most_are_followed_those_that_stayed_keep_their_course) {
  AtRest channels(6);
  channels.run(100);
  channels.run(1, 4, 5.0);
  EXPECT_TRUE(channels.health.model_in_doubt());
  EXPECT_EQ(channels.health.record(0).state, HealthState::good) << "what is followed is used";
  EXPECT_TRUE(channels.health.record(0).usable);
  channels.run(1, 5, 5.0);  // the fifth goes after them
  EXPECT_EQ(channels.health.record(4).state, HealthState::suspect);
  EXPECT_EQ(channels.health.record(3).state, HealthState::good);
}

HealthVerdict told(AtRest& channels, std::size_t blamed, double misfit_K) {
  std::vector<HealthUpdate> updates(channels.samples.size(), {true, 0.0, 0, 300.0, 0.0, 0.1});
  channels.health.note_update(updates);
  channels.run(300);
  updates[blamed].evidence = 40.0;
  updates[blamed].misfit_K = misfit_K;
  return channels.health.note_update(updates);
}

TEST(Health, a_verdict_names_what_is_to_be_done_and_nothing_else_of_any_channel) {
  for (const std::size_t blamed : {std::size_t{0}, std::size_t{3}}) {
    AtRest channels(4);
    channels.run(1000);
    const int channel = static_cast<int>(blamed);
    const HealthVerdict loosened = told(channels, blamed, 0.3);
    EXPECT_EQ(loosened.suspect, channel);
    EXPECT_TRUE(loosened.loosen);
    EXPECT_EQ(loosened.failed, -1);
    EXPECT_EQ(loosened.partner, -1);
    EXPECT_EQ(loosened.opened, -1);
    EXPECT_TRUE(channels.health.model_in_doubt());
    const HealthVerdict opened = told(channels, blamed, 0.3);
    EXPECT_EQ(opened.opened, channel);
    EXPECT_FALSE(opened.loosen);
    EXPECT_EQ(opened.failed, -1);
    EXPECT_EQ(opened.partner, -1);
    EXPECT_EQ(opened.suspect, -1);
    const HealthVerdict failed = told(channels, blamed, 0.3);
    EXPECT_EQ(failed.failed, channel);
    EXPECT_FALSE(failed.loosen);
    EXPECT_EQ(failed.partner, -1);
    EXPECT_EQ(failed.suspect, -1);
    EXPECT_EQ(failed.opened, -1);
    EXPECT_EQ(channels.health.record(blamed).fault, HealthFault::drift);
    EXPECT_EQ(channels.health.record(blamed).partner, -1);
  }
}

TEST(Health, a_suspect_of_any_number_has_its_offset_opened_and_then_fails_for_good) {
  for (const int channel : {0, 3}) {
    AtRest channels(4);
    channels.run(1000);
    const HealthVerdict opened = channels.health.note_suspect(channel, 0.5, 0.1);
    EXPECT_EQ(opened.opened, channel);
    EXPECT_EQ(opened.failed, -1);
    EXPECT_EQ(opened.partner, -1);
    EXPECT_EQ(opened.suspect, -1);
    EXPECT_FALSE(opened.loosen);
    const HealthVerdict failed = channels.health.note_suspect(channel, 0.5, 0.1);
    EXPECT_EQ(failed.failed, channel);
    EXPECT_EQ(failed.partner, -1);
    EXPECT_EQ(failed.opened, -1);
    channels.run(590, 4, 0.5);  // its misfit stays, and is looked at for ten minutes
    EXPECT_FALSE(channels.health.kept(static_cast<std::size_t>(channel)).latched);
    channels.run(20, 4, 0.5);
    EXPECT_TRUE(channels.health.kept(static_cast<std::size_t>(channel)).latched);
  }
}

TEST(Health, of_channels_in_use_those_alone_are_judged_that_the_estimator_has_taken) {
  AtRest channels(4);
  EXPECT_FALSE(channels.health.model_in_doubt()) << "before anything is known";
  channels.run(1000);
  std::vector<HealthUpdate> updates(4, {true, 0.0, 0, 300.0, 0.0, 0.1});
  channels.health.note_update(updates);
  EXPECT_FALSE(channels.health.model_in_doubt()) << "unless the estimator says so";
  updates[1].evidence = 40.0;
  updates[2].taken = updates[3].taken = false;
  EXPECT_FALSE(channels.health.note_update(updates).loosen) << "of two nobody knows which";
  updates[3].taken = true;
  EXPECT_TRUE(channels.health.note_update(updates).loosen);
}

TEST(Health, the_first_channel_is_swapped_as_any_other) {
  for (int n = 0; n < 3; ++n) {
    Drive drive(drive_seed + static_cast<std::uint64_t>(n));
    drive.tamper = [](std::vector<HealthSample>& samples) { std::swap(samples[0].reading_K, samples[4].reading_K); };
    while (drive.failed() == 0 && drive.time_s < 7200.0) drive.step();
    EXPECT_EQ(drive.health.record(0).fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.record(0).partner, 4) << n;
    EXPECT_EQ(drive.health.record(4).partner, 0) << n;
    EXPECT_EQ(drive.failed(), 2) << n;
    const HealthVerdict verdict = drive.health.note_update(std::vector<HealthUpdate>(6, {true, 0.0, 0}));
    EXPECT_EQ(verdict.failed, 0) << n;
    EXPECT_EQ(verdict.partner, 4) << n;
  }
}

TEST(Health, two_that_contradict_all_others_are_swapped_whichever_they_are) {
  for (const auto& [blamed, partner] : {std::pair{std::size_t{2}, std::size_t{0}}, {0, 1}, {3, 2}}) {
    AtRest channels(4);
    channels.run(1000);
    spend_first_verdict(channels.health, 4);
    channels.run(200);
    std::vector<HealthUpdate> updates(4, {true, 0.0, 0, 300.0, 0.0, 0.1});
    channels.health.note_update(updates);
    updates[blamed] = {true, 40.0, 0, 302.0, 2.0};
    updates[partner] = {true, 38.0, 0, 300.0, -2.0};
    const HealthVerdict verdict = channels.health.note_update(updates);
    EXPECT_EQ(verdict.failed, static_cast<int>(blamed));
    EXPECT_EQ(verdict.partner, static_cast<int>(partner));
    EXPECT_EQ(channels.health.record(blamed).partner, static_cast<int>(partner));
    EXPECT_EQ(channels.health.record(partner).partner, static_cast<int>(blamed));
  }
}

}  // namespace health_sensor_health_limits_test
}  // namespace spindle_twin::correction::test
