#include "host_tools/replay/log_readings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace spindle_twin::host_tools {
namespace log_readings_test {

/// Two sensors; `of` gives what each reads at a time.
Log log_of(const std::function<double(std::size_t, double)>& of, double every_s = 1.0) {
  Log log;
  log.has_sensor[0] = log.has_sensor[1] = true;
  for (int n = 0; n < 2000; ++n) {
    LogRow row;
    row.time_s = every_s * n;
    for (std::size_t k = 0; k < 2; ++k) row.measured_K[k] = of(k, row.time_s);
    log.rows.push_back(row);
  }
  return log;
}

double warm_up_K(double time_s) { return 293.15 + 20.0 * (1.0 - std::exp(-time_s / 800.0)); }

TEST(LogReadings, a_log_that_changes_in_every_row_shows_its_resolution) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise_K(0.0, 0.3);
  for (const double step_K : {0.001, 0.05, 0.5}) {
    const Log log = log_of([&](std::size_t, double time_s) {
      return step_K * std::round((warm_up_K(time_s) + noise_K(random)) / step_K);
    });
    EXPECT_NEAR(resolution_of_log_K(log, 0), std::max(step_K, 0.01), 1e-9);
  }
}

TEST(LogReadings, of_one_that_holds_its_readings_nobody_knows_it) {
  const Log held = log_of([](std::size_t, double time_s) { return warm_up_K(60.0 * std::floor(time_s / 60.0)); });
  EXPECT_EQ(resolution_of_log_K(held, 0), coarsest_resolution_K);
  const Log none = log_of([](std::size_t, double) { return std::nan(""); });
  EXPECT_EQ(resolution_of_log_K(none, 0), coarsest_resolution_K);
}

TEST(LogReadings, a_sensor_that_stands_has_that_of_before_and_one_that_always_did_that_of_the_others) {
  const Log log =
      log_of([](std::size_t k, double time_s) { return k == 0 ? warm_up_K(std::min(time_s, 300.0)) : 294.0; });
  EXPECT_LT(resolution_of_log_K(log, 0), 0.03);
  EXPECT_EQ(resolution_of_log_K(log, 1), resolution_of_log_K(log, 0));
}

TEST(LogReadings, the_start_is_what_sensors_read_within_a_minute_of_the_first) {
  Log log = log_of([](std::size_t k, double time_s) {
    return k == 0 ? 293.0 + 0.01 * time_s : time_s < 50.0 ? std::nan("") : 295.0 + 0.01 * time_s;
  });
  EXPECT_NEAR(start_of_log_K(log).value(), 0.5 * (293.0 + 295.5), 1e-9);
  for (LogRow& row : log.rows) {
    if (row.time_s <= 60.0) row.disbelieved[1] = true;
  }
  EXPECT_EQ(start_of_log_K(log), 293.0) << "a minute later it has warmed up";
  for (LogRow& row : log.rows) row.disbelieved.fill(true);
  EXPECT_EQ(start_of_log_K(log), std::nullopt);
}

TEST(LogReadings, noise_is_what_readings_scatter_by_however_the_spindle_warms_up) {
  std::mt19937 random(4);
  for (const double deviation_K : {0.01, 0.3}) {
    std::normal_distribution<double> noise_K(0.0, deviation_K);
    const Log log = log_of([&](std::size_t k, double time_s) {
      return warm_up_K(time_s) + (time_s > 900.0 ? 3.0 : 0.0) + (k == 0 ? noise_K(random) : 0.0);
    });
    EXPECT_NEAR(noise_of_log_K(log, 0), deviation_K, 0.05 * deviation_K);
    EXPECT_LT(noise_of_log_K(log, 1), 1e-4);
  }
  const Log held = log_of([](std::size_t, double time_s) { return warm_up_K(60.0 * std::floor(time_s / 60.0)); });
  EXPECT_EQ(noise_of_log_K(held, 0), 0.0);
}

}  // namespace log_readings_test
}  // namespace spindle_twin::host_tools
