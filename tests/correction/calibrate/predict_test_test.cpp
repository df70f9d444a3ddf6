#include "correction/calibrate/predict_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "rom/read/input_error.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_predict_test_test {

constexpr double steady_K = 304.0, steady_m = 8e-6;  // of the single node with its 100 W: 25 W/K, 2 um/K

/// A single node that starts at the temperature at which it stays, with a sensor and a probe, read each three seconds.
struct SteadyNode {
  explicit SteadyNode(double length_s = 198.0) : network(rom::tests::make_single_node()) {
    options.sensors = key_point_sensors(network, {});
    options.interval_s = 0.0;
    options.held_s = 10.0;
    test.name = "monday";
    test.start_K = steady_K;
    for (double time_s = 0.0; time_s <= length_s; time_s += 3.0) {
      test.time_s.push_back(time_s);
      test.operating.push_back(network.boundaries.operating);
    }
    const auto rows = static_cast<Eigen::Index>(test.time_s.size());
    test.measured_K.resize(rows, 1);
    test.deformation_m.resize(rows, 1);
    for (Eigen::Index k = 0; k < rows; ++k) {
      test.measured_K(k, 0) = 300.0 + 0.1 * static_cast<double>(k);
      test.deformation_m(k, 0) = 1e-7 * static_cast<double>(k * k);
    }
  }
  std::vector<TestReading> predicted(double lag_s = 0.0) const { return prediction(lag_s).readings; }
  TestPrediction prediction(double lag_s = 0.0) const {
    const TestPredictor predictor(network, options);
    return predictor.predict(test, predictor.parameters().neutral(), Eigen::VectorXd::Constant(1, lag_s));
  }
  std::vector<double> times_s(int channel) const {
    std::vector<double> times_s;
    for (const TestReading& reading : predicted()) {
      if (reading.channel == channel) times_s.push_back(reading.time_s);
    }
    return times_s;
  }
  rom::Network network;
  CalibrateOptions options;
  ThermalTest test;
};

TEST(TestPredictor, takes_the_mean_of_each_period_of_readings_and_what_is_left_of_it_beside_the_model) {
  const SteadyNode node(48.0);
  const std::vector<TestReading> found = node.predicted();
  // Periods end with the first instant at least 10 s after they began: 0 to 12 s, then (12, 24], (24, 36], (36, 48].
  const double times_s[] = {12.0, 24.0, 36.0, 48.0}, means[] = {2.0, 6.5, 10.5, 14.5};
  const double mean_squares[] = {6.0, 43.5, 111.5, 211.5};
  ASSERT_EQ(found.size(), 8U);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(found[k].time_s, times_s[k / 2]);
    EXPECT_EQ(found[k].channel, static_cast<int>(k % 2)) << "the sensor first";
    EXPECT_EQ(found[k].samples, k / 2 == 0 ? 5 : 4);
    EXPECT_NEAR(found[k].lag_slope, 0.0, 1e-9);
    if (k % 2 == 0) {
      const double mean_K = 300.0 + 0.1 * means[k / 2];
      EXPECT_NEAR(found[k].value, mean_K, 1e-9);
      EXPECT_NEAR(found[k].residual, mean_K - steady_K, 1e-7);
      EXPECT_NEAR(found[k].rise, mean_K - node.test.start_K, 1e-9);
    } else {
      EXPECT_NEAR(found[k].value, 1e-7 * mean_squares[k / 2], 1e-15);
      EXPECT_NEAR(found[k].residual, 1e-7 * mean_squares[k / 2] - steady_m, 1e-13);
      EXPECT_EQ(found[k].rise, 0.0);
    }
  }
}

TEST(TestPredictor, of_a_channel_takes_a_period_each_interval_and_no_sooner) {
  SteadyNode node;
  node.options.interval_s = 60.0;
  const std::vector<double> each_minute{12.0, 72.0, 132.0, 192.0};
  EXPECT_EQ(node.times_s(0), each_minute);
  EXPECT_EQ(node.times_s(1), each_minute);
  node.options.interval_s = 60.1;
  EXPECT_EQ(node.times_s(0), (std::vector<double>{12.0, 84.0, 156.0}));
}

TEST(TestPredictor, the_readings_behind_the_last_period_count_too) {
  SteadyNode node(54.0);  // 48 s ended a period
  const std::vector<TestReading> found = node.predicted();
  EXPECT_EQ(found.back().time_s, 54.0);
  EXPECT_EQ(found.back().samples, 2);
}

