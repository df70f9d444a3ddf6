#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "rom/read/input_error.hpp"
#include "tests/correction/paper/one_node.hpp"

namespace spindle_twin::correction::test {
namespace paper_guards_test {

/// Guards on, one reading per period, so that every case is exact.
PaperOptions guarded() {
  PaperOptions options;
  options.window_s = 0.0;
  options.relaxation = 1.0;
  options.joint_law = false;
  return options;
}

TEST(Guards, nothing_moves_before_the_first_period) {
  Loop loop(375.0, 2.16, guarded());
  loop.run_until(79.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::waiting);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
}

TEST(Guards, correction_comes_exactly_once_a_period) {
  Loop loop(375.0, 2.16, guarded());
  int corrections = 0;
  while (loop.time_s < 330.0) {
    const double time_s = loop.time_s;
    if (loop.cycle(0.1).corrected) {
      ++corrections;
      EXPECT_NEAR(time_s, 80.0 * corrections, 1e-6);
    }
  }
  EXPECT_EQ(corrections, 4);
}

TEST(Guards, one_step_stays_inside_its_clamp) {
  Loop hot(375.0, 2.16, guarded());
  hot.run_until(81.0, 1.0);
  EXPECT_DOUBLE_EQ(hot.correction.factors().heat[0], 0.8);
  EXPECT_LT(hot.correction.ratio(0), 0.8);
  Loop cold(375.0, 0.5, guarded());
  cold.run_until(241.0, 1.0);  // at 80 s the twin's rise is still too small
  EXPECT_DOUBLE_EQ(cold.correction.factors().heat[0], 1.25 * 1.25);
}

TEST(Guards, cumulative_limit_holds_and_does_not_wind_up) {
  Loop loop(375.0, 10.0, guarded());
  loop.network.boundaries.sources[0].nominal_W *= 2.0;
  loop.true_heat[0] = 0.1;
  loop.run_until(1500.0, 1.0);
  EXPECT_DOUBLE_EQ(loop.correction.factors().heat[0], 0.2);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::at_limit);
  loop.true_heat[0] = 0.4;  // the first correction that wants more heat leaves the limit
  loop.run_until(4000.0, 1.0);
  EXPECT_NEAR(loop.correction.factors().heat[0], 0.4, 0.02);
}

TEST(Guards, small_rise_freezes) {
  Loop loop(375.0, 2.16, guarded());
  loop.network.boundaries.sources[0].nominal_W = 0.2;
  loop.run_until(2000.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::small_rise);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
}

TEST(Guards, uncertain_readings_raise_the_smallest_rise_to_ten_times_their_uncertainty) {
  PaperOptions options = guarded();
  options.guards.reading_uncertainty_K = 0.12;
  Loop loop(375.0, 2.16, options);
  loop.run_until(81.0, 1.0);  // true rise 0.44 K: enough for 0.3 K, not for 1.2 K
  EXPECT_EQ(loop.correction.freeze(0), Freeze::small_rise);
}

TEST(Guards, measured_rise_of_the_other_sign_freezes) {
  Loop loop(375.0, 2.16, guarded());
  loop.offset_K.setConstant(-3.0);
  loop.run_until(81.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::negative_ratio);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
}

TEST(Guards, fewer_than_two_sensors_freeze_and_recovery_unfreezes) {
  Loop loop(375.0, 2.16, guarded());
  loop.valid << true, false, false;
  loop.run_until(81.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::too_few_sensors);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
  loop.valid.setConstant(true);
  loop.run_until(161.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::none);
  EXPECT_LT(loop.correction.factors().heat[0], 1.0);
}

TEST(Guards, bad_sensor_is_left_out_and_the_others_carry_on) {
  for (const double reading : {1000.0, std::numeric_limits<double>::quiet_NaN()}) {
    Loop loop(375.0, 2.16, guarded());
    loop.offset_K[1] = reading;
    loop.valid << true, std::isnan(reading), true;  // a reading that is not finite is never believed
    loop.run_until(801.0, 1.0);
    EXPECT_NEAR(loop.heat_ratio(), 1.0, 0.02);
  }
}

TEST(Guards, sensor_that_drops_out_inside_the_window_does_not_count) {
  PaperOptions options = guarded();
  options.window_s = 10.0;
  options.guards.minimum_sensors = 3;
  Loop loop(375.0, 2.16, options);
  loop.run_until(75.0, 1.0);
  loop.valid[0] = false;
  loop.cycle(1.0);
  loop.valid[0] = true;
  loop.run_until(81.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::too_few_sensors);
}

TEST(Guards, speed_change_freezes_for_the_settling_time) {
  Loop loop(375.0, 2.16, guarded());
  loop.run_until(400.0, 1.0);
  const double before = loop.correction.factors().heat[0];
  loop.cycle(1.0);
  loop.operating.speed_rpm = 6100.0;
  loop.run_until(481.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::operating_changed);
  loop.run_until(561.0, 1.0);
  EXPECT_NE(loop.correction.freeze(0), Freeze::operating_changed);
  EXPECT_GT(before, 0.0);
}

TEST(Guards, slow_ramp_of_load_is_noticed_as_a_change) {
  Loop loop(375.0, 2.16, guarded());
  while (loop.time_s < 401.0) {
    loop.operating.load = 1.0 + 0.001 * loop.time_s;
    loop.cycle(1.0);
  }
  EXPECT_EQ(loop.correction.freeze(0), Freeze::operating_changed);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
}

TEST(Guards, standstill_freezes_heat_and_joints) {
  PaperOptions options = guarded();
  options.joint_law = true;
  options.guards.settle_s = 0.0;
  Loop loop(375.0, 2.16, options);
  loop.run_until(321.0, 1.0);
  const double before = loop.correction.factors().heat[0];
  loop.operating.speed_rpm = 0.0;
  loop.run_until(400.0, 1.0);
  EXPECT_FALSE(loop.cycle(1.0).corrected);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::standstill);
  EXPECT_EQ(loop.correction.factors().heat[0], before);
}

