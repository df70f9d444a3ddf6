#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/firmware/support/small_network.hpp"

/// When the estimator updates, what passes meanwhile, and what it begins with.
namespace spindle_twin::correction::test {
namespace estimator_estimator_correction_test {

EstimatorOptions no_second_pass() {
  EstimatorOptions options;
  options.second_pass = 0.0;
  return options;
}

/// Instants, among those at which it is called, at which the estimator updates.
std::vector<double> updates_s(const std::vector<double>& called_s) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.noise_K = 0.03;
  std::vector<double> found;
  for (std::size_t k = 0; k < called_s.size(); ++k) {
    pair.time_s = called_s[k];
    const long before = pair.estimator.updates();
    pair.read();
    const bool corrected = pair.step().corrected;
    const bool updated = pair.estimator.updates() > before;
    EXPECT_EQ(corrected, updated) << called_s[k];
    if (updated) found.push_back(called_s[k]);
    EXPECT_LE(pair.estimator.updates() - before, 1);
  }
  return found;
}

TEST(EstimatorPeriods, updates_with_the_first_call_of_each_period_and_catches_up_with_none) {
  std::vector<double> each_four;
  for (int k = 0; k <= 12; ++k) each_four.push_back(4.0 * k);
  EXPECT_EQ(updates_s(each_four), (std::vector<double>{12.0, 20.0, 32.0, 40.0}));
  EXPECT_EQ(updates_s({0.0, 20.0, 22.0, 29.0, 30.0, 38.0, 40.0}), (std::vector<double>{20.0, 30.0, 40.0}))
      << "a pause to the end of the second period: the third begins there";
  EXPECT_EQ(updates_s({0.0, 95.0, 97.0, 104.0, 105.0}), (std::vector<double>{95.0, 105.0}));
}

TEST(EstimatorPeriods, counts_its_age_from_the_start_and_its_updates) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.time_s = 1000.0;
  pair.run_until(1042.0);
  EXPECT_EQ(pair.estimator.age_s(), 40.0);
  EXPECT_EQ(pair.estimator.updates(), 4);
  EXPECT_EQ(pair.estimator.failures(), 0);
  EXPECT_EQ(pair.estimator.loosened(), 0);
  EXPECT_EQ(pair.estimator.relinearised(), 0);
}

TEST(EstimatorPeriods, has_nothing_to_tell_of_updates_before_the_first) {
  const rom::Network network = plates();
  const EstimatorCorrection estimator(network, {});
  for (const SensorRecord& record : {estimator.record(0), estimator.record(3), estimator.displacement_record()}) {
    EXPECT_EQ(record.observation_K, 0.0);
    EXPECT_EQ(record.innovation_K, 0.0);
    EXPECT_EQ(record.variance_K2, 0.0);
    EXPECT_EQ(record.test_ratio, 0.0);
    EXPECT_EQ(record.offset_K, 0.0);
    EXPECT_EQ(record.rejected_in_a_row, 0);
    EXPECT_FALSE(record.rejected);
    EXPECT_FALSE(record.fused);
  }
  EXPECT_EQ(estimator.displacement_record().offset_deviation_K, 0.0);
  EXPECT_EQ(estimator.last_update().elapsed_s, 0.0);
  EXPECT_FALSE(std::isfinite(estimator.last_update().displacement_m));
  EXPECT_EQ(estimator.updates(), 0);
  EXPECT_EQ(estimator.unexplained_heat().group, -1);
  EXPECT_EQ(estimator.unexplained_heat().heat_W, 0.0);
  EXPECT_EQ(estimator.widths().environment, 1.0);
  EXPECT_TRUE(estimator.factors().heat.isOnes(0.0)) << "factors are of no parameter yet";
}