TEST(TestPredictor, a_channel_that_is_silent_for_a_period_has_no_reading_of_it_and_is_taken_when_it_speaks_again) {
  SteadyNode node;
  node.options.interval_s = 60.0;
  const double silent = std::numeric_limits<double>::quiet_NaN();
  node.test.measured_K.middleRows(21, 10).setConstant(silent);  // 63 to 90 s: the periods to 72 and 84 s
  node.test.measured_K(32, 0) = silent;                         // 96 s
  EXPECT_EQ(node.times_s(0), (std::vector<double>{12.0, 96.0, 156.0}));
  EXPECT_EQ(node.times_s(1), (std::vector<double>{12.0, 72.0, 132.0, 192.0}));
  const std::vector<TestReading> found = node.predicted();
  const auto one = std::find_if(found.begin(), found.end(), [](const TestReading& reading) {
    return reading.channel == 0 && reading.time_s == 96.0;
  });
  ASSERT_NE(one, found.end());
  EXPECT_EQ(one->samples, 1) << "of 93 s alone";
  EXPECT_NEAR(one->value, 303.1, 1e-9);
}

TEST(TestPredictor, a_period_ends_where_inputs_change_and_another_begins_there) {
  SteadyNode node;
  for (std::size_t k = 10; k < node.test.operating.size(); ++k) node.test.operating[k].load += 0.02;  // from 30 s on
  const std::vector<double> times_s = node.times_s(0);
  ASSERT_GE(times_s.size(), 5U);
  EXPECT_EQ(std::vector<double>(times_s.begin(), times_s.begin() + 5),
            (std::vector<double>{12.0, 24.0, 30.0, 42.0, 54.0}));
}

/// Its place in pieces of half a second beside the sensor's own differential equation.
TEST(TestPredictor, a_sensor_with_a_lag_follows_its_place_by_its_time_constant) {
  SteadyNode node;
  node.options.held_s = 0.0;
  node.options.longest_step_s = 1.0;
  node.test.start_K = 300.0;
  constexpr double lag_s = 25.0, tau_s = 40.0;
  const std::vector<TestReading> shown = node.predicted(lag_s), there = node.predicted();
  ASSERT_EQ(shown.size(), there.size());
  for (std::size_t r = 0; r < shown.size(); ++r) {
    const double row = std::round(shown[r].time_s / 3.0), time_s = shown[r].time_s;
    const double place_K = 300.0 + 4.0 * (1.0 - std::exp(-time_s / tau_s));
    if (shown[r].channel == 1) {
      EXPECT_EQ(shown[r].residual, there[r].residual) << "a probe has none";
      continue;
    }
    // y' = (place − y)/lag from y = place on
    const double lagging_K =
        304.0 - 4.0 * (tau_s * std::exp(-time_s / tau_s) - lag_s * std::exp(-time_s / lag_s)) / (tau_s - lag_s);
    EXPECT_NEAR(300.0 + 0.1 * row - there[r].residual, place_K, 2e-3) << time_s;
    EXPECT_NEAR(300.0 + 0.1 * row - shown[r].residual, lagging_K, 2e-3) << time_s;
  }
}

TEST(TestPredictor, tells_what_the_first_output_follows_at_the_end) {
  SteadyNode node;
  node.options.held_s = 0.0;
  const TestPrediction found = node.prediction(5.0);
  ASSERT_EQ(found.readings.back().channel, 1);
  ASSERT_EQ(found.readings.back().time_s, 198.0);
  EXPECT_LT((found.last_output - found.sensitivities.bottomRows(1).transpose()).norm(),
            1e-12 * found.last_output.norm());
  node.network.deformations.clear();
  node.test.deformation_m.resize(node.test.measured_K.rows(), 0);
  EXPECT_EQ(node.prediction().last_output.size(), 0);
}

TEST(TestPredictor, says_when_the_model_of_which_test_cannot_be_integrated) {
  SteadyNode node;
  for (std::size_t k = 10; k < node.test.operating.size(); ++k) {
    node.test.operating[k].environment_K.setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  try {
    node.predicted();
    FAIL() << "was predicted";
  } catch (const rom::InputError& error) {
    const std::string message = error.what();
    EXPECT_TRUE(message.starts_with("monday: time_s: the model cannot be integrated")) << message;
    EXPECT_NE(message.find(" at 2"), std::string::npos) << "the step over 30 s: " << message;
  }
}

}  // namespace calibrate_predict_test_test
}  // namespace spindle_twin::correction::test
