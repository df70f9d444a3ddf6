#include "correction/health/sensor_health.hpp"

#include <gtest/gtest.h>

#include "tests/correction/health/drive.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace health_sensor_health_test {

TEST(Health, a_steady_spindle_read_in_steps_of_a_tenth_raises_nothing_in_a_day) {
  Drive drive(drive_seed, {}, 0.1);
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
    Drive drive(drive_seed + 5, {}, resolution_K);
    long alarms = 0, withheld = 0;
    for (int second = 0; second < 7 * 86400; ++second) {
      drive.step();
      alarms += drive.failed();
      for (std::size_t i = 0; i < Drive::places; ++i) withheld += drive.health.record(i).usable ? 0 : 1;
    }
    EXPECT_EQ(alarms, 0) << "seed " << drive_seed + 5 << ", resolution " << resolution_K;
    EXPECT_LT(withheld, 6 * 7 * 86400 / 1000) << "one reading in a thousand";
    RecordProperty("withheld_readings_per_day", static_cast<int>(withheld / 7));
  }
}

TEST(Health, swapped_channels_fail_together_and_name_each_other) {
  for (int n = 0; n < 10; ++n) {
    Drive drive(drive_seed + static_cast<std::uint64_t>(n));
    drive.tamper = [](std::vector<HealthSample>& samples) { std::swap(samples[3].reading_K, samples[4].reading_K); };
    drive.run_until(7200.0);
    EXPECT_EQ(drive.health.record(3).fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.record(4).fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.record(3).partner, 4);
    EXPECT_EQ(drive.health.record(4).partner, 3);
    EXPECT_EQ(drive.failed(), 2) << n;
  }
}

TEST(Health, a_channel_that_is_silent_or_out_of_use_has_no_voice_in_what_most_do) {
  // Three of six leave their course at once: with the sixth that is half of them, without it more than half.
  enum class Sixth { reads, silent, failed };
  for (const Sixth sixth : {Sixth::reads, Sixth::silent, Sixth::failed}) {
    SensorHealth health(std::vector<HealthChannel>(6, {true, 253.15, 423.15, 0.01}), {});
    std::vector<HealthSample> samples(6);
    bool together = false;
    for (int t = 0; t < 100; ++t) {
      for (std::size_t i = 0; i < 6; ++i) {
        samples[i].present = true;
        samples[i].reading_K = 300.0 + 0.02 * (t % 2) + (t >= 90 && i < 3 ? 5.0 : 0.0);
        samples[i].predicted_K = samples[i].uncorrected_K = 300.0;
      }
      samples[5].present = sixth != Sixth::silent || t < 90;
      if (sixth == Sixth::failed && t >= 50) samples[5].reading_K = t < 80 ? 900.0 : 300.0;  // a wire that was open
      health.step(samples, t, 1.0);
      together = together || health.model_in_doubt();
    }
    EXPECT_EQ(together, sixth != Sixth::reads);
    EXPECT_EQ(health.record(5).state == HealthState::good, sixth != Sixth::failed);
    EXPECT_EQ(health.record(0).failures, sixth == Sixth::reads ? 1 : 0);
  }
}

/// With which no pair fails by its movement alone, without a contradiction.
HealthLimits never_sure() {
  HealthLimits limits;
  limits.swap_limit = 1e9;
  return limits;
}

TEST(Health, a_contradiction_is_laid_to_the_two_that_move_like_each_others_place) {
  for (const std::uint64_t n : {0, 1, 2}) {
    Drive drive(drive_seed + n, never_sure());
    drive.tamper = [](std::vector<HealthSample>& samples) { std::swap(samples[3].reading_K, samples[4].reading_K); };
    drive.run_until(7200.0);
    ASSERT_EQ(drive.failed(), 0) << n;
    const HealthVerdict verdict = drive.health.note_contradiction();
    EXPECT_EQ(verdict.failed, 3) << n;
    EXPECT_EQ(verdict.partner, 4) << n;
    EXPECT_EQ(drive.health.record(3).fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.record(4).fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.failed(), 2) << n;
    EXPECT_EQ(drive.health.note_contradiction().failed, -1) << "the others move like themselves";
  }
}

TEST(Health, a_contradiction_of_channels_in_their_places_fails_none) {
  Drive drive(drive_seed, never_sure());
  drive.run_until(7200.0);
  EXPECT_EQ(drive.health.note_contradiction().failed, -1);
  EXPECT_EQ(drive.failed(), 0);
}

TEST(Health, a_channel_is_swapped_with_one_other_only) {
  // 1 and 2 stand at one temperature, and take the course of 0 together, as 0 takes theirs.
  const std::vector<double> before_K{300.0, 305.0, 305.0, 310.0, 315.0, 320.0, 325.0};
  const std::vector<double> after_K{305.0, 300.0, 300.0, 310.0, 315.0, 320.0, 325.0};
  SensorHealth health(std::vector<HealthChannel>(before_K.size(), {true, 253.15, 423.15}), {});
  std::vector<HealthSample> samples(before_K.size());
  for (int second = 0; second < 110; ++second) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double wobble_K = second % 2 == 0 ? 0.02 : -0.02;  // no channel is silent
      samples[i] = {true, wobble_K + (second < 100 ? before_K : after_K)[i], before_K[i]};
    }
    health.step(samples, second, second == 0 ? 0.0 : 1.0);
  }
  EXPECT_EQ(health.record(0).fault, HealthFault::swapped);
  EXPECT_EQ(health.record(0).partner, 1);
  EXPECT_EQ(health.record(1).partner, 0);
  EXPECT_EQ(health.record(2).fault, HealthFault::jump);
  EXPECT_EQ(health.record(2).partner, -1);
  for (const std::size_t i : {0, 1, 2}) EXPECT_EQ(health.record(i).failures, 1) << i;
}

