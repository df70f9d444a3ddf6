#include "correction/health/sensor_health.hpp"

#include <gtest/gtest.h>

#include "tests/correction/health/drive.hpp"
#include "tests/rom/heap_calls.hpp"

namespace spindle_twin::correction::test {
namespace {

constexpr std::uint64_t seed = 20;

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
      for (std::size_t i = 0; i < Drive::places; ++i) withheld += drive.health.record(i).usable ? 0 : 1;
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
    EXPECT_EQ(drive.health.record(3).fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.record(4).fault, HealthFault::swapped) << n;
    EXPECT_EQ(drive.health.record(3).partner, 4);
    EXPECT_EQ(drive.health.record(4).partner, 3);
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
