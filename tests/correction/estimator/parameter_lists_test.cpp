#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/firmware/support/small_network.hpp"

/// Which parameters there are, by the network and by the priors that leave some out.
namespace spindle_twin::correction::test {
namespace estimator_parameter_lists_test {

TEST(ParameterKinds, heats_contacts_films_and_capacities_bend_the_state_and_what_is_of_the_day_is_not_of_the_machine) {
  using Kind = ParameterKind;
  for (const Kind kind : {Kind::heat, Kind::contact, Kind::film, Kind::environment, Kind::bearing_temperature,
                          Kind::speed_exponent, Kind::expansion, Kind::capacity, Kind::disturbance, Kind::start}) {
    const bool bends = kind == Kind::heat || kind == Kind::contact || kind == Kind::film || kind == Kind::capacity;
    const bool of_the_day = kind == Kind::environment || kind == Kind::disturbance || kind == Kind::start;
    EXPECT_EQ(bends_the_state(kind), bends) << name_of(kind);
    EXPECT_EQ(is_of_the_machine(kind), !of_the_day) << name_of(kind);
  }
}

TEST(ParameterLists, of_descriptions_that_are_means_and_no_medians_begin_at_them) {
  EstimatorPriors priors;
  priors.centred = false;
  const ParameterModel model(plates(), priors);
  for (const Parameter& parameter : model.list()) {
    const bool is_law = parameter.kind == ParameterKind::bearing_temperature;
    EXPECT_EQ(parameter.mean, is_law ? 0.010 : 0.0) << parameter.name;
  }
}

TEST(ParameterLists, of_more_than_eight_bodies_have_eight_groups_and_the_smallest_heats_are_told_from_none) {
  const rom::Network many = rom::tests::make_synthetic_network({10, 2, 2, true}, 7);
  EXPECT_EQ(ParameterModel(many, {}).group_count(), 8);
  rom::Network faint = plates();
  double heats_W = 0.0;
  for (rom::HeatSource& source : faint.boundaries.sources) heats_W += std::abs(source.nominal_W);
  EstimatorPriors priors;
  priors.start_K = 0.0;
  priors.disturbance = 0.5 / heats_W;
  const ParameterModel alone(faint, priors);
  EXPECT_EQ(alone.group_count(), 5) << "half a watt into each, and no start";
  EXPECT_TRUE(alone.has_disturbances());
  priors.disturbance = 0.0;
  EXPECT_TRUE(ParameterModel(faint, priors).groups().empty()) << "nobody asks for them";
  EXPECT_EQ(ParameterModel(faint, priors).group_count(), 0);
  priors.start_K = 0.2;
  EXPECT_EQ(ParameterModel(faint, priors).starts(), 3 + 5) << "and a start knows them without heats";
}

TEST(ParameterLists, of_bearings_are_there_where_a_heat_is_friction) {
  rom::Network network = plates();
  network.boundaries.sources[0].friction = false;
  EXPECT_EQ(ParameterModel(network, {}).bearing(), -1);
  for (rom::HeatSource& source : network.boundaries.sources) source.friction = true;
  EXPECT_GE(ParameterModel(network, {}).bearing(), 0);
  for (const Eigen::Index source : {0, 1}) {
    EXPECT_GE(ParameterModel(network, {}).exponent(source), 0) << "both know speed";
    network.boundaries.sources[static_cast<std::size_t>(source)].law.speed_terms.clear();
    EXPECT_EQ(ParameterModel(network, {}).exponent(source), -1);
  }
}

TEST(ParameterLists, of_which_there_is_one_alone_act_as_they_do_among_others) {
  rom::Network network = plates();
  EstimatorPriors none;
  none.heat = none.contact = none.film = none.environment_K = none.bearing_per_K = none.speed_exponent = 0.0;
  none.expansion = none.start_K = none.disturbance = 0.0;
  EstimatorPriors priors = none;
  priors.expansion = 0.05;
  const ParameterModel expands(network, priors);
  ASSERT_EQ(expands.expansion(), 0);
  const Eigen::VectorXd theta = Eigen::VectorXd::Constant(1, 0.1);
  EXPECT_DOUBLE_EQ(expands.expansion_factor(theta), std::exp(0.1));
  double length_m = 2e-6;
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(1);
  expands.expand(theta, length_m, slope);
  EXPECT_DOUBLE_EQ(length_m, 2e-6 * std::exp(0.1));
  EXPECT_EQ(slope[0], length_m);
  EXPECT_EQ(ParameterModel(network, none).expansion_factor({}), 1.0);

  priors = none;
  priors.start_K = 0.2;
  priors.start_shape_K = 0.0;
  const ParameterModel starts(network, priors);
  EXPECT_EQ(starts.start(), 0);
  EXPECT_EQ(starts.starts(), 1);
  EXPECT_EQ(starts.shapes().size(), 1U) << "as many as there are parameters";
  EXPECT_TRUE(starts.is_start(0));

  const rom::Network by_hand = spindle_twin::tests::small_network_by_hand();
  priors = none;
  priors.disturbance_by_hand = priors.capacity = 0.0;
  EXPECT_EQ(ParameterModel(by_hand, priors).count(), 0);
  priors.capacity = 0.3;
  EXPECT_TRUE(ParameterModel(by_hand, priors).has_capacities());
  std::swap(priors.capacity, priors.disturbance_by_hand);
  EXPECT_TRUE(ParameterModel(by_hand, priors).has_disturbances());

  priors = none;
  priors.contact = 0.3;
  priors.fit_common = 0.4;
  for (rom::Conductance& conductance : network.boundaries.conductances) conductance.fit = rom::JointFit{1e6, 1e5, 1e5};
  const ParameterModel joints(network, priors);
  ASSERT_GT(joints.count(), 1);
  EXPECT_NEAR(joints.covariance()(0, 1), 0.4 * 0.4, 1e-15);
}

TEST(ParameterLists, of_a_single_node_have_a_heat_that_no_source_explains_too) {
  const rom::Network network = rom::tests::make_single_node();
  const ParameterModel model(network, {});
  rom::CorrectionFactors factors = model.make_factors(network);
  Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(network.boundaries.operating.environment_K.size());
  Eigen::VectorXd theta = model.neutral();
  theta[model.disturbance(0)] = 5.0;
  model.apply(theta, 0.0, Eigen::VectorXd::Zero(factors.heat.size()), factors, bias_K);
  EXPECT_DOUBLE_EQ(factors.node_heat_W[0], 5.0);
}

TEST(ParameterLists, of_another_model_of_the_machine_are_taken_by_name) {
  const rom::Network network = plates();
  EstimatorPriors less;
  less.heat = 0.0;
  const ParameterModel all(network, {}), some(network, less);
  const Eigen::VectorXd theta = Eigen::VectorXd::LinSpaced(all.count(), 1.0, 2.0);
  const Eigen::VectorXd there = all.as_in(some, theta);
  const Eigen::VectorXd back = some.as_in(all, there);
  ASSERT_EQ(there.size(), some.count());
  ASSERT_EQ(back.size(), all.count());
  for (Eigen::Index i = 0; i < all.count(); ++i) {
    const bool is_heat = all.list()[static_cast<std::size_t>(i)].kind == ParameterKind::heat;
    EXPECT_EQ(back[i], is_heat ? 0.0 : theta[i]) << all.list()[static_cast<std::size_t>(i)].name;
  }
}

}  // namespace estimator_parameter_lists_test
}  // namespace spindle_twin::correction::test
