#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "correction/calibrate/predict_test.hpp"
#include "correction/calibrate/test_steps.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"
#include "tests/firmware/support/small_network.hpp"
#include "tests/rom/law_network.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_gradient_test {

/// A circuit whose films, and heats and joints whose laws follow temperatures, pressures and lengths; and a bearing
/// whose friction falls besides.
rom::Network with_circuit_and_laws() {
  rom::Network network = rom::tests::make_network_with_laws();
  network.boundaries.sources.front().friction = true;
  return network;
}

/// Ten minutes with changes of speed and load, inlets that wander, and readings of all channels each 5 s.
ThermalTest drive(const rom::Network& network, const CalibrateOptions& options) {
  const rom::OperatingState& described = network.boundaries.operating;
  ThermalTest test;
  test.name = "drive";
  test.start_K = network.boundaries.reference_temperature_K + 1.0;
  for (int k = 0; k <= 120; ++k) {
    const double time_s = 5.0 * k;
    rom::OperatingState operating = described;
    operating.speed_rpm *= k < 50 ? 1.0 : k < 103 ? 0.3 : 0.7;
    operating.load *= k < 75 ? 1.0 : 0.5;
    operating.environment_K.array() += std::sin(time_s / 700.0);
    test.time_s.push_back(time_s);
    test.operating.push_back(operating);
  }
  const auto rows = static_cast<Eigen::Index>(test.time_s.size());
  test.measured_K = Eigen::MatrixXd::Constant(rows, static_cast<Eigen::Index>(options.sensors.size()), test.start_K);
  test.deformation_m = Eigen::MatrixXd::Zero(rows, static_cast<Eigen::Index>(network.deformations.size()));
  return test;
}

CalibrateOptions options_of(const rom::Network& network) {
  CalibrateOptions options;
  options.sensors = key_point_sensors(network, {});
  return options;
}

/// Means of the priors, and a bit in every direction.
Eigen::VectorXd somewhere(const ParameterModel& parameters) {
  Eigen::VectorXd theta = parameters.mean();
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const double by = i % 3 == 0 ? -0.5 : i % 3 == 1 ? 0.0 : 0.5;
    theta[i] += by * parameters.list()[static_cast<std::size_t>(i)].deviation;
  }
  return theta;
}

/// What two predictions of the same readings differ by, per step.
Eigen::VectorXd quotient(const TestPrediction& above, const TestPrediction& below, double step) {
  Eigen::VectorXd result(static_cast<Eigen::Index>(above.readings.size()));
  for (std::size_t r = 0; r < above.readings.size(); ++r) {
    result[static_cast<Eigen::Index>(r)] = (below.readings[r].residual - above.readings[r].residual) / step;
  }
  return result;
}

/// Largest |value| of each reading's channel.
Eigen::VectorXd largest_of_channel(const TestPrediction& at, const Eigen::VectorXd& values) {
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(values.size());
  for (Eigen::Index r = 0; r < values.size(); ++r) {
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      if (at.readings[static_cast<std::size_t>(r)].channel != at.readings[static_cast<std::size_t>(k)].channel)
        continue;
      largest[r] = std::max(largest[r], std::abs(values[k]));
    }
  }
  return largest;
}

/// Greatest error of a derivative, against the largest derivative by that parameter that its channel has.
double worst_share(const TestPrediction& at, const Eigen::VectorXd& claimed, const Eigen::VectorXd& differences) {
  const Eigen::VectorXd scale = largest_of_channel(at, differences);
  double worst = 0.0;
  for (Eigen::Index r = 0; r < claimed.size(); ++r) {
    if (scale[r] > 0.0) worst = std::max(worst, std::abs(claimed[r] - differences[r]) / scale[r]);
  }
  return worst;
}

