#include "firmware/config/expect_of_sensors.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "tests/firmware/support/machine.hpp"

namespace spindle_twin::firmware {
namespace config_expect_of_sensors_test {

/// What it says in um, with how many sensors.
struct Told {
  double growth_um = 0.0, without_um = 0.0, with_um = 0.0;
  int sensors = -1;
};

Told told(const rom::Network& network, const CyclePlan& plan) {
  Told of;
  const std::string text = expect_of_sensors(network, plan);
  EXPECT_EQ(std::sscanf(text.c_str(),
                        "expected after an hour at 6000 rpm from a cold start: nose %lf um, standard deviation %lf um "
                        "without sensors, %lf um with %d;",
                        &of.growth_um, &of.without_um, &of.with_um, &of.sensors),
            4)
      << text;
  return of;
}

/// The same with lengths that one decimal shows.
rom::Network large() {
  rom::Network network = tests::small_network();
  network.deformations[0].row_m_per_K *= 100.0;
  return network;
}

TEST(ExpectOfSensors, growth_and_deviation_are_those_of_an_hour_and_sensors_make_it_surer) {
  const rom::Network network = large();
  Machine machine(network, 1.0);
  for (int n = 0; n < 60; ++n) machine.advance(60.0);
  const Told all = told(network, estimated());
  const double grown_um = 1e6 * machine.model.outputs.deformations_m[0];
  EXPECT_NEAR(all.growth_um, grown_um, 0.15 * grown_um) << "beside the mean of the priors";
  EXPECT_EQ(all.sensors, 3);
  EXPECT_GT(all.without_um, 0.1 * grown_um);
  EXPECT_LT(all.with_um, 0.8 * all.without_um);
  for (const std::size_t only : {0U, 2U}) {
    CyclePlan plan = estimated();
    for (std::size_t k = 0; k < 3; ++k) plan.sensors[k].configured = k == only;
    const Told one = told(network, plan);
    EXPECT_EQ(one.sensors, 1);
    EXPECT_EQ(one.without_um, all.without_um);
    EXPECT_GT(one.with_um, all.with_um);
    EXPECT_LT(one.with_um, one.without_um);
  }
}

TEST(ExpectOfSensors, the_noisiest_and_the_least_tared_sensor_count_whichever_it_is) {
  const rom::Network network = large();
  const double usual_um = told(network, estimated()).with_um;
  for (const std::size_t noisy : {0U, 2U}) {
    CyclePlan plan = estimated();
    plan.sensors[noisy].noise_K = 5.0;
    EXPECT_GT(told(network, plan).with_um, 1.02 * usual_um) << noisy;
    plan = estimated();
    plan.sensors[noisy].offset_deviation_K = 5.0;
    EXPECT_GT(told(network, plan).with_um, 1.02 * usual_um) << noisy;
  }
  CyclePlan unused = estimated();
  unused.sensors[1].configured = false;
  const double two_um = told(network, unused).with_um;
  unused.sensors[1].noise_K = unused.sensors[1].offset_deviation_K = 5.0;
  EXPECT_EQ(told(network, unused).with_um, two_um) << "that sensor is not there";
}

TEST(ExpectOfSensors, where_no_estimator_corrects_or_nothing_grows_there_is_nothing_to_expect) {
  rom::Network network = tests::small_network();
  EXPECT_EQ(expect_of_sensors(network, open_loop()), "");
  EXPECT_EQ(expect_of_sensors(network, corrected()), "");
  CyclePlan plan = estimated();
  plan.estimator_corrects = false;
  EXPECT_EQ(expect_of_sensors(network, plan), "");
  network.deformations.clear();
  network.certificate.deformations_m.clear();
  EXPECT_EQ(expect_of_sensors(network, estimated()), "");
}

}  // namespace config_expect_of_sensors_test
}  // namespace spindle_twin::firmware