TEST(EstimatorPeriods, after_standing_by_updates_a_period_later_with_what_was_read_since) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.run_until(600.0);
  for (; pair.time_s < 703.0; pair.advance_plant()) {
    pair.estimator.stand_by(pair.time_s, pair.twin.stepper.temperatures_K(), pair.operating, pair.cycle_s);
    pair.twin.advance(pair.cycle_s, pair.operating, pair.estimator.factors());
  }
  EXPECT_EQ(pair.estimator.estimate(0).value, 0.0) << "what was learnt is given up, and what was believed";
  EXPECT_EQ(pair.estimator.factors().expansion, 1.0);
  const double again_s = pair.time_s;
  long before = pair.estimator.updates();
  while (pair.time_s < again_s + 9.0) {
    pair.cycle();
    EXPECT_EQ(pair.estimator.updates(), before) << pair.time_s - again_s;
  }
  pair.cycle();
  EXPECT_EQ(pair.estimator.updates(), before + 1);
  EXPECT_NEAR(pair.estimator.last_update().elapsed_s, 10.0, 1e-9);
  // Each reading by itself is the noise that is told, of six of them one sixth.
  EXPECT_TRUE(std::isfinite(pair.estimator.last_update().innovation_K[0]));
}

/// Standing by it carries on what the uncorrected heats do: period by period, and at once where inputs change.
TEST(EstimatorPeriods, standing_by_judges_outputs_anew_each_period_and_where_inputs_change) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.estimator.stand_by(0.0, pair.twin.stepper.temperatures_K(), pair.operating, pair.cycle_s);
  EXPECT_EQ(pair.estimator.estimate(0).value, 0.0) << "from the very start";
  std::vector<double> anew_s;
  double told_m = 0.0;
  for (; pair.time_s < 121.0; pair.advance_plant()) {
    if (pair.time_s >= 86.0) pair.operating.speed_rpm = 3000.0;
    pair.estimator.stand_by(pair.time_s, pair.twin.stepper.temperatures_K(), pair.operating, pair.cycle_s);
    pair.twin.advance(pair.cycle_s, pair.operating, pair.estimator.factors());
    if (pair.estimator.deviations().deformations_m[0] != told_m) anew_s.push_back(pair.time_s);
    told_m = pair.estimator.deviations().deformations_m[0];
  }
  std::vector<double> expected_s;
  for (double time_s = 0.0; time_s < 30.0; time_s += 2.0) expected_s.push_back(time_s);
  for (const double time_s : {38.0, 48.0, 58.0, 68.0, 78.0, 86.0, 96.0, 106.0, 116.0}) expected_s.push_back(time_s);
  EXPECT_EQ(anew_s, expected_s);
  EXPECT_EQ(pair.estimator.failures(), 0) << "a period of no length is none";
}

TEST(EstimatorPeriods, of_half_a_second_are_no_failures) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.cycle_s = 0.5;
  pair.run_until(5.0);
  EXPECT_EQ(pair.estimator.failures(), 0);
}

TEST(EstimatorPeriods, begun_anew_know_of_nothing_that_was_opened_read_or_told_before) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.run_until(62.0);
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 10.0; };
  pair.estimator.note_contradiction();
  pair.run_until(82.0);
  ASSERT_GT(pair.estimator.widths().environment, 2.0);
  pair.estimator.note_displacement(0, 1e-3, 1e-6);
  pair.tamper = nullptr;
  const Eigen::VectorXd warm_K = pair.twin.stepper.temperatures_K().array() + 7.0;
  pair.plant.stepper.set_temperatures(warm_K);
  pair.twin.stepper.set_temperatures(warm_K);
  pair.estimator.reset(pair.time_s, warm_K, pair.operating);
  EXPECT_EQ(pair.estimator.widths().environment, 1.0);
  EXPECT_EQ(pair.estimator.widths().disturbance, 1e-3);
  EXPECT_EQ(pair.estimator.age_s(), 0.0);
  for (Eigen::Index s = 0; s < 4; ++s) {
    EXPECT_EQ(pair.estimator.record(s).offset_K, 0.0) << s;
    EXPECT_EQ(pair.estimator.record(s).offset_deviation_K, 0.02) << s;
    EXPECT_FALSE(pair.estimator.record(s).fused) << s;
  }
  const double begun_s = pair.time_s;
  pair.run_until(begun_s + 12.0);
  EXPECT_FALSE(std::isfinite(pair.estimator.last_update().displacement_m)) << "a length of before";
  for (Eigen::Index s = 0; s < 4; ++s) EXPECT_LT(std::abs(pair.estimator.record(s).innovation_K), 1.0) << s;
}

