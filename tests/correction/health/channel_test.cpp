#include "correction/health/channel.hpp"

#include <gtest/gtest.h>

#include "tests/correction/health/drive.hpp"

namespace spindle_twin::correction::test {
namespace health_channel_test {

constexpr int moments = 40;  // per fault

/// A random moment and channel of the seed's n-th case.
struct Case {
  explicit Case(int number) : drive(drive_seed + static_cast<std::uint64_t>(number)) {
    std::mt19937_64 random(1000 * drive_seed + static_cast<std::uint64_t>(number));
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    channel = static_cast<std::size_t>(6.0 * unit(random));
    from_s = std::floor(600.0 + 1800.0 * unit(random));
    share = unit(random);
    sign = unit(random) < 0.5 ? -1.0 : 1.0;
  }
  const HealthRecord& record() const { return drive.health.record(channel); }
  /// Samples from the fault on until the channel failed, the failing one included; 0 if it does not in `most` samples.
  int samples_to_failure(int most) {
    drive.run_until(from_s);
    for (int k = 1; k <= most; ++k) {
      drive.step();
      if (record().state == HealthState::failed) return k;
    }
    return 0;
  }
  Drive drive;
  std::size_t channel;
  double from_s, share, sign;
};

struct Electrical {
  const char* name;
  double reading_K;
  HealthFault fault;
};

class ElectricalFault : public testing::TestWithParam<Electrical> {};

TEST_P(ElectricalFault, fails_the_channel_within_two_samples_and_is_never_used) {
  for (int n = 0; n < moments; ++n) {
    Case one(n);
    bool used = false;
    one.drive.tamper = [&](std::vector<HealthSample>& samples) {
      if (one.drive.time_s >= one.from_s) samples[one.channel].reading_K = GetParam().reading_K;
    };
    one.drive.run_until(one.from_s);
    for (int k = 1; k <= 4; ++k) {
      one.drive.step();
      used = used || one.record().usable;
      EXPECT_EQ(one.record().state, k < 2 ? HealthState::suspect : HealthState::failed);
    }
    EXPECT_FALSE(used) << n;
    EXPECT_EQ(one.record().fault, GetParam().fault) << n;
    EXPECT_EQ(one.drive.failed(), 1) << n;
  }
}

INSTANTIATE_TEST_SUITE_P(Channel, ElectricalFault,
                         testing::Values(Electrical{"open", 1123.15, HealthFault::open},
                                         Electrical{"shorted", 31.0, HealthFault::shorted},
                                         Electrical{"above", 430.0, HealthFault::out_of_range},
                                         Electrical{"below", 240.0, HealthFault::out_of_range}),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(Channel, a_jump_of_one_kelvin_or_more_fails_the_channel_within_four_samples) {
  for (int n = 0; n < moments; ++n) {
    Case one(n);
    const double jump_K = one.sign * (1.0 + 4.0 * one.share);
    one.drive.tamper = [&](std::vector<HealthSample>& samples) {
      if (one.drive.time_s >= one.from_s) samples[one.channel].reading_K += jump_K;
    };
    one.drive.run_until(one.from_s);
    one.drive.step();
    EXPECT_FALSE(one.record().usable) << "case " << n << ", jump of " << jump_K << " K";
    const int more = one.samples_to_failure(3);
    EXPECT_GT(more, 0) << "case " << n << ", jump of " << jump_K << " K";
    EXPECT_EQ(one.record().fault, HealthFault::jump);
    EXPECT_EQ(one.drive.failed(), 1) << n;
  }
}

TEST(Channel, that_is_read_once_a_minute_fails_by_a_jump_within_four_readings_too) {
  constexpr double interval_s = 60.0;
  SensorHealth health({{true, 253.15, 423.15, 0.01, 0.03, interval_s}}, {});
  std::mt19937_64 random(drive_seed);
  std::normal_distribution<double> noise_K(0.0, 0.03);
  const auto read = [&](int n, double jump_K) {
    health.step({{true, 300.0 + jump_K + noise_K(random), 300.0, 0.0, 300.0}}, n * interval_s,
                n == 0 ? 0.0 : interval_s);
  };
  int n = 0;
  while (n < 60) read(n++, 0.0);
  ASSERT_EQ(health.record(0).state, HealthState::good);
  while (n < 64 && health.record(0).state != HealthState::failed) read(n++, 4.0);
  EXPECT_EQ(health.record(0).state, HealthState::failed);
  EXPECT_EQ(health.record(0).fault, HealthFault::jump);
}

TEST(Channel, one_spike_is_withheld_and_forgiven_and_the_fourth_in_ten_minutes_is_not) {
  Case one(3);
  one.drive.tamper = [&](std::vector<HealthSample>& samples) {
    const double since_s = one.drive.time_s - one.from_s;
    if (since_s >= 0.0 && std::fmod(since_s, 100.0) == 0.0) samples[one.channel].reading_K += 2.0;
  };
  one.drive.run_until(one.from_s);
  for (int spike = 1; spike <= 3; ++spike) {
    one.drive.step();
    EXPECT_EQ(one.record().state, HealthState::suspect);
    EXPECT_FALSE(one.record().usable);
    one.drive.step();
    EXPECT_EQ(one.record().state, HealthState::good);
    EXPECT_TRUE(one.record().usable);
    EXPECT_EQ(one.record().spikes, spike);
    one.drive.run_until(one.from_s + 100.0 * spike);
  }
  one.drive.step();
  one.drive.step();
  EXPECT_EQ(one.record().state, HealthState::failed);
  EXPECT_EQ(one.record().fault, HealthFault::spikes);
}

TEST(Channel, a_stuck_channel_fails_within_two_minutes_of_a_moving_model_and_the_lag_of_a_sensor) {
  int failed = 0;
  int withheld = 0;
  for (int n = 0; n < moments; ++n) {
    Case one(n);
    one.drive.run_until(one.from_s);
    const double held_K = one.drive.samples[one.channel].reading_K;
    one.drive.tamper = [&](std::vector<HealthSample>& samples) { samples[one.channel].reading_K = held_K; };
    for (int k = 0; k < 20; ++k) one.drive.step();
    withheld += one.record().usable ? 0 : 1;
    // The first stretch of two minutes in which the model, corrected or not, moves by a quarter of a kelvin.
    double moved_K = 0.0;
    std::vector<double> free_K;
    std::vector<double> course_K;
    for (int second = 0; second < 3600; ++second) {
      if (one.record().state == HealthState::failed) break;
      one.drive.step();
      moved_K += one.drive.samples[one.channel].moved_K;
      course_K.push_back(moved_K);
      free_K.push_back(one.drive.free_K[one.channel]);
      const std::size_t now = course_K.size() - 1;
      if (now >= 120 && std::abs(course_K[now] - course_K[now - 120]) > 0.25 &&
          std::abs(free_K[now] - free_K[now - 120]) > 0.25) {
        // A late sensor would show it half a minute later.
        for (int k = 0; k < 30 && one.record().state != HealthState::failed; ++k) one.drive.step();
        EXPECT_EQ(one.record().state, HealthState::failed) << "case " << n << " at " << second << " s";
        break;
      }
    }
    failed += one.record().state == HealthState::failed && one.record().fault == HealthFault::stuck ? 1 : 0;
  }
  EXPECT_GE(failed, 9 * moments / 10) << "places that hardly move may hold out for an hour";
  EXPECT_GE(withheld, 9 * moments / 10) << "twenty equal readings, but of a place that was rising steeply";
}

TEST(Channel, a_channel_that_never_moved_stays_out_until_it_does) {
  int failed = 0, returned = 0;
  for (int n = 0; n < moments; ++n) {
    Case one(n);
    one.drive.step();
    const double held_K = one.drive.samples[one.channel].reading_K;
    one.drive.tamper = [&](std::vector<HealthSample>& samples) { samples[one.channel].reading_K = held_K; };
    for (int second = 0; second < 3600 && one.record().state != HealthState::failed; ++second) one.drive.step();
    if (one.record().fault != HealthFault::stuck) continue;
    ++failed;
    for (int second = 0; second < 3600; ++second) {
      one.drive.step();
      ASSERT_FALSE(one.record().usable) << "case " << n << ", " << second << " s after the verdict";
    }
    one.drive.tamper = {};
    for (int second = 0; second < 1200 && !one.record().usable; ++second) one.drive.step();
    returned += one.record().usable ? 1 : 0;
  }
  EXPECT_GE(failed, moments / 2);
  EXPECT_GE(returned, 9 * failed / 10);
}

TEST(Channel, a_repaired_channel_returns_after_its_probation_and_its_offset_is_open) {
  Case one(7);
  one.drive.tamper = [&](std::vector<HealthSample>& samples) {
    const double since_s = one.drive.time_s - one.from_s;
    if (since_s >= 0.0 && since_s < 500.0) samples[one.channel].reading_K = 1123.15;
  };
  one.drive.run_until(one.from_s + 500.0);
  EXPECT_EQ(one.record().state, HealthState::failed);
  one.drive.run_until(one.from_s + 500.0 + 100.0);
  EXPECT_EQ(one.record().state, HealthState::returning);
  int returned = 0;
  double offset_K = 0.0;
  while (one.drive.time_s < one.from_s + 500.0 + 320.0) {
    one.drive.step();
    returned += one.record().returned ? 1 : 0;
    if (one.record().returned) offset_K = one.record().return_offset_deviation_K;
  }
  EXPECT_EQ(returned, 1);
  EXPECT_EQ(one.record().state, HealthState::good);
  EXPECT_GE(offset_K, one.drive.health.limits().return_offset_deviation_K);
}

TEST(Channel, without_an_estimator_a_channel_returns_only_to_its_old_course) {
  HealthLimits limits;
  limits.return_within_K = 0.5;
  for (const double stays_off_K : {0.0, 4.0}) {
    Drive drive(drive_seed, limits);
    drive.steady = true;
    drive.tamper = [&](std::vector<HealthSample>& samples) {
      if (drive.time_s >= 4000.0) samples[2].reading_K += drive.time_s < 4100.0 ? 4.0 : stays_off_K;
    };
    drive.run_until(5000.0);
    EXPECT_EQ(drive.health.record(2).state, stays_off_K > 0.0 ? HealthState::failed : HealthState::good);
  }
}

TEST(Channel, the_third_failure_waits_for_the_acknowledgement) {
  Drive drive(drive_seed);
  drive.tamper = [&](std::vector<HealthSample>& samples) {
    const double phase_s = std::fmod(drive.time_s, 1000.0);
    if (drive.time_s >= 1000.0 && drive.time_s < 4000.0 && phase_s < 10.0) samples[1].reading_K = 31.0;
  };
  drive.run_until(2900.0);
  EXPECT_EQ(drive.health.record(1).state, HealthState::good);
  EXPECT_EQ(drive.health.record(1).failures, 2);
  drive.run_until(4500.0);
  EXPECT_EQ(drive.health.record(1).state, HealthState::failed);
  drive.health.acknowledge();
  drive.run_until(4900.0);
  EXPECT_EQ(drive.health.record(1).state, HealthState::good);
}

}  // namespace health_channel_test
}  // namespace spindle_twin::correction::test
