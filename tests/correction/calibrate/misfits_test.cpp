#include "correction/calibrate/misfits.hpp"

#include <gtest/gtest.h>

#include "tests/correction/calibrate/fitted_node.hpp"

namespace spindle_twin::correction::test {
namespace calibrate_misfits_test {

/// Of one node with 100 W in all: what is asked of it and nothing else.
struct Asked : testing::Test {
  Asked() {
    for (rom::HeatSource& source : node.network.boundaries.sources) source.nominal_W = 0.0;
    node.network.boundaries.sources.front().nominal_W = 100.0;
  }
  std::vector<std::string> misfits(double heat_W, double deviation_W, double after_W, double before_deviation_W = 1e3) {
    CalibrationResult result;
    result.asked = {{"body", heat_W, deviation_W}};
    result.held_out.heat = HeldOutHeat{{"body", heat_W, before_deviation_W}, {"body", after_W, 2.0}};
    return misfits_of(result, node.network, node.options, {});
  }
  FittedNode node;
};

TEST_F(Asked, a_heat_counts_from_four_deviations_on_where_the_last_quarter_agrees_and_from_eight_alone) {
  EXPECT_TRUE(misfits(10.0, 10.0 / 3.9, 5.0).empty());
  ASSERT_EQ(misfits(10.0, 10.0 / 4.1, 5.0).size(), 1U);
  EXPECT_EQ(misfits(10.0, 10.0 / 4.1, 5.0)[0], "the readings ask for 10 W +- 2.4 W in body that no source explains");
  EXPECT_TRUE(misfits(10.0, 10.0 / 4.1, 1.9).empty()) << "no more than one deviation of what is held out";
  EXPECT_TRUE(misfits(10.0, 10.0 / 7.9, -5.0).empty()) << "the other sign";
  EXPECT_EQ(misfits(10.0, 10.0 / 8.1, -5.0).size(), 1U);
  EXPECT_EQ(misfits(-10.0, 10.0 / 4.1, -5.0).size(), 1U);
}

TEST_F(Asked, less_than_a_hundredth_of_all_heats_counts_never) {
  EXPECT_TRUE(misfits(0.99, 0.01, 5.0, 0.01).empty());
  EXPECT_EQ(misfits(1.01, 0.01, 5.0, 0.01).size(), 2U) << "held out and by all readings";
}

/// A probe that reads so many times what was foreseen, on a quarter of an hour of growth by 20 um.
std::vector<std::string> hints(double times, double of_noise_m = 0.0) {
  const FittedNode node;
  CalibrationResult result;
  result.before.resize(1);
  for (int minute = 0; minute < 15; ++minute) {
    const double foreseen_m = 20e-6 * minute / 15.0;
    const double value_m = 5e-6 + times * foreseen_m + (minute % 2 == 0 ? of_noise_m : -of_noise_m);
    result.before[0].readings.push_back(
        {60.0 * minute, static_cast<int>(node.options.sensors.size()), value_m - foreseen_m, 0.0, 1, 0.0, value_m});
  }
  return hints_of(result, node.network, node.options);
}

TEST(Hints, say_what_a_probe_seems_to_read_and_nothing_of_one_that_reads_about_what_was_foreseen) {
  for (const double times : {0.3, 1.0, 3.0}) EXPECT_TRUE(hints(times).empty()) << times;
  EXPECT_EQ(hints(-1.0)[0], "nose, log 1: reads -1 times what was foreseen; + must be a spindle that is longer");
  EXPECT_EQ(hints(1e-3)[0], "nose, log 1: reads 0.001 times what was foreseen; is it in mm, not um?");
  EXPECT_EQ(hints(1.2e3)[0], "nose, log 1: reads 1.2e+03 times what was foreseen; is it in nm, not um?");
  EXPECT_EQ(hints(10.0)[0], "nose, log 1: reads 10 times what was foreseen");
  EXPECT_TRUE(hints(-1.0, 20e-6).empty()) << "hidden in noise";
}

}  // namespace calibrate_misfits_test
}  // namespace spindle_twin::correction::test