TEST(EstimatorTime, walks_forgets_and_keeps_each_unknown_by_its_own_law) {
  const rom::Network network = plates();
  const EstimatorCorrection estimator(network, {});
  const ParameterModel& parameters = estimator.parameters();
  const Eigen::Index n = estimator.filter().size(), p = parameters.count();
  Eigen::VectorXd keep = Eigen::VectorXd::Constant(n, 7.0), growth = keep;
  constexpr double elapsed_s = 500.0;
  estimator.passing_of_time(elapsed_s, {3.0, 5.0}, keep, growth);
  for (Eigen::Index i = 0; i < p; ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    SCOPED_TRACE(parameter.name);
    const bool heat = parameter.kind == ParameterKind::disturbance,
               inlet = parameter.kind == ParameterKind::environment;
    if (heat || inlet) {
      const double kept = std::exp(-elapsed_s / (heat ? 3600.0 : 1800.0));
      const double width = (heat ? 3.0 : 5.0) * parameter.deviation;
      EXPECT_NEAR(keep[i], kept, 1e-12);
      EXPECT_NEAR(growth[i], width * width * (1.0 - kept * kept), 1e-9 * width * width);
    } else {
      const bool ln = parameter.kind == ParameterKind::heat || parameter.kind == ParameterKind::film;
      const double walk = ln ? 0.003 : (parameter.kind == ParameterKind::contact ? 0.005 : 0.0);
      EXPECT_EQ(keep[i], 1.0);
      EXPECT_NEAR(growth[i], walk * walk * elapsed_s / 60.0, 1e-15);
    }
  }
  for (Eigen::Index s = 0; s < 4; ++s) {
    EXPECT_NEAR(growth[p + s], 0.002 * 0.002 * elapsed_s / 3600.0, 1e-18) << "an offset, per root hour";
    EXPECT_EQ(growth[p + 4 + s], 0.0) << "a lag stays";
    EXPECT_EQ(keep[p + s], 1.0);
    EXPECT_EQ(keep[p + 4 + s], 1.0);
  }
}

TEST(EstimatorTime, closes_what_was_opened_within_hours) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.run_until(600.0);
  pair.tamper = [](Eigen::VectorXd& measured_K) { measured_K.array() += 10.0; };
  while (pair.estimator.loosened() == 0 && pair.time_s < 1200.0) pair.cycle();
  ASSERT_EQ(pair.estimator.loosened(), 1);
  const Widths open = pair.estimator.widths();
  const double opened_s = pair.estimator.age_s();
  pair.valid.setConstant(false);
  pair.cycle_s = 10.0;
  pair.run_until(pair.time_s + 3600.0);
  const double since_s = pair.estimator.age_s() - opened_s;
  const Widths now = pair.estimator.widths();
  EXPECT_NEAR(now.environment / open.environment, std::exp(-since_s / 14400.0), 1e-9);
  EXPECT_NEAR(now.disturbance / open.disturbance, std::exp(-since_s / 7200.0), 1e-9);
}

TEST(EstimatorStart, knows_of_sensors_what_options_say) {
  const rom::Network network = plates();
  EstimatorOptions options;
  options.sensors = key_point_sensors(network, options);
  options.sensors[2].offset_deviation_K = 0.2;
  options.sensors[1].lag_s = 8.0;
  const EstimatorCorrection estimator(network, options);
  const Eigen::Index p = estimator.parameters().count();
  for (Eigen::Index s = 0; s < 4; ++s) {
    EXPECT_NEAR(estimator.filter().deviation(p + s), s == 2 ? 0.2 : 0.02, 1e-12);
    EXPECT_NEAR(estimator.filter().deviation(p + 4 + s), 14.0, 1e-9);
    EXPECT_EQ(estimator.filter().mean()[p + s], 0.0);
    EXPECT_EQ(estimator.filter().mean()[p + 4 + s], s == 1 ? 8.0 : 0.0);
    EXPECT_EQ(estimator.lag_s(s), s == 1 ? 8.0 : 0.0);
  }
  const Eigen::MatrixXd covariance = estimator.covariance();
  EXPECT_TRUE(covariance.bottomLeftCorner(8, p).isZero(1e-12));
  options.lag_deviation_s = 0.0;
  const EstimatorCorrection as_told(network, options);
  EXPECT_EQ(as_told.filter().size(), p + 4);
  options.lag_deviation_s = 0.5;
  EXPECT_EQ(EstimatorCorrection(network, options).filter().size(), p + 8);
  const EstimatorSensor of_which_nothing_is_said;
  EXPECT_EQ(of_which_nothing_is_said.noise_K, 0.03);
  EXPECT_EQ(of_which_nothing_is_said.offset_deviation_K, 0.02);
  EXPECT_EQ(of_which_nothing_is_said.lag_s, 0.0);
  EXPECT_EQ(as_told.lag_s(1), 8.0);
}

