#include "correction/estimator/sensor_channel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace spindle_twin::correction::test {
namespace estimator_sensor_channel_test {

TEST(Lag, of_a_step_decays_by_its_exponential) {
  for (const double tau_s : {0.5, 10.0, 90.0}) {
    for (const double h_s : {0.1, 2.0, 60.0, 1000.0}) {
      const double expected = 5.0 + (2.0 - 5.0) * std::exp(-h_s / tau_s);
      EXPECT_NEAR(lag(2.0, 5.0, 5.0, h_s, tau_s), expected, 1e-12);
    }
  }
}

TEST(Lag, of_a_ramp_follows_it_by_tau) {
  // τ y′ = u − y with u = u0 + r t:  y = u − r τ + (y0 − u0 + r τ) e^(−t/τ)
  constexpr double y0 = 1.0, u0 = 3.0, rate = 0.2;
  for (const double tau_s : {0.5, 10.0, 90.0}) {
    for (const double h_s : {0.1, 2.0, 60.0, 1000.0}) {
      const double u1 = u0 + rate * h_s;
      const double expected = u1 - rate * tau_s + (y0 - u0 + rate * tau_s) * std::exp(-h_s / tau_s);
      EXPECT_NEAR(lag(y0, u0, u1, h_s, tau_s), expected, 1e-11) << tau_s << " " << h_s;
    }
  }
}

TEST(Lag, in_many_short_steps_is_that_of_one_long_one) {
  constexpr int steps = 50;
  constexpr double h_s = 120.0, tau_s = 17.0, u0 = -1.0, u1 = 4.0;
  double shown = 2.0, slope = 0.3;
  for (int k = 0; k < steps; ++k) {
    const double before = u0 + (u1 - u0) * k / steps, after = u0 + (u1 - u0) * (k + 1) / steps;
    slope = lag_slope(slope, shown, before, after, h_s / steps, tau_s);
    shown = lag(shown, before, after, h_s / steps, tau_s);
  }
  EXPECT_NEAR(shown, lag(2.0, u0, u1, h_s, tau_s), 1e-12);
  EXPECT_NEAR(slope, lag_slope(0.3, 2.0, u0, u1, h_s, tau_s), 1e-12);
}

TEST(Lag, slope_is_the_difference_of_two_lags) {
  constexpr double y = 1.0, slope = -0.07, u0 = 3.0, u1 = -2.0;
  for (const double tau_s : {0.5, 10.0, 90.0}) {
    for (const double h_s : {0.1, 2.0, 60.0, 400.0}) {
      const double nudge_s = 1e-4 * tau_s;
      const auto at = [&](double by_s) { return lag(y + slope * by_s, u0, u1, h_s, tau_s + by_s); };
      const double difference = (at(nudge_s) - at(-nudge_s)) / (2.0 * nudge_s);
      EXPECT_NEAR(lag_slope(slope, y, u0, u1, h_s, tau_s), difference, 1e-6 * std::max(1.0, std::abs(difference)))
          << tau_s << " " << h_s;
    }
  }
}

TEST(Lag, without_one_the_sensor_shows_what_is_there_and_a_small_one_is_a_delay) {
  constexpr double h_s = 2.0, u0 = 3.0, u1 = 3.5, rate = (u1 - u0) / h_s;
  EXPECT_EQ(lag(1.0, u0, u1, h_s, 0.0), u1);
  EXPECT_EQ(lag(1.0, u0, u1, 0.0, 10.0), 1.0);
  EXPECT_EQ(lag_slope(0.4, 1.0, u0, u1, h_s, 0.0), -rate);
  EXPECT_EQ(lag_slope(0.4, 1.0, u0, u1, 0.0, 10.0), 0.4);
  for (const double tau_s : {1e-2, 1e-3, 1e-4}) {
    EXPECT_NEAR(lag(1.0, u0, u1, h_s, tau_s), u1 - rate * tau_s, 1e-12) << tau_s;
    EXPECT_NEAR(lag_slope(0.4, 1.0, u0, u1, h_s, tau_s), -rate, 1e-12) << tau_s;
  }
}

TEST(SensorChannel, reading_its_own_model_has_no_residual_and_a_step_of_its_lag_moves_what_it_shows) {
  SensorChannel channel(Eigen::VectorXd::Ones(1), 2);
  channel.start(300.0);
  constexpr double tau_s = 20.0, h_s = 2.0, rate = 0.05;
  for (int k = 1; k <= 60; ++k) {
    const double t_s = k * h_s;
    channel.predict(300.0 + rate * t_s, h_s, tau_s);
    channel.observe(300.0 + rate * t_s - rate * tau_s * (1.0 - std::exp(-t_s / tau_s)));
    channel.observe(std::numeric_limits<double>::quiet_NaN());
  }
  EXPECT_EQ(channel.samples(), 60);
  EXPECT_NEAR(channel.mean_residual_K(), 0.0, 1e-10);
  // d/dτ of −r τ (1 − e^(−t/τ)) at t = 120 s
  const double x = 120.0 / tau_s, slope = -rate * (1.0 - std::exp(-x) - x * std::exp(-x));
  EXPECT_NEAR(channel.lag_slope_K_per_s(), slope, 1e-12);
  channel.set_sensitivity(Eigen::Vector2d(0.5, -1.0));
  EXPECT_GT(std::abs(channel.mean_lag_slope()), 0.0);
  channel.clear();
  EXPECT_EQ(channel.mean_lag_slope(), 0.0);
  EXPECT_TRUE(std::isnan(channel.mean_reading_K()));
  EXPECT_TRUE(std::isnan(channel.mean_residual_K()));
  // A step of parameters and lag: the place moves by 0.7, what is shown by 0.5 · 0.2 − 1 · 0.1 + slope · 3.
  channel.correct(Eigen::Vector2d(4.0, 1.0), Eigen::Vector2d(0.2, 0.1), 3.0);
  channel.predict(300.0 + rate * 120.0 + 0.9, 0.0, tau_s);
  channel.observe(306.0 - rate * tau_s * (1.0 - std::exp(-x)));
  EXPECT_NEAR(channel.mean_residual_K(), -(0.5 * 0.2 - 0.1 + 3.0 * slope), 1e-10);
}

TEST(SensorChannel, sensitivities_lag_behind_those_of_the_place_as_the_reading_does) {
  SensorChannel channel(Eigen::VectorXd::Ones(1), 2);
  channel.start(300.0);
  constexpr double tau_s = 15.0, period_s = 10.0;
  double expected = 0.0;
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector2d before(0.1 * k, 1.0), after(0.1 * (k + 1), 1.0);
    channel.begin_period(before);
    channel.end_period(after, period_s, tau_s);
    expected = lag(expected, before[0], after[0], period_s, tau_s);
  }
  EXPECT_DOUBLE_EQ(channel.sensitivity()[0], expected);
  EXPECT_NEAR(channel.sensitivity()[1], 1.0 - std::exp(-50.0 / tau_s), 1e-12);
  channel.set_sensitivity_from(1, Eigen::Vector2d(7.0, 8.0));
  EXPECT_DOUBLE_EQ(channel.sensitivity()[0], expected);
  EXPECT_EQ(channel.sensitivity()[1], 8.0);
}

}  // namespace estimator_sensor_channel_test
}  // namespace spindle_twin::correction::test
