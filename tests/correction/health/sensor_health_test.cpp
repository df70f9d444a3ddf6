#include "correction/health/sensor_health.hpp"

#include <gtest/gtest.h>

#include "tests/correction/health/drive.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace {

constexpr std::uint64_t seed = 20;
constexpr int moments = 40;  // per fault

/// A random moment and channel of the seed's n-th case.
struct Case {
  explicit Case(int number) : drive(seed + static_cast<std::uint64_t>(number)) {
    std::mt19937_64 random(1000 * seed + static_cast<std::uint64_t>(number));
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    channel = static_cast<std::size_t>(6.0 * unit(random));
    from_s = std::floor(600.0 + 1800.0 * unit(random));
    share = unit(random);
    sign = unit(random) < 0.5 ? -1.0 : 1.0;
  }
  const HealthRecord& record() const { return drive.health.records()[channel]; }
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

INSTANTIATE_TEST_SUITE_P(Health, ElectricalFault,
                         testing::Values(Electrical{"open", 1123.15, HealthFault::open},
                                         Electrical{"shorted", 31.0, HealthFault::shorted},
                                         Electrical{"above", 430.0, HealthFault::out_of_range},
                                         Electrical{"below", 240.0, HealthFault::out_of_range}),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(Health, a_jump_of_one_kelvin_or_more_fails_the_channel_within_four_samples) {
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

TEST(Health, one_spike_is_withheld_and_forgiven_and_the_fourth_in_ten_minutes_is_not) {
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

TEST(Health, a_stuck_channel_fails_within_two_minutes_of_a_moving_model) {
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
        EXPECT_EQ(one.record().state, HealthState::failed) << "case " << n << " at " << second << " s";
        break;
      }
    }
    failed += one.record().state == HealthState::failed && one.record().fault == HealthFault::stuck ? 1 : 0;
  }
  EXPECT_GE(failed, 9 * moments / 10) << "places that hardly move may hold out for an hour";
  EXPECT_GE(withheld, 9 * moments / 10) << "twenty equal readings, but of a place that was rising steeply";
}

TEST(Health, a_steady_spindle_read_in_steps_of_a_tenth_raises_nothing_in_a_day) {
  Drive drive(seed, {}, 0.1);
  drive.noise_K = 0.0;
  drive.steady = true;
  int failures = 0;
  for (int second = 0; second < 86400; ++second) {
    drive.step();
    failures += drive.failed();
  }
  EXPECT_EQ(failures, 0);
}

TEST(Health, healthy_drive_cycles_raise_no_alarm_in_a_week) {
  for (const double resolution_K : {0.01, 0.1}) {
    Drive drive(seed + 5, {}, resolution_K);
    long alarms = 0, withheld = 0;
    for (int second = 0; second < 7 * 86400; ++second) {
      drive.step();
      alarms += drive.failed();
      for (const HealthRecord& record : drive.health.records()) withheld += record.usable ? 0 : 1;
    }
    EXPECT_EQ(alarms, 0) << "seed " << seed + 5 << ", resolution " << resolution_K;
    EXPECT_LT(withheld, 6 * 7 * 86400 / 1000) << "one reading in a thousand";
    RecordProperty("withheld_readings_per_day", static_cast<int>(withheld / 7));
  }
}

TEST(Health, swapped_channels_fail_together_and_name_each_other) {
  for (int n = 0; n < 10; ++n) {
    Drive drive(seed + static_cast<std::uint64_t>(n));
    drive.tamper = [](std::vector<HealthSample>& samples) { std::swap(samples[3].reading_K, samples[4].reading_K); };
    drive.run_until(7200.0);
    EXPECT_EQ(drive.health.records()[3].fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.records()[4].fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.records()[3].partner, 4);
    EXPECT_EQ(drive.health.records()[4].partner, 3);
    EXPECT_EQ(drive.failed(), 2) << n;
  }
}

TEST(Health, when_most_channels_leave_their_course_at_once_it_is_not_the_channels) {
  Drive drive(seed);
  drive.run_until(1000.0);
  drive.tamper = [](std::vector<HealthSample>& samples) {
    for (std::size_t i = 0; i < 5; ++i) samples[i].reading_K -= 3.0;
  };
  drive.step();
  EXPECT_TRUE(drive.health.model_in_doubt());
  drive.run_until(1100.0);
  EXPECT_EQ(drive.failed(), 0);
}

TEST(Health, a_repaired_channel_returns_after_its_probation_and_its_offset_is_open) {
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
    if (one.record().returned) offset_K = one.record().return_offset_K;
  }
  EXPECT_EQ(returned, 1);
  EXPECT_EQ(one.record().state, HealthState::good);
  EXPECT_GE(offset_K, one.drive.health.limits().return_offset_K);
}

