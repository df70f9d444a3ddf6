#include "correction/paper/heat_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "tests/correction/paper/one_node.hpp"

namespace spindle_twin::correction::test {
namespace paper_heat_law_test {

/// One node at the ambient whose base stands there too, and one reading of it a window.
struct Judged {
  explicit Judged(int sensors = 1)
      : network(node_network(375.0, 5.0, 1, sensors)),
        law(common_heat_group(network).front()),
        window(sensors),
        base(network, nullptr, std::make_unique<NodeStepper>(375.0), {0}),
        start_K(Eigen::VectorXd::Constant(sensors, ambient_K)),
        valid(Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(sensors, true)) {
    options.guards.settle_s = 80.0;
  }

  bool correct(double measured_rise_K, double model_rise_K, double speed_rpm = 6000.0, double settled_s = 1e6) {
    window.clear();
    base.clear_window();
    const Eigen::VectorXd at = Eigen::VectorXd::Constant(start_K.size(), ambient_K);
    window.add(at.array() + measured_rise_K, valid, at.array() + model_rise_K);
    base.add_to_window(Eigen::MatrixXd::Ones(start_K.size(), 1));
    return law.correct(options, window, base, {speed_rpm, settled_s, ambient_K, start_K});
  }

  rom::Network network;
  PaperOptions options;
  HeatLaw law;
  MeasuringWindow window;
  BaseResponse base;
  Eigen::VectorXd start_K;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid;
};

/// (ambient + rise) − ambient, as the law sees it.
double seen_K(double rise_K) { return (ambient_K + rise_K) - ambient_K; }

TEST(HeatLaw, its_factor_is_the_product_of_the_ratios_to_the_power_of_the_relaxation) {
  Judged judged;
  judged.options.relaxation = 0.5;
  EXPECT_TRUE(judged.correct(2.2, 2.0));
  EXPECT_NEAR(judged.law.ratio(), 1.1, 1e-12);
  EXPECT_NEAR(judged.law.step(), std::sqrt(1.1), 1e-12);
  EXPECT_NEAR(judged.law.rise_K(), 2.0, 1e-12);
  EXPECT_EQ(judged.law.freeze(), Freeze::none);
  EXPECT_TRUE(judged.correct(1.8, 2.0));
  EXPECT_NEAR(judged.law.factor(), std::sqrt(1.1 * 0.9), 1e-12);
  EXPECT_NEAR(judged.law.step(), std::sqrt(0.9), 1e-12);
}

TEST(HeatLaw, a_frozen_instant_has_no_step_no_ratio_and_no_rise_and_leaves_the_factor) {
  Judged judged;
  ASSERT_TRUE(judged.correct(2.2, 2.0));
  EXPECT_FALSE(judged.correct(2.2, 2.0, 0.0));
  EXPECT_EQ(judged.law.freeze(), Freeze::standstill);
  EXPECT_EQ(judged.law.step(), 1.0);
  EXPECT_EQ(judged.law.ratio(), 1.0);
  EXPECT_EQ(judged.law.rise_K(), 0.0);
  EXPECT_NEAR(judged.law.factor(), 1.1, 1e-12);
  judged.law.pass();
  EXPECT_EQ(judged.law.freeze(), Freeze::none);
  judged.law.wait();
  EXPECT_EQ(judged.law.freeze(), Freeze::waiting);
  EXPECT_NEAR(judged.law.factor(), 1.1, 1e-12);
  judged.law.stand_by();
  EXPECT_EQ(judged.law.freeze(), Freeze::waiting);
  EXPECT_EQ(judged.law.factor(), 1.0);
  ASSERT_TRUE(judged.correct(2.2, 2.0));
  judged.law.stand_by();
  EXPECT_EQ(judged.law.rise_K(), 0.0);
  EXPECT_EQ(judged.law.ratio(), 1.0);
  EXPECT_EQ(judged.law.step(), 1.0);
}

TEST(HeatLaw, moves_as_far_as_the_ratio_where_no_guard_forbids_it) {
  Judged judged;
  judged.options.guards = tests::no_guards();
  EXPECT_TRUE(judged.correct(4.0, 2.0));
  EXPECT_NEAR(judged.law.factor(), 2.0, 1e-12);
  judged.options.guards.deadband = true;
  EXPECT_FALSE(judged.correct(2.0, 2.0));
  EXPECT_NE(judged.law.freeze(), Freeze::deadband) << "of no width: the uncertainty is zero";
}

TEST(HeatLaw, turns_at_the_standstill_speed_itself_whichever_way) {
  Judged judged;
  for (const double speed_rpm : {1.0, -1.0}) {
    judged.correct(2.2, 2.0, speed_rpm);
    EXPECT_EQ(judged.law.freeze(), Freeze::none) << speed_rpm;
    judged.correct(2.2, 2.0, 0.99 * speed_rpm);
    EXPECT_EQ(judged.law.freeze(), Freeze::standstill) << speed_rpm;
  }
}

TEST(HeatLaw, has_settled_once_the_time_has_passed_but_for_rounding) {
  Judged judged;
  judged.correct(2.2, 2.0, 6000.0, 79.9);
  EXPECT_EQ(judged.law.freeze(), Freeze::operating_changed);
  judged.correct(2.2, 2.0, 6000.0, 80.0 - 1e-9);
  EXPECT_EQ(judged.law.freeze(), Freeze::none);
}

TEST(HeatLaw, a_rise_at_its_limit_counts_and_either_that_is_below_it_freezes) {
  Judged judged;
  judged.options.guards.deadband = false;
  judged.options.guards.reading_uncertainty_K = 0.0;
  judged.options.guards.minimum_rise_K = seen_K(0.5);
  judged.correct(0.5, 0.5);
  EXPECT_NE(judged.law.freeze(), Freeze::small_rise);
  judged.correct(-0.5, -0.5);
  EXPECT_NE(judged.law.freeze(), Freeze::small_rise) << "of a spindle that is colder too";
  judged.correct(0.499, 0.6);
  EXPECT_EQ(judged.law.freeze(), Freeze::small_rise);
  EXPECT_NEAR(judged.law.rise_K(), 0.6, 1e-12) << "the model's, also where it is not used";
  judged.correct(0.6, 0.499);
  EXPECT_EQ(judged.law.freeze(), Freeze::small_rise);
  judged.options.guards.minimum_rise_K = 0.0;
  judged.options.guards.reading_uncertainty_K = 0.06;
  judged.correct(0.61, 0.61);
  EXPECT_NE(judged.law.freeze(), Freeze::small_rise);
  judged.correct(0.59, 0.59);
  EXPECT_EQ(judged.law.freeze(), Freeze::small_rise) << "ten times the uncertainty";
}

TEST(HeatLaw, within_the_uncertainty_over_the_measured_rise_there_is_nothing_to_correct) {
  Judged judged;
  judged.options.guards.reading_uncertainty_K = 0.03;
  for (const double way : {1.0, -1.0}) {
    judged.correct(2.0, 2.0 * std::exp(way * 0.0149));
    EXPECT_EQ(judged.law.freeze(), Freeze::deadband);
    EXPECT_TRUE(judged.correct(2.0, 2.0 * std::exp(way * 0.0151)));
  }
  judged.options.guards.deadband = false;
  EXPECT_TRUE(judged.correct(2.0, 2.0 * std::exp(0.0149)));
}

TEST(HeatLaw, at_its_limits_it_stays_and_a_ratio_that_points_back_leaves_them) {
  Judged judged;
  judged.options.guards.heat_minimum = 0.9;
  judged.options.guards.heat_maximum = 1.2;
  EXPECT_TRUE(judged.correct(3.0, 2.0));
  EXPECT_EQ(judged.law.factor(), 1.2);
  EXPECT_NEAR(judged.law.step(), 1.2, 1e-12);
  EXPECT_FALSE(judged.correct(3.0, 2.0));
  EXPECT_EQ(judged.law.freeze(), Freeze::at_limit);
  EXPECT_EQ(judged.law.step(), 1.0);
  EXPECT_NEAR(judged.law.ratio(), 1.5, 1e-12);
  EXPECT_TRUE(judged.correct(1.8, 2.0));
  EXPECT_NEAR(judged.law.factor(), 1.2 * 0.9, 1e-12);
  for (int k = 0; k < 3; ++k) judged.correct(1.0, 2.0);
  EXPECT_EQ(judged.law.factor(), 0.9);
  EXPECT_EQ(judged.law.freeze(), Freeze::at_limit);
}

TEST(HeatLaw, a_rise_of_the_other_sign_is_no_ratio_and_none_at_all_only_one_of_the_additive_form) {
  Judged judged;
  judged.correct(-2.0, 2.0);
  EXPECT_EQ(judged.law.freeze(), Freeze::negative_ratio);
  EXPECT_NEAR(judged.law.ratio(), -1.0, 1e-12);
  judged.options.guards = tests::no_guards();
  judged.correct(0.0, 2.0);
  EXPECT_EQ(judged.law.freeze(), Freeze::negative_ratio);
  judged.correct(2.0, 0.0);
  EXPECT_EQ(judged.law.freeze(), Freeze::negative_ratio) << "not finite";
  EXPECT_EQ(judged.law.ratio(), 1.0);
  judged.options.form = RatioForm::as_printed_additive;
  judged.correct(1.0, 3.0);  // 1 + (1 − 3)/1 < 0: no heat
  EXPECT_EQ(judged.law.ratio(), 0.0);
  EXPECT_EQ(judged.law.freeze(), Freeze::none);
  EXPECT_EQ(judged.law.factor(), 0.0);
}

TEST(HeatLaw, wants_no_more_sensors_than_its_group_has_and_all_that_the_guard_asks_for) {
  Judged one(1), three(3);
  EXPECT_TRUE(one.correct(2.2, 2.0));
  three.options.guards.minimum_sensors = 3;
  EXPECT_TRUE(three.correct(2.2, 2.0));
  three.valid[1] = false;
  three.correct(2.2, 2.0);
  EXPECT_EQ(three.law.freeze(), Freeze::too_few_sensors);
  three.options.guards.minimum_sensors = 2;
  EXPECT_TRUE(three.correct(2.2, 2.0));
  one.valid[0] = false;
  one.correct(2.2, 2.0);
  EXPECT_EQ(one.law.freeze(), Freeze::too_few_sensors);
}

TEST(OperatingChanges, count_from_the_instant_on_at_which_speed_or_load_left_what_it_was_by_more_than_the_guard) {
  PaperGuards guards;
  rom::OperatingState state;
  state.speed_rpm = 1000.0;
  state.load = 0.5;
  OperatingChanges changes;
  changes.reset(state);
  EXPECT_EQ(changes.since_s(10.0), std::numeric_limits<double>::infinity());
  state.speed_rpm = 1050.0;
  changes.watch(20.0, state, guards);
  EXPECT_EQ(changes.since_s(20.0), std::numeric_limits<double>::infinity()) << "by as much as the guard";
  state.speed_rpm = 950.0;
  changes.watch(30.0, state, guards);
  EXPECT_EQ(changes.since_s(30.0), std::numeric_limits<double>::infinity());
  state.speed_rpm = 949.0;
  changes.watch(40.0, state, guards);
  EXPECT_EQ(changes.since_s(55.0), 15.0);
  state.speed_rpm = 999.0;
  changes.watch(60.0, state, guards);
  EXPECT_EQ(changes.since_s(60.0), 20.0) << "of what it was at that change";
  guards.load_change = 0.125;
  state.load = 0.625;
  changes.watch(70.0, state, guards);
  EXPECT_EQ(changes.since_s(70.0), 30.0);
  state.load = 0.626;
  changes.watch(80.0, state, guards);
  EXPECT_EQ(changes.since_s(81.0), 1.0);
  state.load = 0.5;
  changes.watch(90.0, state, guards);
  EXPECT_EQ(changes.since_s(90.0), 0.0);
}

TEST(PaperOptions, are_those_that_are_stated) {
  const PaperOptions options;
  EXPECT_EQ(options.period_s, 80.0);
  EXPECT_EQ(options.window_s, 10.0);
  EXPECT_EQ(options.relaxation, 1.0);
  EXPECT_TRUE(options.state_rescale);
  EXPECT_TRUE(options.heat_law);
  EXPECT_TRUE(options.joint_law);
  EXPECT_EQ(options.joint_exponent, 0.68);
  EXPECT_EQ(options.form, RatioForm::consistent);
  const PaperGuards& guards = options.guards;
  EXPECT_EQ(guards.reading_uncertainty_K, 0.03);
  EXPECT_EQ(guards.minimum_rise_K, 0.3);
  EXPECT_EQ(guards.step_minimum, 0.8);
  EXPECT_EQ(guards.step_maximum, 1.25);
  EXPECT_EQ(guards.heat_minimum, 0.2);
  EXPECT_EQ(guards.heat_maximum, 5.0);
  EXPECT_EQ(guards.resistance_minimum, 0.1);
  EXPECT_EQ(guards.resistance_maximum, 10.0);
  EXPECT_EQ(guards.resistance_step, 1.25);
  EXPECT_EQ(guards.minimum_sensors, 2);
  EXPECT_EQ(guards.settle_s, 80.0);
  EXPECT_EQ(guards.speed_change_rpm, 50.0);
  EXPECT_EQ(guards.load_change, 0.05);
  EXPECT_EQ(guards.standstill_rpm, 1.0);
  EXPECT_TRUE(guards.deadband);
}

}  // namespace paper_heat_law_test
}  // namespace spindle_twin::correction::test