/// Heats that no source explains: of a guess as open as their prior, of a network that was certified or tested shut.
TEST(EstimatorStart, has_heats_open_where_the_network_is_a_guess_and_shut_where_it_is_known) {
  const rom::Network by_hand = spindle_twin::tests::small_network_by_hand();
  EXPECT_EQ(EstimatorCorrection(by_hand, {}).widths().disturbance, 1.0);
  const rom::Network certified = plates();
  const EstimatorCorrection shut(certified, {});
  EXPECT_EQ(shut.widths().disturbance, 1e-3);
  for (Eigen::Index group = 0; group < shut.parameters().group_count(); ++group) {
    const int slot = shut.parameters().disturbance(group);
    EXPECT_NEAR(shut.prior().deviation(slot), 1e-3 * shut.estimate(slot).prior_deviation, 1e-12);
  }
  EstimatorOptions options;
  auto test = std::make_shared<CalibratedPrior>();
  test->names = {EstimatorCorrection(by_hand, {}).parameters().list().front().name};
  test->mean = Eigen::VectorXd::Constant(1, 0.1);
  test->covariance = Eigen::MatrixXd::Constant(1, 1, 0.01);
  options.priors.calibrated = test;
  EXPECT_EQ(EstimatorCorrection(by_hand, options).widths().disturbance, 1e-3);
}

TEST(EstimatorStart, believes_no_sensor_further_than_a_millikelvin_and_a_guess_no_further_than_its_own_floor) {
  const rom::Network certified = plates(), by_hand = spindle_twin::tests::small_network_by_hand();
  const auto least_K = [](const rom::Network& network, double floor_K, double floor_by_hand_K) {
    EstimatorOptions options;
    options.floor_K = floor_K;
    options.floor_by_hand_K = floor_by_hand_K;
    return EstimatorCorrection(network, options).consistency().least_floor_K();
  };
  EXPECT_EQ(least_K(certified, 0.03, 0.3), 0.03);
  EXPECT_EQ(least_K(by_hand, 0.03, 0.3), 0.3);
  EXPECT_EQ(least_K(by_hand, 0.5, 0.3), 0.5);
  EXPECT_EQ(least_K(certified, 0.0, 0.3), 1e-3);
  EXPECT_EQ(least_K(by_hand, 0.0, 0.0), 1e-3);
}

TEST(EstimatorTold, of_an_offset_that_may_have_changed_opens_it_by_so_much_and_nothing_else) {
  const rom::Network network = plates();
  Pair pair(network, no_second_pass());
  pair.run_until(602.0);
  const Eigen::MatrixXd before = pair.estimator.covariance();
  pair.estimator.widen_offset(2, 0.5);
  Eigen::MatrixXd expected = before;
  const Eigen::Index at = pair.estimator.parameters().count() + 2;
  expected(at, at) += 0.25;
  EXPECT_LT((pair.estimator.covariance() - expected).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(EstimatorTold, a_parameter_is_undetermined_above_nine_tenths_of_its_prior_or_where_nobody_looked) {
  EXPECT_FALSE((ParameterEstimate{0.0, 0.9, 1.0, false}).undetermined());
  EXPECT_TRUE((ParameterEstimate{0.0, 0.91, 1.0, false}).undetermined());
  EXPECT_TRUE((ParameterEstimate{0.0, 1.81, 2.0, false}).undetermined());
  EXPECT_FALSE((ParameterEstimate{0.0, 1.79, 2.0, false}).undetermined());
  EXPECT_TRUE((ParameterEstimate{0.0, 0.1, 1.0, true}).undetermined());
}

}  // namespace estimator_estimator_correction_test
}  // namespace spindle_twin::correction::test