TEST(Guards, with_a_standstill_below_no_speed_at_all_a_spindle_that_stands_is_judged_as_any_other) {
  PaperOptions options = guarded();
  options.guards.standstill_rpm = 0.0;
  options.guards.settle_s = 0.0;
  Loop loop(375.0, 2.16, options);
  loop.operating.speed_rpm = 0.0;
  loop.run_until(400.0, 1.0);
  EXPECT_NE(loop.correction.freeze(0), Freeze::standstill);
}

TEST(Guards, deadband_keeps_the_factor_still_once_it_is_good_enough) {
  Loop loop(375.0, 1.005, guarded());
  loop.run_until(1601.0, 1.0);
  EXPECT_EQ(loop.correction.freeze(0), Freeze::deadband);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
}

TEST(Guards, failed_base_freezes_the_next_correction_only) {
  PaperOptions options = guarded();
  const rom::Network network = node_network(375.0, 5.0);
  PaperCorrection correction(network, options, [] { return std::make_unique<NodeStepper>(375.0); });
  const Eigen::VectorXd model_K = Eigen::VectorXd::Constant(3, ambient_K + 4.0);
  const Eigen::VectorXd measured_K = Eigen::VectorXd::Constant(3, ambient_K + 3.5);
  const Eigen::VectorXd nodes_K = Eigen::VectorXd::Constant(1, ambient_K);
  const Eigen::Array<bool, Eigen::Dynamic, 1> valid = Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(3, true);
  const auto step = [&](double time_s) {
    correction.step({time_s, measured_K, valid, model_K, nodes_K, network.boundaries.operating}, 80.0);
  };
  NodeStepper::fail = true;
  step(0.0);
  NodeStepper::fail = false;
  step(80.0);
  EXPECT_EQ(correction.freeze(0), Freeze::base_failed);
  step(160.0);
  EXPECT_EQ(correction.freeze(0), Freeze::none);
}

TEST(Guards, heat_law_switched_off_leaves_the_heat_alone) {
  PaperOptions options = guarded();
  options.heat_law = false;
  Loop loop(375.0, 2.16, options);
  loop.run_until(801.0, 1.0);
  EXPECT_EQ(loop.correction.factors().heat[0], 1.0);
}

TEST(Guards, option_out_of_range_is_one_error_that_names_it) {
  const rom::Network network = node_network(375.0, 5.0);
  const auto message = [&](const std::function<void(PaperOptions&)>& spoil) -> std::string {
    PaperOptions options;
    spoil(options);
    try {
      PaperCorrection(network, options, [] { return std::make_unique<NodeStepper>(375.0); });
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message([](PaperOptions& o) { o.relaxation = 0.0; }),
            "relaxation: must be a number from 0 (excluded) to 1");
  EXPECT_EQ(message([](PaperOptions& o) { o.period_s = std::nan(""); }),
            "period_s: must be a number from 0 (excluded) to 86400");
  EXPECT_EQ(message([](PaperOptions& o) { o.window_s = 81.0; }), "window_s: must be from 0 s to period_s");
  EXPECT_EQ(message([](PaperOptions& o) { o.guards.step_maximum = 1.0; }),
            "step_maximum: must be a number from 1 (excluded) to 1e+06");
  EXPECT_EQ(message([](PaperOptions& o) {
              o.groups = {{"rear", {7}, {0}}};
            }),
            "group rear: names a key point that the network does not have");
  EXPECT_EQ(message([](PaperOptions& o) {
              o.groups = {{"a", {0}, {0}}, {"b", {1}, {0}}};
            }),
            "group b: a heat source may be in one group only");
}

}  // namespace paper_guards_test
}  // namespace spindle_twin::correction::test