void expect_exact_gradient(const rom::Network& network) {
  const CalibrateOptions options = options_of(network);
  const TestPredictor predictor(network, options);
  const ParameterModel& parameters = predictor.parameters();
  const ThermalTest test = drive(network, options);
  const Eigen::VectorXd theta = somewhere(parameters);
  const Eigen::VectorXd lag_s = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(options.sensors.size()), 7.0);
  const TestPrediction at = predictor.predict(test, theta, lag_s);
  ASSERT_GT(at.readings.size(), 40u);
  const auto moved = [](Eigen::VectorXd values, Eigen::Index i, double by) {
    values[i] += by;
    return values;
  };
  for (Eigen::Index i = 0; i < theta.size(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    const double step = (parameter.kind == ParameterKind::start ? 1.0 : 4e-3) * parameter.deviation;
    const Eigen::VectorXd differences = quotient(predictor.predict(test, moved(theta, i, step), lag_s),
                                                 predictor.predict(test, moved(theta, i, -step), lag_s), 2.0 * step);
    EXPECT_GT(differences.cwiseAbs().maxCoeff(), 0.0) << parameter.name << " has no effect";
    EXPECT_LT(worst_share(at, at.sensitivities.col(i), differences), 1e-5) << parameter.name;
  }
  for (Eigen::Index s = 0; s < lag_s.size(); ++s) {
    const Eigen::VectorXd differences = quotient(predictor.predict(test, theta, moved(lag_s, s, 0.01)),
                                                 predictor.predict(test, theta, moved(lag_s, s, -0.01)), 0.02);
    for (std::size_t r = 0; r < at.readings.size(); ++r) {
      if (at.readings[r].channel != s) continue;
      EXPECT_NEAR(at.readings[r].lag_slope, differences[static_cast<Eigen::Index>(r)],
                  1e-5 * differences.cwiseAbs().maxCoeff());
    }
  }
}

TEST(CalibrateGradient, is_that_of_the_predicted_readings_in_a_reduced_network) { expect_exact_gradient(plates()); }

TEST(CalibrateGradient, is_that_of_the_predicted_readings_in_a_hand_written_network) {
  const rom::Network network = spindle_twin::tests::small_network_by_hand();
  ASSERT_TRUE(ParameterModel(network, {}).has_capacities());
  ASSERT_TRUE(ParameterModel(network, {}).has_disturbances());
  expect_exact_gradient(network);
}

TEST(CalibrateGradient, is_that_of_the_predicted_readings_with_a_circuit_and_laws_that_follow_the_state) {
  expect_exact_gradient(with_circuit_and_laws());
}

/// Steps follow from the log alone: what they miss must be far below what readings are believed to.
TEST(CalibrateSteps, of_20_s_come_within_a_hundredth_of_a_kelvin_and_of_a_micrometre_of_those_of_1_s) {
  for (const rom::Network& network :
       {plates(), spindle_twin::tests::small_network_by_hand(), with_circuit_and_laws()}) {
    CalibrateOptions options = options_of(network);
    const ThermalTest test = drive(network, options);
    const Eigen::VectorXd lag_s = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(options.sensors.size()), 7.0);
    const auto predicted = [&](double longest_step_s) {
      options.longest_step_s = longest_step_s;
      const TestPredictor predictor(network, options);
      return predictor.predict(test, predictor.parameters().mean(), lag_s);
    };
    const TestPrediction usual = predicted(20.0), fine = predicted(1.0);
    ASSERT_EQ(usual.readings.size(), fine.readings.size());
    for (std::size_t r = 0; r < usual.readings.size(); ++r) {
      const bool is_sensor = usual.readings[r].channel < static_cast<int>(options.sensors.size());
      EXPECT_NEAR(usual.readings[r].residual, fine.readings[r].residual, is_sensor ? 0.01 : 0.01e-6)
          << "channel " << usual.readings[r].channel << " at " << usual.readings[r].time_s << " s";
    }
  }
}

TEST(CalibrateSteps, of_steady_readings_the_mean_is_the_reading_however_many_it_is_made_of) {
  const rom::Network network = plates();
  const CalibrateOptions options = options_of(network);
  ThermalTest test = drive(network, options);
  for (Eigen::Index c = 0; c < test.measured_K.cols(); ++c) {
    test.measured_K.col(c).setConstant(310.0 + static_cast<double>(c));
  }
  const TestPredictor predictor(network, options);
  const Eigen::VectorXd lag_s = Eigen::VectorXd::Zero(test.measured_K.cols());
  int most_samples = 0;
  for (const TestReading& each : predictor.predict(test, predictor.parameters().mean(), lag_s).readings) {
    if (each.channel >= test.measured_K.cols()) continue;
    EXPECT_NEAR(each.value, 310.0 + each.channel, 1e-9);
    EXPECT_NEAR(each.rise, 310.0 + each.channel - test.start_K, 1e-9);
    most_samples = std::max(most_samples, each.samples);
  }
  EXPECT_GT(most_samples, 1);
}

