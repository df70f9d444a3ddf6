#include "correction/calibrate/asked_heat.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "correction/calibrate/calibrate.hpp"
#include "tests/correction/calibrate/recorded_run.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_asked_heat_test {

/// The machine's own model: a heat in each group besides.
ParameterModel with_heats(const rom::Network& network, const CalibrateOptions& options) {
  EstimatorPriors priors = options.priors;
  priors.disturbance = 0.01;
  return {network, priors};
}

/// A test of the machine whose other parameters are those of `seed`, 0: of the priors' means.
ThermalTest recorded(const rom::Network& network, const CalibrateOptions& options, std::uint64_t seed,
                     Eigen::Index group, double heat_W) {
  const ParameterModel parameters = with_heats(network, options);
  Eigen::VectorXd truth = seed > 0 ? drawn(parameters, seed) : parameters.mean();
  for (Eigen::Index g = 0; g < parameters.group_count(); ++g) truth[parameters.disturbance(g)] = 0.0;
  truth[parameters.disturbance(group)] = heat_W;
  RecordedRun run;
  run.seed = seed + 1;
  return record(network, parameters, truth, run);
}

std::vector<AskedHeat> asked_of(const rom::Network& network, const CalibrateOptions& options,
                                const std::vector<ThermalTest>& tests) {
  const TestPredictor predictor(network, options);
  const FitTask task{network, predictor, options, tests};
  return heats_asked_for(task, fit_tests(task, nullptr, {}));
}

TEST(AskedHeat, is_the_one_that_no_source_explains_where_a_straight_line_stands_for_the_model) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ParameterModel own = with_heats(network, options);
  constexpr double small_W = 4.0;
  for (Eigen::Index group = 0; group < own.group_count(); ++group) {
    const std::string& name = own.groups()[static_cast<std::size_t>(group)].name;
    const auto asked = asked_of(network, options, {recorded(network, options, 0, group, small_W)});
    const auto found =
        std::find_if(asked.begin(), asked.end(), [&](const AskedHeat& one) { return one.group == name; });
    ASSERT_NE(found, asked.end());
    EXPECT_NEAR(found->heat_W, small_W, 2.0 * found->deviation_W) << name;
  }
}

TEST(AskedHeat, that_sensors_can_tell_is_found_and_makes_the_calibration_unfit) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const std::string name = with_heats(network, options).groups()[1].name;
  constexpr double missing_W = 20.0;
  for (const std::uint64_t seed : {5u, 6u}) {
    const CalibrationResult result = calibrate(network, options, {recorded(network, options, seed, 1, missing_W)}, {});
    const auto found =
        std::find_if(result.asked.begin(), result.asked.end(), [&](const AskedHeat& one) { return one.group == name; });
    ASSERT_NE(found, result.asked.end());
    EXPECT_GT(found->deviations(), CalibrateLimits{}.asked_heat);
    EXPECT_NEAR(found->heat_W, missing_W, 0.5 * missing_W) << "to first order";
    EXPECT_FALSE(result.calibration.accepted);
    EXPECT_TRUE(std::any_of(result.misfits.begin(), result.misfits.end(), [&](const std::string& misfit) {
      return misfit.find("in " + name + " that no source explains") != std::string::npos;
    }));
  }
}

TEST(AskedHeat, of_two_tests_is_surer_than_of_one) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  const ThermalTest once = recorded(network, options, 3, 1, 0.0);
  const auto deviation_W = [&](const std::vector<ThermalTest>& tests) {
    for (const AskedHeat& heat : asked_of(network, options, tests)) {
      if (heat.group == with_heats(network, options).groups()[1].name) return heat.deviation_W;
    }
    return 0.0;
  };
  EXPECT_LT(deviation_W({once, once}), deviation_W({once}));
}

TEST(AskedHeat, of_a_machine_without_is_within_three_deviations_of_none) {
  const rom::Network network = plates();
  const CalibrateOptions options = calibrate_options(network);
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u}) {
    const auto asked = asked_of(network, options, {recorded(network, options, seed, 0, 0.0)});
    ASSERT_FALSE(asked.empty());
    EXPECT_LT(asked.front().deviations(), 3.0) << asked.front().group << ", seed " << seed;
  }
}

}  // namespace calibrate_asked_heat_test
}  // namespace spindle_twin::correction::test