TEST(Health, when_most_channels_leave_their_course_at_once_it_is_not_the_channels) {
  Drive drive(drive_seed);
  drive.run_until(1000.0);
  drive.tamper = [](std::vector<HealthSample>& samples) {
    for (std::size_t i = 0; i < 5; ++i) samples[i].reading_K -= 3.0;
  };
  drive.step();
  EXPECT_TRUE(drive.health.model_in_doubt());
  drive.run_until(1100.0);
  EXPECT_EQ(drive.failed(), 0);
}

/// A sensor that was laid off for a misfit which then has gone, or not.
struct Blamed {
  explicit Blamed(bool in_doubt) : drive(drive_seed) {
    drive.steady = true;
    drive.run_until(3600.0);
    spend_first_verdict(drive.health, 6);
    drive.run_until(4000.0);
    std::vector<HealthUpdate> updates(6, {true, 0.0, 0, 300.0, 0.0, 0.1});
    updates[2] = {true, 40.0, 0, 300.0, 0.8, 0.1};
    EXPECT_EQ(drive.health.note_update(updates, in_doubt).failed, 2);
    EXPECT_EQ(record().fault, HealthFault::drift);
    drive.tamper = [this](std::vector<HealthSample>& samples) {
      for (std::size_t i = 0; i < samples.size(); ++i) samples[i].offset_K = drive.offset_K[i];
      samples[2].predicted_K = drive.truth_K[2];  // of all others
      samples[2].reading_K += misfit_K;
    };
  }
  const HealthRecord& record() const { return drive.health.record(2); }
  Drive drive;
  double misfit_K = 0.8;
};

TEST(Health, a_drift_whose_misfit_has_gone_was_the_model_and_the_sensor_returns_within_ten_minutes) {
  Blamed sensor(false);
  sensor.misfit_K = 0.1;
  sensor.drive.run_until(4599.0);
  EXPECT_EQ(sensor.record().state, HealthState::good);
  EXPECT_EQ(sensor.record().failures, 0) << "what was taken back was no failure";
}

TEST(Health, a_drift_whose_misfit_stays_is_latched_after_ten_minutes) {
  Blamed sensor(false);
  sensor.drive.run_until(4700.0);
  EXPECT_EQ(sensor.record().state, HealthState::failed);
  sensor.misfit_K = 0.0;
  sensor.drive.run_until(8000.0);
  EXPECT_EQ(sensor.record().state, HealthState::failed);
  sensor.drive.health.acknowledge();
  sensor.drive.run_until(8400.0);
  EXPECT_EQ(sensor.record().state, HealthState::good);
}

TEST(Health, what_failed_while_the_model_was_in_doubt_returns_by_itself_whenever_its_misfit_has_gone) {
  Blamed sensor(true);
  sensor.drive.run_until(8000.0);
  EXPECT_EQ(sensor.record().state, HealthState::failed);
  sensor.misfit_K = 0.0;
  sensor.drive.run_until(8500.0);
  EXPECT_EQ(sensor.record().state, HealthState::good);
}

TEST(Health, a_broken_wire_does_not_take_a_verdict_of_drift_back) {
  Blamed sensor(false);
  sensor.drive.tamper = [&](std::vector<HealthSample>& samples) {
    if (sensor.drive.time_s < 4200.0) samples[2].reading_K = 1123.15;
  };
  sensor.drive.run_until(6000.0);
  EXPECT_EQ(sensor.record().state, HealthState::failed);
}

TEST(Health, a_pair_found_by_its_movement_is_told_to_the_estimator_once) {
  Drive drive(drive_seed);
  drive.tamper = [](std::vector<HealthSample>& samples) { std::swap(samples[3].reading_K, samples[4].reading_K); };
  while (drive.failed() == 0 && drive.time_s < 7200.0) drive.step();
  ASSERT_EQ(drive.failed(), 2);
  const std::vector<HealthUpdate> updates(6, {true, 0.0, 0});
  const HealthVerdict verdict = drive.health.note_update(updates);
  EXPECT_EQ(verdict.failed, 3);
  EXPECT_EQ(verdict.partner, 4);
  EXPECT_EQ(drive.health.note_update(updates).failed, -1);
}

TEST(Health, step_never_calls_the_heap) {
  Drive drive(drive_seed);
  drive.run_until(100.0);
  std::vector<HealthUpdate> updates(6, {true, 0.3, 0});
  const long before = rom::tests::heap_calls();
  drive.run_until(1000.0);
  drive.health.note_update(updates);
  drive.health.acknowledge();
  EXPECT_EQ(rom::tests::heap_calls() - before, 0);
}

}  // namespace health_sensor_health_test
}  // namespace spindle_twin::correction::test
