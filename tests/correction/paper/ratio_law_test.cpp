#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <vector>

#include "correction/paper/rise_ratio.hpp"
#include "tests/correction/paper/one_node.hpp"

namespace spindle_twin::correction::test {
namespace paper_ratio_law_test {

constexpr double celsius_zero_K = 273.15;
constexpr double published_excess = 4.95 / 2.29;  // the paper's uncorrected rise over the twin's

struct Range {
  double minimum = 1e9;
  double maximum = -1e9;
};

/// Extremes of heat over true heat after the first correction.
Range heat_range(Loop& loop, double end_s) {
  Range range;
  while (loop.time_s < end_s) {
    loop.cycle(80.0);
    if (loop.time_s < 100.0) continue;
    range.minimum = std::min(range.minimum, loop.heat_ratio());
    range.maximum = std::max(range.maximum, loop.heat_ratio());
  }
  return range;
}

TEST(RatioLaw, published_law_follows_the_exact_one_node_trajectory) {
  Loop loop(375.0, published_excess, published_law());
  const std::vector<std::pair<double, double>> expected = {{80, 1.0},
                                                           {160, 0.658297768656},
                                                           {240, 0.563011943455},
                                                           {320, 0.582620059817},
                                                           {400, 0.682270714773},
                                                           {720, 1.26577593136},
                                                           {1200, 0.897330568188}};
  for (const auto& [time_s, heat] : expected) {
    while (loop.time_s <= time_s) loop.cycle(80.0);  // the correction at time_s has acted
    EXPECT_NEAR(loop.heat_ratio(), heat, 1e-10) << "at " << time_s << " s";
  }
}

TEST(RatioLaw, rise_errors_from_a_cold_start_with_heat_times_1_6) {
  Loop loop(300.0, 1.6, published_law());
  const std::array<double, 8> expected_percent = {60.0, 26.0, 6.2, -5.0, -10.2, -10.8, -8.3, -4.2};
  loop.cycle(80.0);
  for (const double percent : expected_percent) {
    EXPECT_NEAR(100.0 * loop.rise_error(), percent, percent > 20.0 ? 0.5 : 0.05) << "at " << loop.time_s << " s";
    loop.cycle(80.0);
  }
}

/// In 1800 s the last correction is that of 1760 s.
TEST(RatioLaw, slow_spindle_still_rings_at_the_end_of_the_experiment) {
  Loop loop(600.0, 1.6, published_law());
  double lowest = 0.0;
  double at_last_correction = 0.0;
  for (int second = 0; second < 1800; ++second) {
    if (second == 1760) at_last_correction = loop.rise_error();
    loop.cycle(1.0);
    if (second > 0) lowest = std::min(lowest, loop.rise_error());
  }
  EXPECT_NEAR(100.0 * lowest, -11.1, 0.05);
  EXPECT_NEAR(100.0 * at_last_correction, -2.8, 0.05);
}

TEST(RatioLaw, swing_of_the_heat_for_each_relaxation) {
  struct Case {
    double relaxation, minimum, maximum;
  };
  for (const Case& item : {Case{1.0, 0.563, 1.266}, Case{0.3, 0.809, 1.715}, Case{0.0532828229, 1.001, 2.075}}) {
    PaperOptions options = published_law();
    options.relaxation = item.relaxation;
    Loop loop(375.0, published_excess, options);
    const Range range = heat_range(loop, 6000.0);
    EXPECT_NEAR(range.minimum, item.minimum, 0.0006) << item.relaxation;
    EXPECT_NEAR(range.maximum, item.maximum, 0.0006) << item.relaxation;
  }
}

TEST(RatioLaw, step_clamp_of_1_25_slows_the_law_but_rings_on) {
  PaperOptions options = published_law();
  options.guards.step_minimum = 0.8;
  options.guards.step_maximum = 1.25;
  Loop loop(375.0, published_excess, options);
  const Range range = heat_range(loop, 4000.0);
  EXPECT_NEAR(range.minimum, 0.597, 0.0006);
  EXPECT_NEAR(range.maximum, 1.729, 0.0015);
}

/// Linearised: x(k+2) - (1 + a - g(1 - a)) x(k+1) + a x(k) = 0, a = exp(-T/tau): the envelope sqrt(a) per cycle, 2 tau,
/// does not depend on the gain g.
TEST(RatioLaw, envelope_is_twice_the_time_constant_whatever_the_gain) {
  const double a = std::exp(-80.0 / 375.0);
  for (const double gain : {1.0, 0.5, 0.2}) {
    PaperOptions options = published_law();
    options.relaxation = gain;
    Loop loop(375.0, 1.0 + 1e-6, options);
    loop.correction.reset(0.0, Eigen::VectorXd::Constant(1, ambient_K), loop.operating);
    const Eigen::VectorXd steady_K = Eigen::VectorXd::Constant(1, ambient_K + Loop::true_rise_K);
    loop.plant.set_temperatures(steady_K);
    loop.twin.set_temperatures(steady_K);
    std::vector<double> x;
    for (int k = 0; k < 12; ++k) {
      loop.cycle(80.0);
      x.push_back(std::log(loop.heat_ratio()));
    }
    for (std::size_t k = 2; k + 2 < x.size(); ++k) {
      EXPECT_NEAR(x[k + 2] - (1.0 + a - gain * (1.0 - a)) * x[k + 1] + a * x[k], 0.0, 1e-11);
    }
    ASSERT_GT(std::abs(x[2]), 1e-8);
  }
}

TEST(RatioLaw, rescaling_the_state_settles_in_one_correction) {
  PaperOptions options = published_law();
  options.state_rescale = true;
  Loop loop(375.0, published_excess, options);
  loop.run_until(81.0, 1.0);
  EXPECT_NEAR(loop.heat_ratio(), 1.0, 1e-12);
  EXPECT_NEAR(loop.rise_error(), 0.0, 1e-12);
  loop.run_until(1800.0, 1.0);
  EXPECT_NEAR(loop.heat_ratio(), 1.0, 1e-9);
}

/// Roots 1 - g and a: no oscillation for any gain when input and state are corrected together.
TEST(RatioLaw, rescaled_state_never_undershoots_under_relaxation) {
  for (const double gain : {0.3, 0.6, 1.0}) {
    PaperOptions options = published_law();
    options.state_rescale = true;
    options.relaxation = gain;
    Loop loop(375.0, published_excess, options);
    double before = loop.heat_ratio();
    for (int k = 0; k < 40; ++k) {
      loop.cycle(80.0);
      EXPECT_LE(loop.heat_ratio(), before + 1e-12);
      EXPECT_GE(loop.heat_ratio(), 1.0 - 1e-9);
      before = loop.heat_ratio();
    }
    EXPECT_NEAR(before, 1.0, 1e-5);
  }
}

TEST(RatioLaw, window_mean_of_both_sides_finds_the_same_factor_as_one_reading) {
  PaperOptions options = published_law();
  options.window_s = 80.0;
  Loop loop(375.0, published_excess, options);
  loop.run_until(81.0, 1.0);
  EXPECT_NEAR(loop.heat_ratio(), 1.0, 1e-12);
}

TEST(RatioLaw, moving_ambient_does_not_disturb_the_consistent_form) {
  PaperOptions options = published_law();
  options.state_rescale = true;
  Loop loop(375.0, published_excess, options);
  while (loop.time_s < 1600.0) {
    loop.operating.environment_K[0] = ambient_K + 5.0 * std::sin(loop.time_s / 300.0);
    loop.cycle(1.0);
    if (loop.time_s > 81.0) {
      ASSERT_NEAR(loop.heat_ratio(), 1.0, 1e-9) << loop.time_s;
    }
  }
}

TEST(RatioLaw, printed_eq3_reads_the_moving_ambient_as_heat) {
  PaperOptions options = published_law();
  options.state_rescale = true;
  options.form = RatioForm::as_printed_eq3;
  Loop loop(375.0, published_excess, options);
  double worst = 0.0;
  while (loop.time_s < 1600.0) {
    loop.operating.environment_K[0] = ambient_K + 5.0 * std::sin(loop.time_s / 300.0);
    loop.cycle(1.0);
    if (loop.time_s > 81.0) worst = std::max(worst, std::abs(std::log(std::max(loop.heat_ratio(), 1e-9))));
  }
  EXPECT_GT(worst, 0.2);
}

TEST(RatioLaw, printed_additive_form_kills_the_heat_at_the_papers_own_excess) {
  PaperOptions options = published_law();
  options.form = RatioForm::as_printed_additive;
  Loop loop(375.0, published_excess, options);
  loop.run_until(161.0, 80.0);
  EXPECT_EQ(loop.heat_ratio(), 0.0);
}

TEST(RatioForms, values_of_the_papers_readings) {
  struct Case {
    double measured_C, model_C, eq3, additive;
  };
  for (const Case& item :
       {Case{29.44, 31.95, 0.4929292929293, 0.0}, Case{29.29, 29.29, 1.0, 1.0}, Case{27.1, 27.05, 2.0, 1.5},
        Case{29.06, 29.07, 0.9951690821256, 0.995145631068}, Case{28.0, 33.0, 0.1666666666667, 0.0}}) {
    const Eigen::VectorXd measured_K = Eigen::VectorXd::Constant(1, item.measured_C + celsius_zero_K);
    const Eigen::VectorXd model_K = Eigen::VectorXd::Constant(1, item.model_C + celsius_zero_K);
    const Eigen::VectorXd zero_K = Eigen::VectorXd::Constant(1, 27.0 + celsius_zero_K);
    for (const RatioForm form : {RatioForm::consistent, RatioForm::average_ratio, RatioForm::as_printed_eq3}) {
      EXPECT_NEAR(rise_ratio(form, measured_K, model_K, zero_K).ratio, item.eq3, 1e-11);
    }
    EXPECT_NEAR(rise_ratio(RatioForm::as_printed_additive, measured_K, model_K, zero_K).ratio, item.additive, 1e-11);
  }
}

TEST(RatioForms, cold_sensor_dominates_the_mean_of_ratios_but_not_the_ratio_of_sums) {
  const Eigen::Vector3d measured_K(2.0, 2.0, 0.2);
  const Eigen::Vector3d model_K(2.0, 2.0, 0.1);
  const Eigen::Vector3d zero_K = Eigen::Vector3d::Zero();
  EXPECT_NEAR(rise_ratio(RatioForm::consistent, measured_K, model_K, zero_K).ratio, 4.2 / 4.1, 1e-14);
  EXPECT_NEAR(rise_ratio(RatioForm::as_printed_eq3, measured_K, model_K, zero_K).ratio, 4.0 / 3.0, 1e-14);
}

TEST(RatioForms, the_rise_told_is_the_mean_of_sums_and_else_the_smallest_in_magnitude_whatever_its_place) {
  const Eigen::Vector3d zero_K = Eigen::Vector3d::Constant(290.0);
  for (const Eigen::Vector3d& rise_K : {Eigen::Vector3d(0.5, -2.0, 4.0), Eigen::Vector3d(4.0, -2.0, 0.5)}) {
    const Eigen::VectorXd measured_K = zero_K + rise_K, model_K = zero_K + 2.0 * rise_K;
    const RiseRatio mean = rise_ratio(RatioForm::consistent, measured_K, model_K, zero_K);
    EXPECT_NEAR(mean.measured_rise_K, 2.5 / 3.0, 1e-12);
    EXPECT_NEAR(mean.model_rise_K, 5.0 / 3.0, 1e-12);
    for (const RatioForm form : {RatioForm::average_ratio, RatioForm::as_printed_eq3}) {
      const RiseRatio least = rise_ratio(form, measured_K, model_K, zero_K);
      EXPECT_NEAR(least.measured_rise_K, 0.5, 1e-12);
      EXPECT_NEAR(least.model_rise_K, 1.0, 1e-12);
    }
  }
}

TEST(HeatGroups, each_group_finds_its_own_factor_and_the_state_follows) {
  PaperOptions options = published_law();
  options.state_rescale = true;
  options.groups = {{"front", {0, 1, 2}, {0}}, {"rear", {3, 4, 5}, {1}}};
  Loop loop(375.0, 2.0, options, 2);
  loop.true_heat << 0.4, 1.7;
  loop.run_until(161.0, 1.0);
  EXPECT_NEAR(loop.heat_ratio(0), 1.0, 1e-12);
  EXPECT_NEAR(loop.heat_ratio(1), 1.0, 1e-12);
  EXPECT_NEAR((loop.twin.temperatures_K() - loop.plant.temperatures_K()).norm(), 0.0, 1e-12);
  loop.run_until(1800.0, 1.0);
  EXPECT_NEAR(loop.heat_ratio(1), 1.0, 1e-9);
}

TEST(HeatGroups, source_outside_every_group_keeps_its_heat) {
  PaperOptions options = published_law();
  options.groups = {{"front", {0, 1, 2}, {0}}};
  Loop loop(375.0, 2.0, options, 2);
  loop.run_until(401.0, 1.0);
  EXPECT_NE(loop.correction.factors().heat[0], 1.0);
  EXPECT_EQ(loop.correction.factors().heat[1], 1.0);
}

}  // namespace paper_ratio_law_test
}  // namespace spindle_twin::correction::test