TEST(CalibrateSteps, inputs_that_wander_too_little_to_end_a_step_are_their_mean_over_it) {
  const rom::Network network = plates();
  ThermalTest test;
  for (const double time_s : {0.0, 300.0, 305.0, 315.0, 320.0}) {
    rom::OperatingState state = network.boundaries.operating;
    const double share = 1e-3 * (test.time_s.size() % 2 == 0 ? 1.0 : -1.0);
    state.speed_rpm = 6000.0 * (1.0 + share);
    state.load = 0.5 + share;
    state.current_A = 10.0 + 100.0 * share;
    state.power_W = 2000.0 * (1.0 + share);
    test.time_s.push_back(time_s);
    test.operating.push_back(state);
  }
  const std::vector<TestStep> steps = test_steps(test, 20.0);
  ASSERT_FALSE(steps.empty());
  for (const TestStep& step : steps) {
    const auto mean = [&](auto value) {
      double sum = 0.0;
      for (std::size_t i = 0; i + 1 < test.time_s.size(); ++i) {
        const double from_s = std::max(step.begin_s, test.time_s[i]), to_s = std::min(step.end_s, test.time_s[i + 1]);
        if (to_s > from_s) sum += (to_s - from_s) / (step.end_s - step.begin_s) * value(test.operating[i]);
      }
      return sum;
    };
    EXPECT_NEAR(step.operating.speed_rpm, mean([](const auto& state) { return state.speed_rpm; }), 1e-8);
    EXPECT_NEAR(step.operating.load, mean([](const auto& state) { return state.load; }), 1e-12);
    EXPECT_NEAR(*step.operating.current_A, mean([](const auto& state) { return *state.current_A; }), 1e-11);
    EXPECT_NEAR(*step.operating.power_W, mean([](const auto& state) { return *state.power_W; }), 1e-9);
  }
  EXPECT_TRUE(std::any_of(steps.begin(), steps.end(), [](const TestStep& step) {
    return step.begin_s < 305.0 && step.end_s > 305.0;
  })) << "no step goes over several instants";
}

TEST(CalibrateSteps, end_where_inputs_change_and_take_means_of_what_wanders_between) {
  const rom::Network network = plates();
  const ThermalTest test = drive(network, options_of(network));
  const std::vector<TestStep> steps = test_steps(test, 20.0);
  double end_s = test.time_s.front();
  for (const TestStep& step : steps) {
    EXPECT_EQ(step.begin_s, end_s);
    end_s = step.end_s;
    EXPECT_LE(step.end_s - step.begin_s, 20.0 + 1e-9);
    for (const double change_s : {250.0, 375.0, 515.0}) {
      EXPECT_FALSE(step.begin_s < change_s && change_s < step.end_s) << change_s;
      if (step.begin_s != change_s) continue;
      EXPECT_NEAR(step.end_s - step.begin_s, 1.0, 1e-9);
    }
    const double here_K = network.boundaries.operating.environment_K[0] + std::sin(step.begin_s / 700.0);
    EXPECT_NEAR(step.operating.environment_K[0], here_K, 20.0 / 700.0 + 5.0 / 700.0);
  }
  EXPECT_EQ(end_s, test.time_s.back());
  const auto over = std::find_if(steps.begin(), steps.end(),
                                 [](const TestStep& step) { return step.begin_s < 225.0 && step.end_s > 230.0; });
  ASSERT_NE(over, steps.end());
  double mean_K = 0.0;  // of the stairs, in pieces of 5 ms
  const double piece_s = 0.005;
  for (double time_s = over->begin_s + 0.5 * piece_s; time_s < over->end_s; time_s += piece_s) {
    mean_K += std::sin(5.0 * std::floor(time_s / 5.0) / 700.0) * piece_s / (over->end_s - over->begin_s);
  }
  EXPECT_NEAR(over->operating.environment_K[0] - network.boundaries.operating.environment_K[0], mean_K, 1e-4);
}

}  // namespace calibrate_gradient_test
}  // namespace spindle_twin::correction::test
