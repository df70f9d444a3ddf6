#include "firmware/cycle/plausible.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/firmware/support/small_network.hpp"

namespace spindle_twin::firmware {
namespace cycle_plausible_test {

/// Three sensors at 310, 305 and 300 K, surroundings at 298 K; predictions at 304 K.
struct Predicted {
  Predicted() : network(spindle_twin::tests::small_network()) {
    const std::array<double, 3> readings_K{310.0, 305.0, 300.0};
    for (std::size_t k = 0; k < readings_K.size(); ++k) {
      judgement.sensors[k] = SensorQuality::good;
      sensed.sensors[k].value = readings_K[k];
    }
    judgement.signals[static_cast<std::size_t>(Signal::coolant)] = 298.0;
    judgement.signals[static_cast<std::size_t>(Signal::ambient)] = 298.0;
    for (Model* model : {&corrected, &uncorrected}) {
      model->outputs = rom::make_network_outputs(network);
      model->outputs.key_points_K.setConstant(304.0);
      model->outputs.part_maximum_K.setConstant(304.0);
    }
    uncorrected.outputs.key_points_K[0] = 310.0;  // as hot as its reading says
  }
  double outside() const { return outside_K(network, judgement, sensed, corrected, uncorrected); }
  rom::Network network;
  Judgement judgement;
  SensedInputs sensed;
  Model corrected, uncorrected;
};

TEST(Plausible, inside_the_span_of_readings_and_surroundings_nothing_is_outside) {
  Predicted predicted;
  EXPECT_EQ(predicted.outside(), 0.0);
  predicted.corrected.outputs.key_points_K << 310.0, 298.0, 299.0;
  predicted.corrected.outputs.part_maximum_K << 310.0, 298.0, 309.0;
  EXPECT_EQ(predicted.outside(), 0.0);
}

TEST(Plausible, what_leaves_the_span_counts_by_how_far_it_does_so_beyond_the_uncorrected) {
  Predicted predicted;
  predicted.corrected.outputs.key_points_K[1] = 317.0;
  EXPECT_DOUBLE_EQ(predicted.outside(), 7.0);
  predicted.corrected.outputs.part_maximum_K[2] = 280.0;
  EXPECT_DOUBLE_EQ(predicted.outside(), 18.0);
  predicted.uncorrected.outputs.part_maximum_K[2] = 290.0;
  EXPECT_DOUBLE_EQ(predicted.outside(), 10.0);
  predicted.uncorrected.outputs.part_maximum_K[2] = 250.0;
  predicted.uncorrected.outputs.key_points_K[1] = 330.0;
  EXPECT_EQ(predicted.outside(), 0.0) << "who leaves it less than the uncorrected does not leave it";
}

TEST(Plausible, no_number_is_infinitely_far_outside) {
  Predicted predicted;
  predicted.corrected.outputs.key_points_K[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(predicted.outside(), std::numeric_limits<double>::infinity());
  predicted.corrected.outputs.key_points_K[0] = 304.0;
  predicted.corrected.outputs.part_maximum_K[0] = std::numeric_limits<double>::infinity();
  EXPECT_EQ(predicted.outside(), std::numeric_limits<double>::infinity());
}

TEST(Plausible, readings_out_of_range_and_sensors_that_are_not_there_make_no_span) {
  Predicted predicted;
  predicted.corrected.outputs.key_points_K[1] = 317.0;
  predicted.judgement.sensors[0] = SensorQuality::out_of_range;
  EXPECT_DOUBLE_EQ(predicted.outside(), 12.0);
  predicted.judgement.sensors[1] = SensorQuality::not_configured;
  EXPECT_DOUBLE_EQ(predicted.outside(), 13.0);  // the uncorrected 304 K are 4 K outside, too
  predicted.judgement.sensors[0] = SensorQuality::stale;
  EXPECT_DOUBLE_EQ(predicted.outside(), 7.0);
  predicted.sensed.sensors[0].value = std::numeric_limits<double>::quiet_NaN();
  EXPECT_DOUBLE_EQ(predicted.outside(), 13.0);  // the uncorrected 304 K are 4 K outside, too
}

/// Where a place with a sensor has three times the rise of the uncorrected model, one without may have that too.
TEST(Plausible, a_spindle_that_readings_show_to_be_hotter_than_described_may_be_so_where_no_sensor_is) {
  Predicted predicted;
  predicted.uncorrected.outputs.key_points_K.setConstant(304.0);  // rises of 6 K: the reading of 310 K is twice that
  predicted.uncorrected.outputs.part_maximum_K[2] = 318.0;        // twice its rise of 20 K is 338 K
  predicted.corrected.outputs.part_maximum_K[2] = 360.0;
  EXPECT_DOUBLE_EQ(predicted.outside(), 22.0);
  predicted.sensed.sensors[0].value = 316.0;  // three times: 358 K
  EXPECT_DOUBLE_EQ(predicted.outside(), 2.0);
  predicted.uncorrected.outputs.part_maximum_K[1] = 290.0;  // what is colder than the surroundings stays what it is
  predicted.corrected.outputs.part_maximum_K[1] = 285.0;
  EXPECT_DOUBLE_EQ(predicted.outside(), 5.0);
  predicted.corrected.outputs.part_maximum_K[1] = 304.0;
  predicted.judgement.sensors[0] = SensorQuality::withheld;  // 7/6 times, by the reading of 305 K: 321.33 K
  EXPECT_NEAR(predicted.outside(), 360.0 - (298.0 + 20.0 * 7.0 / 6.0), 1e-9);
  predicted.judgement.sensors[0] = SensorQuality::good;
  predicted.sensed.sensors[0].value = 340.0;  // seven times, of which five count: 398 K
  predicted.corrected.outputs.part_maximum_K[2] = 400.0;
  EXPECT_DOUBLE_EQ(predicted.outside(), 2.0);
  predicted.uncorrected.outputs.key_points_K.setConstant(299.0);  // rises of less than 5 K count as these
  predicted.sensed.sensors[0].value = 316.0;
  EXPECT_NEAR(predicted.outside(), 400.0 - (298.0 + 20.0 * 18.0 / 5.0), 1e-9);
}

TEST(Plausible, where_nothing_is_measured_nothing_is_outside) {
  Predicted predicted;
  for (SensorQuality& quality : predicted.judgement.sensors) quality = SensorQuality::not_configured;
  predicted.judgement.signals.fill(std::numeric_limits<double>::quiet_NaN());
  predicted.corrected.outputs.key_points_K[1] = 900.0;
  EXPECT_EQ(predicted.outside(), 0.0);
}

}  // namespace cycle_plausible_test
}  // namespace spindle_twin::firmware
