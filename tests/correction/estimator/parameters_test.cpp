#include "correction/estimator/parameters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "correction/estimator/operating_heat.hpp"
#include "correction/estimator/square_root_filter.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::correction::test {
namespace estimator_parameters_test {

/// What README.md of the estimator states of each kind.
struct Stated {
  double mean, deviation, minimum, maximum, walk_per_root_min, memory_s;
};
Stated stated(ParameterKind kind, bool uniform, double heats_W, double unexplained_W) {
  const double ten = std::log(10.0), five = std::log(5.0);
  switch (kind) {
    case ParameterKind::heat:
      return {0.5 * 0.5 * 0.5, 0.5, -five, five, 0.003, 0.0};
    case ParameterKind::contact:
      return {-0.5 * 0.6 * 0.6, 0.6, -ten, ten, 0.005, 0.0};
    case ParameterKind::film:
      return {-0.5 * 0.3 * 0.3, 0.3, -five, five, 0.003, 0.0};
    case ParameterKind::environment:
      return {0.0, 0.1, -20.0, 20.0, 0.0, 1800.0};
    case ParameterKind::bearing_temperature:
      return {0.010, 0.005, 0.0, 0.030, 0.0, 0.0};
    case ParameterKind::speed_exponent:
      return {0.0, 0.15, -0.6, 0.6, 0.0, 0.0};
    case ParameterKind::expansion:
      return {0.0, 0.05, -0.5, 0.5, 0.0, 0.0};
    case ParameterKind::capacity:
      return {0.0, 0.3, -five, five, 0.0, 0.0};
    case ParameterKind::disturbance:
      return {0.0, unexplained_W, -heats_W, heats_W, 0.0, 3600.0};
    case ParameterKind::start:
      return {0.0, uniform ? 0.2 : 0.05, -500.0, 500.0, 0.0, 0.0};
  }
  return {};
}

/// What the factor of an ln factor multiplies; 1 of all others.
double nominal_of(const rom::Network& network, const Parameter& parameter) {
  const auto at = static_cast<std::size_t>(parameter.index);
  const rom::Boundaries& boundaries = network.boundaries;
  switch (parameter.kind) {
    case ParameterKind::heat:
      return std::abs(boundaries.sources[at].nominal_W);
    case ParameterKind::contact:
    case ParameterKind::film:
      return boundaries.conductances[at].nominal_W_per_m2K * boundaries.conductances[at].area_m2;
    case ParameterKind::capacity:
      return network.capacity_J_per_K(parameter.index, parameter.index);
    default:
      return 1.0;
  }
}

TEST(NominalShift, is_the_logarithm_of_two_values_and_none_where_one_of_them_is_zero) {
  EXPECT_DOUBLE_EQ(nominal_shift(2.0, 1.0), std::log(2.0));
  EXPECT_EQ(nominal_shift(3.0, 3.0), 0.0);
  EXPECT_EQ(nominal_shift(0.0, 5.0), 0.0);
  EXPECT_EQ(nominal_shift(5.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(nominal_shift(0.5, 0.25), std::log(2.0));
}

TEST(Parameters, of_a_network_have_the_priors_that_are_stated) {
  for (const rom::Network& network : {plates(), spindle_twin::tests::small_network_by_hand()}) {
    const ParameterModel model(network, EstimatorPriors{});
    double heats_W = 0.0;
    for (const rom::HeatSource& source : network.boundaries.sources) heats_W += source.nominal_W;
    const std::vector<double> through_W = heat_through_groups_W(network, thermal_groups(network, 8));
    for (Eigen::Index i = 0; i < model.count(); ++i) {
      const Parameter& parameter = model.list()[static_cast<std::size_t>(i)];
      SCOPED_TRACE(parameter.name);
      double unexplained_W = 0.01 * heats_W;
      if (network.hand_written && parameter.kind == ParameterKind::disturbance) {
        unexplained_W = std::max(unexplained_W, 0.1 * through_W[static_cast<std::size_t>(parameter.index)]);
      }
      const Stated expected = stated(parameter.kind, i == model.start(), heats_W, unexplained_W);
      EXPECT_DOUBLE_EQ(parameter.mean, expected.mean);
      EXPECT_EQ(model.mean()[i], parameter.mean);
      EXPECT_DOUBLE_EQ(parameter.deviation, expected.deviation);
      EXPECT_DOUBLE_EQ(parameter.minimum, expected.minimum);
      EXPECT_DOUBLE_EQ(parameter.maximum, expected.maximum);
      EXPECT_DOUBLE_EQ(std::sqrt(60.0) * parameter.walk_per_root_s, expected.walk_per_root_min);
      EXPECT_EQ(parameter.memory_s, expected.memory_s);
      EXPECT_EQ(parameter.uncalibrated_mean, parameter.mean);
      EXPECT_EQ(parameter.uncalibrated_deviation, parameter.deviation);
      EXPECT_DOUBLE_EQ(parameter.nominal, nominal_of(network, parameter));
    }
  }
}

TEST(Parameters, share_what_all_heats_have_in_common_and_nothing_else) {
  const rom::Network network = plates();
  EstimatorPriors priors;
  priors.heat = 0.3;
  priors.heat_common = 0.4;
  const ParameterModel model(network, priors);
  const Eigen::MatrixXd covariance = model.covariance();
  const auto is_heat = [&](Eigen::Index i) {
    return model.list()[static_cast<std::size_t>(i)].kind == ParameterKind::heat;
  };
  for (Eigen::Index i = 0; i < model.count(); ++i) {
    const double own = model.list()[static_cast<std::size_t>(i)].deviation;
    for (Eigen::Index j = 0; j < model.count(); ++j) {
      const double shared = is_heat(i) && is_heat(j) ? 0.4 * 0.4 : 0.0;
      EXPECT_NEAR(covariance(i, j), i == j ? own * own : shared, 1e-12 * own * own);
    }
    if (is_heat(i)) {
      EXPECT_NEAR(own, std::hypot(0.3, 0.4), 1e-15);
    }
  }
}

/// Two bearings with the same grease beside a motor; two joints of one fit beside a screwed one.
rom::Network bearings_and_fits() {
  rom::Network network = plates();
  rom::Boundaries& boundaries = network.boundaries;
  rom::HeatSource rear = boundaries.sources[0];
  rear.name = "rear bearing";
  boundaries.sources.push_back(rear);
  network.source_distribution.conservativeResize(Eigen::NoChange, network.source_distribution.cols() + 1);
  network.source_distribution.rightCols(1) = network.source_distribution.leftCols(1);
  int contacts = 0;
  for (rom::Conductance& conductance : boundaries.conductances) {
    conductance.fit.reset();
    if (conductance.kind == rom::ConductanceKind::contact && contacts++ < 2)
      conductance.fit = rom::JointFit{1e6, 1e5, 1e5};
  }
  return network;
}

double correlation_of(const ParameterModel& model, const std::string& a, const std::string& b) {
  const auto slot = [&](const std::string& name) {
    const auto found = std::find_if(model.list().begin(), model.list().end(),
                                    [&](const Parameter& parameter) { return parameter.name == name; });
    EXPECT_NE(found, model.list().end()) << name;
    return found - model.list().begin();
  };
  const Eigen::MatrixXd covariance = model.covariance();
  return covariance(slot(a), slot(b)) / std::sqrt(covariance(slot(a), slot(a)) * covariance(slot(b), slot(b)));
}

/// One cause of deviation c beside an own one of deviation s: correlation c² / (c² + s²).
TEST(Parameters, of_bearings_with_one_grease_and_joints_of_one_fit_share_their_cause) {
  const rom::Network network = bearings_and_fits();
  std::vector<std::string> fitted, others;
  for (const rom::Conductance& conductance : network.boundaries.conductances) {
    if (conductance.kind == rom::ConductanceKind::contact) {
      (conductance.fit ? fitted : others).push_back("contact " + conductance.name);
    }
  }
  ASSERT_EQ(fitted.size(), 2U);
  EstimatorPriors priors;
  priors.heat = 0.3;
  priors.heat_common = 0.2;
  priors.friction_common = 0.4;
  priors.contact = 0.5;
  priors.fit_common = 0.25;
  const ParameterModel model(network, priors);
  const std::string front = "heat " + network.boundaries.sources[0].name;
  const double of_bearing = 0.3 * 0.3 + 0.2 * 0.2 + 0.4 * 0.4, of_motor = 0.3 * 0.3 + 0.2 * 0.2;
  EXPECT_NEAR(correlation_of(model, front, "heat rear bearing"), (0.2 * 0.2 + 0.4 * 0.4) / of_bearing, 1e-12);
  EXPECT_NEAR(correlation_of(model, front, "heat motor"), 0.2 * 0.2 / std::sqrt(of_bearing * of_motor), 1e-12);
  EXPECT_NEAR(correlation_of(model, fitted[0], fitted[1]), 0.25 * 0.25 / (0.5 * 0.5 + 0.25 * 0.25), 1e-12);
  for (const std::string& other : others) EXPECT_EQ(correlation_of(model, fitted[0], other), 0.0) << other;
}

/// Also where it is the first of the network's pressures.
TEST(Parameters, of_a_joint_whose_law_reads_a_pressure_share_the_cause_of_the_fits) {
  rom::Network network = bearings_and_fits();
  network.contact_pressures = {
      {"screwed", 2e6, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.nodes.size()))}};
  std::vector<std::string> fitted;
  for (rom::Conductance& conductance : network.boundaries.conductances) {
    if (conductance.kind != rom::ConductanceKind::contact) continue;
    if (!conductance.fit && fitted.size() == 2) {
      conductance.physics = rom::BoundLaw{};
      conductance.physics->pressure = 0;
      fitted.push_back("contact " + conductance.name);
    } else if (conductance.fit) {
      fitted.push_back("contact " + conductance.name);
    }
  }
  ASSERT_EQ(fitted.size(), 3U);
  EstimatorPriors priors;
  priors.contact = 0.5;
  priors.fit_common = 0.25;
  const ParameterModel model(network, priors);
  EXPECT_NEAR(correlation_of(model, fitted[0], fitted[2]), 0.25 * 0.25 / (0.5 * 0.5 + 0.25 * 0.25), 1e-12);
}

/// What one bearing's sensor says of its heat it then says, by the shared cause, of the other's.
TEST(Parameters, with_one_grease_a_reading_at_one_bearing_tells_of_the_other) {
  const rom::Network network = bearings_and_fits();
  const auto deviation_left = [&](double common) {
    EstimatorPriors priors;
    priors.heat = 0.2;
    priors.friction_common = common;
    const ParameterModel model(network, priors);
    SquareRootFilter filter(model.mean(), model.covariance());
    filter.update(Eigen::VectorXd::Unit(model.count(), model.heat(0)), 0.1, 1e-6);
    return filter.deviation(model.heat(static_cast<Eigen::Index>(network.boundaries.sources.size()) - 1));
  };
  EXPECT_NEAR(deviation_left(0.0), 0.2, 1e-9);
  const double variance = 0.2 * 0.2 + 0.5 * 0.5, shared = 0.5 * 0.5;
  EXPECT_NEAR(deviation_left(0.5), std::sqrt(variance - shared * shared / (variance + 1e-6)), 1e-9);
}

TEST(Parameters, of_heats_by_measured_current_have_the_deviation_of_these) {
  rom::Network network = plates();
  rom::BoundLaw copper;
  copper.law.parameters = rom::CopperLaw::example();
  network.boundaries.sources[1].physics = copper;
  EstimatorPriors priors;
  const ParameterModel as_others(network, priors);
  priors.heat_by_current = 0.15;
  const ParameterModel measured(network, priors);
  const auto deviation = [](const ParameterModel& model, Eigen::Index source) {
    return model.list()[static_cast<std::size_t>(model.heat(source))].deviation;
  };
  EXPECT_EQ(deviation(as_others, 1), priors.heat);
  EXPECT_EQ(deviation(measured, 1), 0.15);
  EXPECT_EQ(deviation(measured, 0), priors.heat);
}

TEST(Parameters, multiply_heats_by_the_law_of_the_readme_and_leave_them_at_zero) {
  const rom::Network network = plates();
  const ParameterModel model(network, EstimatorPriors{});
  rom::CorrectionFactors factors = model.make_factors(network);
  Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(network.boundaries.operating.environment_K.size());
  const Eigen::VectorXd rise_K = Eigen::VectorXd::Constant(factors.heat.size(), 12.0);
  const double half_rpm = 0.5 * network.boundaries.reference_speed_rpm;
  model.apply(model.neutral(), half_rpm, rise_K, factors, bias_K);
  EXPECT_EQ(factors.heat, Eigen::VectorXd::Ones(factors.heat.size()));
  EXPECT_EQ(factors.conductance, Eigen::VectorXd::Ones(factors.conductance.size()));
  EXPECT_TRUE(factors.node_heat_W.isZero(0.0));

  Eigen::VectorXd theta = model.neutral();
  theta[model.bearing()] = 0.02;
  for (Eigen::Index i = 0; i < factors.heat.size(); ++i) {
    theta[model.heat(i)] = 0.3;
    if (model.exponent(i) >= 0) theta[model.exponent(i)] = 0.2;
  }
  theta[model.environment(0)] = 0.07;
  theta[model.conductance(1)] = -0.4;
  for (const double sign : {-1.0, 1.0}) {
    model.apply(theta, sign * half_rpm, rise_K, factors, bias_K);
    for (Eigen::Index i = 0; i < factors.heat.size(); ++i) {
      const double exponent = model.exponent(i) < 0 ? 0.0 : 0.2;
      const double fallen = model.is_friction(i) ? std::exp(-0.02 * 12.0) : 1.0;
      EXPECT_NEAR(factors.heat[i], std::exp(0.3) * std::pow(0.5, exponent) * fallen, 1e-12);
    }
    EXPECT_EQ(bias_K[0], 0.07);
    EXPECT_NEAR(factors.conductance[1], std::exp(-0.4), 1e-15);
    EXPECT_EQ(factors.conductance[0], 1.0);
  }
  EXPECT_TRUE(model.is_friction(0));
  EXPECT_FALSE(model.is_friction(1));
}

TEST(Parameters, of_speed_end_at_a_twentieth_of_the_reference) {
  const rom::Network network = plates();
  const ParameterModel model(network, EstimatorPriors{});
  const double reference_rpm = network.boundaries.reference_speed_rpm;
  EXPECT_EQ(model.log_speed(reference_rpm), 0.0);
  EXPECT_NEAR(model.log_speed(-0.1 * reference_rpm), std::log(0.1), 1e-12);
  EXPECT_NEAR(model.log_speed(0.01 * reference_rpm), std::log(0.05), 1e-12);
  EXPECT_NEAR(model.log_speed(0.0), std::log(0.05), 1e-12);
  rom::Network without_speed = network;
  without_speed.boundaries.reference_speed_rpm = 0.0;
  EXPECT_EQ(ParameterModel(without_speed, EstimatorPriors{}).log_speed(3000.0), 0.0);
  without_speed.boundaries.reference_speed_rpm = 0.5;
  EXPECT_NEAR(ParameterModel(without_speed, EstimatorPriors{}).log_speed(-1.0), std::log(2.0), 1e-12);
}

TEST(Parameters, a_watt_into_a_group_warms_all_of_it_alike_and_stays_a_watt) {
  const rom::Network network = plates();
  const ParameterModel model(network, EstimatorPriors{});
  rom::CorrectionFactors factors = model.make_factors(network);
  Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(network.boundaries.operating.environment_K.size());
  const Eigen::VectorXd rise_K = Eigen::VectorXd::Zero(factors.heat.size());
  ASSERT_GT(model.group_count(), 1);
  for (Eigen::Index g = 0; g < model.group_count(); ++g) {
    Eigen::VectorXd theta = model.neutral();
    theta[model.disturbance(g)] = 5.0;
    model.apply(theta, 0.0, rise_K, factors, bias_K);
    EXPECT_NEAR(factors.node_heat_W.sum(), 5.0, 1e-9);
    const Eigen::VectorXd rate_K_per_s = network.capacity_J_per_K.llt().solve(factors.node_heat_W);
    const Eigen::VectorXd& group = model.groups()[static_cast<std::size_t>(g)].indicator;
    EXPECT_LT((rate_K_per_s - rate_K_per_s.maxCoeff() * group).norm(), 1e-9 * rate_K_per_s.norm());
  }
}

TEST(Parameters, give_no_node_a_heat_in_factors_that_have_none) {
  const rom::Network network = plates();
  const ParameterModel model(network, EstimatorPriors{});
  rom::CorrectionFactors factors = rom::no_correction(network.boundaries);
  ASSERT_EQ(factors.node_heat_W.size(), 0);
  Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(network.boundaries.operating.environment_K.size());
  Eigen::VectorXd theta = model.neutral();
  theta[model.disturbance(0)] = 5.0;
  model.apply(theta, 0.0, Eigen::VectorXd::Zero(factors.heat.size()), factors, bias_K);
  EXPECT_EQ(factors.node_heat_W.size(), 0);
}

TEST(Parameters, without_a_deviation_are_left_out) {
  const rom::Network network = spindle_twin::tests::small_network_by_hand();
  EstimatorPriors priors;
  priors.heat = priors.contact = priors.film = priors.environment_K = priors.bearing_per_K = 0.0;
  priors.speed_exponent = priors.expansion = priors.start_K = priors.disturbance_by_hand = priors.capacity = 0.0;
  const ParameterModel model(network, priors);
  EXPECT_EQ(model.count(), 0);
  EXPECT_EQ(model.heat(0), -1);
  EXPECT_EQ(model.conductance(0), -1);
  EXPECT_EQ(model.environment(0), -1);
  EXPECT_EQ(model.bearing(), -1);
  EXPECT_EQ(model.exponent(0), -1);
  EXPECT_EQ(model.start(), -1);
  EXPECT_EQ(model.starts(), 0);
  EXPECT_FALSE(model.is_start(0));
  EXPECT_FALSE(model.has_capacities());
  EXPECT_FALSE(model.has_disturbances());
  EXPECT_EQ(model.capacity(0), -1);
  EXPECT_EQ(model.expansion(), -1);
  priors.start_K = 0.2;
  priors.start_shape_K = 0.0;
  EXPECT_EQ(ParameterModel(network, priors).starts(), 1) << "the uniform start alone";
}

}  // namespace estimator_parameters_test
}  // namespace spindle_twin::correction::test
