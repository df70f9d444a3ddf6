#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "rom/read/input_error.hpp"
#include "tests/correction/paper/one_node.hpp"

namespace spindle_twin::correction::test {
namespace paper_limits_test {

/// One body in 300 K, whose own rise is what stands above 300 K. Readings and predictions are told, sums are exact.
struct Told {
  explicit Told(const PaperOptions& options, int nodes = 1)
      : network(at_300_K(nodes)),
        correction(network, options, [=] { return std::make_unique<NodeStepper>(375.0, nodes); }),
        operating(network.boundaries.operating),
        measured_K(Eigen::VectorXd::Constant(3 * nodes, 300.0)),
        predicted_K(measured_K),
        nodes_K(Eigen::VectorXd::Constant(nodes, 300.0)),
        valid(Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(3 * nodes, true)) {}
  static rom::Network at_300_K(int nodes) {
    rom::Network network = node_network(375.0, 5.0, nodes);
    network.boundaries.reference_temperature_K = 300.0;
    network.boundaries.operating.environment_K.setConstant(300.0);
    return network;
  }
  void rises(double of_measured_K, double of_predicted_K) {
    measured_K.setConstant(300.0 + of_measured_K);
    predicted_K.setConstant(300.0 + of_predicted_K);
  }
  PaperStep step_at(double time_s, double advance_s = 1.0) {
    return correction.step({time_s, measured_K, valid, predicted_K, nodes_K, operating}, advance_s);
  }
  double heat() const { return correction.factors().heat[0]; }
  rom::Network network;
  PaperCorrection correction;
  rom::OperatingState operating;
  Eigen::VectorXd measured_K, predicted_K, nodes_K;
  Eigen::Array<bool, Eigen::Dynamic, 1> valid;
};

/// One reading per period and no joints; limits as by default.
PaperOptions plain() {
  PaperOptions options;
  options.window_s = 0.0;
  options.joint_law = false;
  return options;
}

Freeze freeze_after(const PaperOptions& options, double of_measured_K, double of_predicted_K) {
  Told told(options);
  told.rises(of_measured_K, of_predicted_K);
  told.step_at(0.0, 80.0);
  told.step_at(80.0);
  return told.correction.freeze(0);
}

TEST(PaperLimits, a_rise_of_the_least_that_counts_is_enough_measured_and_predicted) {
  PaperOptions options = plain();
  options.guards.minimum_rise_K = 0.5;
  for (const double less_K : {0.0, 0.0078125}) {
    const Freeze expected = less_K > 0.0 ? Freeze::small_rise : Freeze::none;
    EXPECT_EQ(freeze_after(options, 0.5 - less_K, 2.0), expected);
    EXPECT_EQ(freeze_after(options, 2.0, 0.5 - less_K), expected);
    EXPECT_EQ(freeze_after(options, -0.5 + less_K, -2.0), expected) << "of a spindle that is cooled too";
  }
  options.guards.reading_uncertainty_K = 0.125;
  EXPECT_EQ(freeze_after(options, 1.25, 4.0), Freeze::none) << "ten times the uncertainty";
  EXPECT_EQ(freeze_after(options, 1.2421875, 4.0), Freeze::small_rise);
}

TEST(PaperLimits, a_ratio_within_the_uncertainty_of_the_readings_corrects_nothing) {
  const double edge = std::exp(0.03 / 2.0);  // of a measured rise of 2 K with 0.03 K
  for (const double of_predicted_K : {2.0 * edge * 0.9999, 2.0 / edge * 1.0001}) {
    EXPECT_EQ(freeze_after(plain(), 2.0, of_predicted_K), Freeze::deadband);
  }
  for (const double of_predicted_K : {2.0 * edge * 1.0001, 2.0 / edge * 0.9999}) {
    EXPECT_EQ(freeze_after(plain(), 2.0, of_predicted_K), Freeze::none);
  }
  PaperOptions without = plain();
  without.guards.deadband = false;
  EXPECT_EQ(freeze_after(without, 2.0, 2.001), Freeze::none);
}

TEST(PaperLimits, small_ratios_are_no_negative_ones) {
  PaperOptions options = plain();
  options.guards.step_minimum = 0.001;
  Told told(options);
  told.rises(1.0, 64.0);
  told.step_at(0.0, 80.0);
  EXPECT_TRUE(told.step_at(80.0).corrected);
  EXPECT_EQ(told.correction.freeze(0), Freeze::none);
  EXPECT_DOUBLE_EQ(told.correction.ratio(0), 1.0 / 64.0);
  EXPECT_DOUBLE_EQ(told.heat(), 0.2) << "the least of all corrections together";
  EXPECT_EQ(freeze_after(options, -1.0, 64.0), Freeze::negative_ratio);
}

TEST(PaperLimits, changes_of_speed_and_load_up_to_their_limits_are_none) {
  PaperOptions options = plain();
  options.guards.load_change = 0.0625;
  struct Case {
    double speed_rpm, load;
    bool changed;
  };
  for (const Case& c : {Case{6050.0, 1.0, false}, Case{5950.0, 1.0, false}, Case{6050.5, 1.0, true},
                        Case{5949.5, 1.0, true}, Case{6000.0, 1.0625, false}, Case{6000.0, 0.9375, false},
                        Case{6000.0, 1.0703125, true}, Case{6000.0, 0.9296875, true}}) {
    Told told(options);
    told.rises(2.0, 4.0);
    told.step_at(0.0, 60.0);
    told.operating.speed_rpm = c.speed_rpm;
    told.operating.load = c.load;
    told.step_at(60.0, 20.0);
    told.step_at(80.0);
    EXPECT_EQ(told.correction.freeze(0), c.changed ? Freeze::operating_changed : Freeze::none) << c.speed_rpm << c.load;
  }
}

TEST(PaperLimits, what_has_settled_for_exactly_its_time_is_corrected) {
  for (const double settle_s : {40.0, 40.5}) {
    PaperOptions options = plain();
    options.guards.settle_s = settle_s;
    Told told(options);
    told.rises(2.0, 4.0);
    told.step_at(0.0, 40.0);
    told.operating.speed_rpm = 7000.0;
    told.step_at(40.0, 40.0);
    told.step_at(80.0);
    EXPECT_EQ(told.correction.freeze(0), settle_s == 40.0 ? Freeze::none : Freeze::operating_changed);
  }
}

TEST(PaperLimits, a_spindle_that_turns_at_the_limit_either_way_does_not_stand) {
  for (const double speed_rpm : {1.0, -1.0, 0.99, -0.99}) {
    PaperOptions options = plain();
    options.guards.settle_s = 0.0;
    Told told(options);
    told.operating.speed_rpm = speed_rpm;
    told.rises(2.0, 4.0);
    told.step_at(0.0, 80.0);
    EXPECT_EQ(told.step_at(80.0).corrected, std::abs(speed_rpm) == 1.0);
    EXPECT_EQ(told.correction.freeze(0), std::abs(speed_rpm) == 1.0 ? Freeze::none : Freeze::standstill);
  }
}

TEST(PaperLimits, as_many_sensors_as_are_wanted_are_enough_and_of_fewer_all_are_wanted) {
  for (const int wanted : {1, 2, 3, 9}) {
    for (const int valid : {0, 1, 2, 3}) {
      PaperOptions options = plain();
      options.guards.minimum_sensors = wanted;
      Told told(options);
      for (Eigen::Index k = 0; k < 3; ++k) told.valid[k] = k >= 3 - valid;
      told.rises(2.0, 4.0);
      told.step_at(0.0, 80.0);
      told.step_at(80.0);
      EXPECT_EQ(told.correction.freeze(0), valid >= std::min(wanted, 3) ? Freeze::none : Freeze::too_few_sensors);
    }
  }
}

/// A window of ten seconds before a correction at 80 s: what is read at 70 s is not of it, at 71 s it is.
TEST(PaperLimits, readings_of_the_window_alone_count_and_all_of_them) {
  for (const int odd_s : {69, 70, 71, 75, 80}) {
    PaperOptions options = plain();
    options.window_s = 10.0;
    options.guards.deadband = false;
    options.guards.step_minimum = 0.01;
    Told told(options);
    for (int t = 0; t <= 80; ++t) {
      told.rises(t == odd_s ? 12.0 : 2.0, 4.0);
      told.step_at(t);
    }
    EXPECT_NEAR(told.correction.ratio(0), odd_s > 70 ? 3.0 / 4.0 : 2.0 / 4.0, 1e-12) << odd_s;
  }
}

TEST(PaperLimits, after_a_gap_the_next_correction_is_a_whole_period_later) {
  for (const double gap_end_s : {160.0, 240.0, 250.0}) {
    PaperOptions options = plain();
    options.guards.deadband = false;
    options.guards.heat_minimum = 1e-6;
    Told told(options);
    told.rises(2.0, 4.0);
    told.step_at(0.0);
    EXPECT_TRUE(told.step_at(80.0).corrected);
    EXPECT_TRUE(told.step_at(gap_end_s).corrected);
    for (double since_s = 1.0; since_s <= 81.0; since_s += 1.0) {
      EXPECT_EQ(told.step_at(gap_end_s + since_s).corrected, since_s == 80.0) << gap_end_s << " + " << since_s;
    }
  }
}

TEST(PaperLimits, corrections_keep_their_times_where_cycles_do_not_meet_them) {
  PaperOptions options = plain();
  options.guards.deadband = false;
  options.guards.heat_minimum = 1e-6;
  Told told(options);
  told.rises(2.0, 4.0);
  int corrections = 0;
  for (double time_s = 0.0; time_s < 2000.0; time_s += 7.0) {
    if (!told.step_at(time_s, 7.0).corrected) continue;
    ++corrections;
    EXPECT_EQ(time_s, 7.0 * std::ceil(80.0 * corrections / 7.0));
  }
  EXPECT_EQ(corrections, 24);
}

TEST(PaperLimits, a_group_may_name_the_last_sensor_and_heat_and_none_behind_them) {
  const rom::Network network = Told::at_300_K(1);
  const auto made_of = [&](int key_point, int source) {
    PaperOptions options = plain();
    options.groups = {{"one", {key_point}, {source}}};
    PaperCorrection(network, options, [] { return std::make_unique<NodeStepper>(375.0); });
  };
  EXPECT_NO_THROW(made_of(0, 0));
  EXPECT_NO_THROW(made_of(2, 0));
  EXPECT_THROW(made_of(3, 0), rom::InputError);
  EXPECT_THROW(made_of(-1, 0), rom::InputError);
  EXPECT_THROW(made_of(0, 1), rom::InputError);
  EXPECT_THROW(made_of(0, -1), rom::InputError);
}

TEST(PaperLimits, one_step_says_by_what_the_factor_has_moved_and_nothing_where_it_stands) {
  PaperOptions options = plain();
  options.guards.heat_minimum = 0.7;
  Told told(options);
  told.rises(1.0, 4.0);
  told.step_at(0.0);
  told.step_at(80.0);
  EXPECT_DOUBLE_EQ(told.heat(), 0.8);
  const PaperStep second = told.step_at(160.0);
  EXPECT_TRUE(second.corrected);
  EXPECT_TRUE(second.state_rescaled);
  EXPECT_DOUBLE_EQ(told.heat(), 0.7);
  const PaperStep third = told.step_at(240.0);
  EXPECT_FALSE(third.corrected);
  EXPECT_FALSE(third.state_rescaled);
  EXPECT_EQ(told.correction.freeze(0), Freeze::at_limit);
  EXPECT_DOUBLE_EQ(told.heat(), 0.7);
}

}  // namespace paper_limits_test
}  // namespace spindle_twin::correction::test
