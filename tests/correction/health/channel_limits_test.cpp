#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "correction/health/channel.hpp"

namespace spindle_twin::correction::test {
namespace health_channel_limits_test {

constexpr double open_wire_K = 1123.15;

HealthChannel plain_channel() {
  HealthChannel plan;
  plan.configured = true;
  return plan;
}

/// One channel, sample by sample, without noise.
struct Fed {
  explicit Fed(const HealthLimits& limits = {}, const HealthChannel& plan = plain_channel()) : channel(plan, limits) {}
  void feed(double reading_K, double h_s = 1.0) {
    time_s += h_s;
    channel.take({true, reading_K, predicted_K, moved_K, std::nan(""), offset_K}, time_s, h_s);
    channel.judge();
  }
  void feed_for(int seconds, double reading_K) {
    for (int k = 0; k < seconds; ++k) feed(reading_K);
  }
  /// Samples at this reading until the channel is good again; 0: not within 1000.
  int samples_to_return(double reading_K) {
    for (int k = 1; k <= 1000; ++k) {
      feed(reading_K);
      if (record().state == HealthState::good) return k;
    }
    return 0;
  }
  const HealthRecord& record() const { return channel.record(); }
  Channel channel;
  double time_s = 0.0, predicted_K = 300.0, moved_K = 0.0, offset_K = 0.0;
};

TEST(Channel, that_reads_right_again_returns_after_exactly_its_probation) {
  Fed fed;
  fed.feed_for(200, 300.0);
  EXPECT_EQ(fed.record().since_s, 0.0) << "good from the start";
  fed.feed(open_wire_K);
  EXPECT_EQ(fed.record().since_s, 201.0);
  EXPECT_EQ(fed.record().state, HealthState::suspect);
  fed.feed(open_wire_K);
  fed.feed(open_wire_K);
  EXPECT_EQ(fed.record().state, HealthState::failed);
  EXPECT_EQ(fed.record().since_s, 202.0);
  fed.feed(300.0);
  EXPECT_EQ(fed.record().state, HealthState::returning);
  EXPECT_EQ(fed.samples_to_return(300.0), 299);
  EXPECT_TRUE(fed.record().usable);
  EXPECT_TRUE(fed.record().returned);
  EXPECT_EQ(fed.record().fault, HealthFault::none);
  EXPECT_EQ(fed.record().failures, 1);
  fed.feed(300.0);
  EXPECT_FALSE(fed.record().returned);
  EXPECT_TRUE(fed.record().usable);
}

TEST(Channel, that_shows_its_fault_again_begins_its_probation_anew) {
  Fed fed;
  fed.feed_for(200, 300.0);
  fed.feed_for(3, open_wire_K);
  fed.feed_for(200, 300.0);
  fed.feed(open_wire_K);
  EXPECT_EQ(fed.samples_to_return(300.0), 300);
  EXPECT_EQ(fed.record().failures, 1);
}

TEST(Channel, that_returns_elsewhere_has_its_offset_opened_by_as_much_besides) {
  for (const double off_K : {0.0, 1.5, -1.5}) {
    Fed fed;
    fed.predicted_K = 310.0;
    fed.feed_for(200, 300.0);
    fed.feed_for(3, open_wire_K);
    EXPECT_GT(fed.samples_to_return(300.0 + off_K), 0);
    EXPECT_NEAR(fed.record().return_offset_deviation_K, 0.2 + std::abs(off_K), 1e-9);
    // What it was before counts no more: the next time it is held against its new course.
    fed.feed_for(200, 300.0 + off_K);
    fed.feed_for(3, open_wire_K);
    EXPECT_GT(fed.samples_to_return(300.0 + off_K), 0);
    EXPECT_NEAR(fed.record().return_offset_deviation_K, 0.2, 1e-9);
  }
}

TEST(Channel, whose_offset_nobody_learns_returns_up_to_its_limit_off_its_old_course) {
  HealthLimits limits;
  limits.return_within_K = 0.5;
  for (const double off_K : {0.0, 0.49, 0.51, -0.49, -0.51}) {
    Fed fed(limits);
    fed.predicted_K = 310.0;
    fed.feed_for(200, 300.0);
    fed.feed_for(3, open_wire_K);
    EXPECT_EQ(fed.samples_to_return(300.0 + off_K) > 0, std::abs(off_K) < 0.5) << off_K;
  }
}

TEST(Channel, that_was_implausible_returns_within_a_jump_of_its_old_course) {
  for (const double within_K : {0.1, 0.5, 1e9}) {
    HealthLimits limits;
    limits.return_within_K = within_K;
    const double limit_K = std::min(0.3, within_K);
    for (const double off_K : {0.9 * limit_K, 1.1 * limit_K, -1.1 * limit_K}) {
      Fed fed(limits);
      fed.predicted_K = 310.0;
      fed.feed_for(200, 300.0);
      fed.channel.fail_by_evidence(HealthFault::implausible, 20.0, 0.01, false);
      EXPECT_EQ(fed.samples_to_return(300.0 + off_K) > 0, std::abs(off_K) < limit_K) << within_K << ' ' << off_K;
    }
  }
}

TEST(Channel, that_was_implausible_returns_elsewhere_too_where_its_misfit_has_gone) {
  for (const bool gone : {false, true}) {
    Fed fed;
    fed.feed_for(200, 300.0);
    fed.channel.fail_by_evidence(HealthFault::implausible, 2.0, 0.5, false);
    fed.predicted_K = 299.5;
    fed.offset_K = gone ? 1.4 : 0.0;  // as the estimator knows it now
    EXPECT_EQ(fed.samples_to_return(300.9) > 0, gone);
  }
}

TEST(Channel, that_was_swapped_or_failed_for_good_waits_for_the_acknowledgement) {
  Fed swapped, latched, own;
  for (Fed* fed : {&swapped, &latched, &own}) fed->feed_for(200, 300.0);
  swapped.channel.fail_swapped(3);
  EXPECT_EQ(swapped.record().partner, 3);
  latched.channel.fail(HealthFault::implausible, true);
  own.channel.fail(HealthFault::implausible, false);
  EXPECT_GT(own.samples_to_return(300.0), 0);
  for (Fed* fed : {&swapped, &latched}) {
    EXPECT_EQ(fed->samples_to_return(300.0), 0);
    EXPECT_EQ(fed->record().state, HealthState::failed);
    EXPECT_TRUE(fed->channel.kept().latched);
    fed->channel.acknowledge();
    EXPECT_EQ(fed->record().failures, 0);
    EXPECT_EQ(fed->samples_to_return(300.0), 1) << "it has shown no sign of a fault for long";
    EXPECT_EQ(fed->record().partner, -1);
    EXPECT_FALSE(fed->channel.kept().latched);
  }
}

TEST(Channel, that_was_stuck_shows_its_fault_while_it_repeats_itself_and_another_does_not) {
  for (const HealthFault fault : {HealthFault::stuck, HealthFault::jump}) {
    Fed fed;
    for (int k = 0; k < 200; ++k) fed.feed(k % 2 == 0 ? 300.0 : 300.05);
    fed.channel.fail(fault, false);
    EXPECT_EQ(fed.samples_to_return(300.0) > 0, fault == HealthFault::jump);
  }
}

TEST(Channel, of_which_nothing_is_said_is_one_with_the_usual_sensor) {
  const HealthChannel usual;
  EXPECT_FALSE(usual.configured);
  EXPECT_EQ(usual.resolution_K, 0.01);
  EXPECT_EQ(usual.noise_K, 0.03);
  EXPECT_EQ(usual.interval_s, 0.0);
}

TEST(Channel, resumes_with_as_many_failures_as_it_had) {
  for (const int failures : {0, 1, 2, 3}) {
    for (const HealthFault fault : {HealthFault::none, HealthFault::open, HealthFault::swapped}) {
      Channel channel(plain_channel(), {});
      const bool is_out = fault != HealthFault::none;
      channel.resume({fault, fault == HealthFault::swapped, is_out ? 2 : -1, failures}, 0.0);
      EXPECT_EQ(channel.record().failures, is_out ? std::max(failures, 1) : failures);
      EXPECT_EQ(channel.record().state, is_out ? HealthState::failed : HealthState::good);
      EXPECT_EQ(channel.record().since_s, 0.0);
      EXPECT_FALSE(channel.record().usable);
      EXPECT_FALSE(channel.record().returned);
      EXPECT_EQ(channel.kept().fault, fault);
      EXPECT_EQ(channel.kept().partner, is_out ? 2 : -1);
      EXPECT_EQ(channel.kept().failures, channel.record().failures);
      EXPECT_EQ(channel.kept().latched, is_out && (fault == HealthFault::swapped || failures >= 3));
    }
  }
}

TEST(Channel, was_away_after_half_a_minute_without_a_reading_or_with_a_broken_wire) {
  for (const bool reads_open : {false, true}) {
    for (const int away_s : {29, 30}) {
      Fed fed;
      fed.feed_for(200, 300.0);
      EXPECT_FALSE(fed.channel.was_away());
      for (int k = 0; k < away_s; ++k) {
        fed.channel.take({reads_open, open_wire_K, 300.0, 0.0, std::nan("")}, fed.time_s += 1.0, 1.0);
        fed.channel.judge();
        EXPECT_FALSE(fed.channel.was_away());
      }
      fed.feed(300.0);
      EXPECT_EQ(fed.channel.was_away(), away_s == 30) << reads_open;
      fed.feed(300.0);
      EXPECT_FALSE(fed.channel.was_away()) << "the first one only";
    }
  }
}

TEST(Channel, nothing_is_known_of_the_course_after_half_a_minute_or_five_intervals_without_a_reading) {
  for (const double interval_s : {0.0, 20.0}) {
    const double gap_s = interval_s > 0.0 ? 100.0 : 30.0;
    for (const double waited_s : {gap_s, gap_s + 0.5}) {
      HealthChannel plan = plain_channel();
      plan.interval_s = interval_s;
      Fed fed({}, plan);
      for (int k = 0; k < 50; ++k) fed.feed(300.0, 10.0);
      fed.feed(305.0, waited_s);
      EXPECT_EQ(fed.record().state, waited_s > gap_s ? HealthState::good : HealthState::suspect) << waited_s;
    }
  }
}

TEST(Channel, samples_without_a_number_are_time_of_the_next_one) {
  for (const int missing : {20, 40}) {
    Fed fed;
    fed.feed_for(100, 300.0);
    for (int k = 0; k < missing; ++k) {
      fed.time_s += 1.0;
      fed.channel.take({k % 2 == 0, std::nan(""), 300.0, 0.0, std::nan("")}, fed.time_s, 1.0);
      fed.channel.judge();
      EXPECT_FALSE(fed.channel.reads());
      EXPECT_FALSE(fed.record().usable);
    }
    EXPECT_EQ(fed.channel.elapsed_s(), missing);
    fed.feed(305.0);
    EXPECT_EQ(fed.channel.elapsed_s(), 0.0);
    EXPECT_EQ(fed.record().state == HealthState::good, missing > 30) << missing;
  }
}

TEST(Channel, that_is_not_configured_is_never_used) {
  Fed fed({}, HealthChannel{});
  fed.feed_for(10, 300.0);
  EXPECT_FALSE(fed.channel.in_use());
  EXPECT_FALSE(fed.channel.reads());
  EXPECT_FALSE(fed.record().usable);
}

/// Two places whose models have moved far apart; at 100 s their sensors are swapped, the second `late` samples later.
struct Crossed {
  explicit Crossed(int late, double miss_K = 0.0) {
    for (int k = 0; k < 110 && !found; ++k) {
      const double one_K = 300.0 + 0.05 * k, other_K = 310.0 - 0.02 * k;
      const double one_reads_K = k < 100 ? one_K : other_K + miss_K, other_reads_K = k < 100 + late ? other_K : one_K;
      one.take({true, one_reads_K, 300.0, k > 0 ? 0.05 : 0.0, std::nan("")}, k, 1.0);
      other.take({true, other_reads_K, 310.0, k > 0 ? -0.02 : 0.0, std::nan("")}, k, 1.0);
      found = one.swapped_courses_with(other);
      EXPECT_EQ(found, other.swapped_courses_with(one));
      if (found) at = k;
      one.judge();
      other.judge();
    }
  }
  Channel one{plain_channel(), {}}, other{plain_channel(), {}};
  bool found = false;
  int at = -1;
};

TEST(Channel, two_that_go_over_to_each_others_course_are_told_with_the_third_sample_of_the_first) {
  EXPECT_EQ(Crossed(0).at, 102);
  EXPECT_EQ(Crossed(1).at, 102) << "one has been off three times";
  EXPECT_EQ(Crossed(0, 2.0).at, -1) << "one goes elsewhere";
  EXPECT_EQ(Crossed(100).at, -1) << "one stays";
}

/// A reading as it comes: noise, and steps of the resolution.
struct NoisyReadings {
  double operator()(double place_K) { return 0.01 * std::round((place_K + noise_K(random)) / 0.01); }
  std::mt19937_64 random;
  std::normal_distribution<double> noise_K{0.0, 0.03};
};

/// A place that stands still, then moves by so much between two readings, and how its sensor follows it.
struct Moving {
  double interval_s, step_K;
  int still, moving;  ///< readings
  double lag_s;
};

bool is_taken_for_stuck(const Moving& place, NoisyReadings& read) {
  Fed fed;
  double place_K = 300.0, sensor_K = 300.0;
  for (int k = 0; k < place.still + place.moving && fed.record().state != HealthState::failed; ++k) {
    fed.moved_K = k < place.still ? 0.0 : place.step_K;
    place_K += fed.moved_K;
    sensor_K += (place.lag_s > 0.0 ? 1.0 - std::exp(-place.interval_s / place.lag_s) : 1.0) * (place_K - sensor_K);
    fed.feed(read(sensor_K), place.interval_s);
  }
  return fed.record().state == HealthState::failed && fed.record().fault == HealthFault::stuck;
}

int taken_for_stuck(int places, const Moving& place, std::uint64_t seed) {
  NoisyReadings read{std::mt19937_64(seed)};
  int stuck = 0;
  for (int i = 0; i < places; ++i) stuck += is_taken_for_stuck(place, read) ? 1 : 0;
  return stuck;
}

/// A place warms by 0.04 K/s at once, and the sensor is 30 s late: by chance its readings may have stood for half a
/// minute just then.
TEST(Channel, that_follows_its_place_half_a_minute_late_is_not_stuck) {
  for (const std::uint64_t seed : {20261128u, 1u}) {
    EXPECT_EQ(taken_for_stuck(30000, {5.0, 0.2, 24, 12, 30.0}, seed), 0) << "seed " << seed;
  }
}

/// Read every ten seconds, a place that cools by 0.0035 K/s may by chance give four equal readings.
TEST(Channel, that_is_read_seldom_is_not_stuck_because_a_few_readings_agree) {
  for (const std::uint64_t seed : {20261128u, 1u}) {
    EXPECT_EQ(taken_for_stuck(3000, {10.0, -0.035, 20, 60, 0.0}, seed), 0) << "seed " << seed;
  }
}

/// The coolant's flow drops: the jacket warms by up to 0.05 K/s for minutes, and the model knows nothing of it. Where
/// it is slow the third outlier may by its noise lie too near the first one: some 2 in 100; 9 where the course began
/// anew as if the place stood still.
TEST(Channel, whose_place_warms_and_goes_on_has_not_jumped) {
  constexpr int places = 1000;
  for (const std::uint64_t seed : {20261128u, 1u}) {
    NoisyReadings read{std::mt19937_64(seed)};
    std::uniform_real_distribution<double> rate_K_per_s(0.02, 0.05);
    int failed = 0;
    for (int place = 0; place < places; ++place) {
      Fed fed;
      for (int k = 0; k < 60; ++k) fed.feed(read(300.0), 5.0);
      const double rate = rate_K_per_s(read.random), tau_s = 200.0;
      for (int k = 1; k <= 60; ++k) {
        fed.feed(read(300.0 + rate * tau_s * (1.0 - std::exp(-5.0 * k / tau_s))), 5.0);
        if (fed.record().state != HealthState::failed) continue;
        ++failed;
        break;
      }
    }
    EXPECT_LE(failed, places / 25) << "seed " << seed;
  }
}

}  // namespace health_channel_limits_test
}  // namespace spindle_twin::correction::test