TEST(Health, without_an_estimator_a_channel_returns_only_to_its_old_course) {
  HealthLimits limits;
  limits.return_within_K = 0.5;
  for (const double stays_off_K : {0.0, 4.0}) {
    Drive drive(seed, limits);
    drive.steady = true;
    drive.tamper = [&](std::vector<HealthSample>& samples) {
      if (drive.time_s >= 4000.0) samples[2].reading_K += drive.time_s < 4100.0 ? 4.0 : stays_off_K;
    };
    drive.run_until(5000.0);
    EXPECT_EQ(drive.health.records()[2].state, stays_off_K > 0.0 ? HealthState::failed : HealthState::good);
  }
}

TEST(Health, the_third_failure_waits_for_the_acknowledgement) {
  Drive drive(seed);
  drive.tamper = [&](std::vector<HealthSample>& samples) {
    const double phase_s = std::fmod(drive.time_s, 1000.0);
    if (drive.time_s >= 1000.0 && drive.time_s < 4000.0 && phase_s < 10.0) samples[1].reading_K = 31.0;
  };
  drive.run_until(2900.0);
  EXPECT_EQ(drive.health.records()[1].state, HealthState::good);
  EXPECT_EQ(drive.health.records()[1].failures, 2);
  drive.run_until(4500.0);
  EXPECT_EQ(drive.health.records()[1].state, HealthState::failed);
  drive.health.acknowledge();
  drive.run_until(4900.0);
  EXPECT_EQ(drive.health.records()[1].state, HealthState::good);
}

TEST(Health, drift_fails_the_channel_that_the_others_contradict_most_and_only_with_three_in_use) {
  for (const std::size_t channels : {std::size_t{2}, std::size_t{3}}) {
    const HealthLimits limits;
    SensorHealth health(std::vector<HealthChannel>(channels, {true, 253.15, 423.15, 0.01}), limits);
    std::vector<HealthUpdate> updates(channels, {true, 3.0, 0});
    updates[1].evidence = limits.drift_limit;
    EXPECT_EQ(health.note_update(updates).failed, -1);
    updates[1].evidence = limits.drift_limit + 1.0;
    EXPECT_EQ(health.note_update(updates).failed, channels == 3 ? 1 : -1);
    if (channels < 3) continue;
    EXPECT_EQ(health.records()[1].fault, HealthFault::drift);
    updates[2].evidence = 100.0;
    EXPECT_EQ(health.note_update(updates).failed, -1) << "two are left";
  }
}

TEST(Health, drift_waits_while_two_channels_look_alike) {
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

TEST(Health, two_that_contradict_the_others_together_are_exchanged_where_each_fits_the_place_of_the_other) {
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
      EXPECT_EQ(health.records()[channel].fault, exchanged ? HealthFault::swapped : HealthFault::none);
    }
    EXPECT_EQ(health.records()[0].partner, exchanged ? 2 : -1);
  }
}

TEST(Health, what_has_come_slowly_is_a_drift_even_where_it_fits_the_place_of_a_neighbour) {
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

TEST(Health, what_the_estimator_rejects_is_implausible_and_may_return) {
  Drive drive(seed);
  drive.run_until(600.0);
  std::vector<HealthUpdate> updates(6, {true, 0.0, 0});
  updates[4] = {true, 35.0, 2};
  EXPECT_EQ(drive.health.note_update(updates).failed, 4);
  EXPECT_EQ(drive.health.records()[4].fault, HealthFault::implausible);
  drive.run_until(1200.0);
  EXPECT_EQ(drive.health.records()[4].state, HealthState::good);
}

TEST(Health, step_never_calls_the_heap) {
  Drive drive(seed);
  drive.run_until(100.0);
  std::vector<HealthUpdate> updates(6, {true, 0.3, 0});
  const long before = rom::tests::heap_calls();
  drive.run_until(1000.0);
  drive.health.note_update(updates);
  drive.health.acknowledge();
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
}

}  // namespace
}  // namespace spindle_twin::correction::test
