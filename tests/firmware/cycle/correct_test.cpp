#include "firmware/cycle/correct.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/firmware/support/machine.hpp"

namespace spindle_twin::firmware {
namespace cycle_correct_test {

constexpr std::int64_t s_ns = 1'000'000'000;

/// The law of a plan and what it is told, cycle by cycle.
struct Law {
  explicit Law(const CyclePlan& of_plan) : plan(of_plan), machine(network, 1.0) {
    judgement.sensors.fill(SensorQuality::not_configured);
    for (std::size_t k = 0; k < 3; ++k) {
      judgement.sensors[k] = SensorQuality::good;
      sensed.sensors[k] = {start_K, 0.0, s_ns};
    }
  }
  void correct_once() {
    correct(sensed, judgement, machine.operating, {at_s, 1.0}, machine.model, corrector);
    at_s += 1.0;
  }
  /// Whether the sensor's reading of that time goes to the estimator.
  bool takes(std::size_t channel, std::int64_t time_ns) {
    sensed.sensors[channel].time_ns = time_ns;
    correct_once();
    return corrector.measured.valid[static_cast<Eigen::Index>(channel)];
  }
  bool takes_probe(std::size_t output, const Sensed& reading, double tare_m = 0.0) {
    corrector.displacements.due = 0;
    const int before = corrector.displacements.count;
    sensed.displacements[output] = reading;
    take_probes(plan, sensed, tare_m, corrector);
    sensed.displacements[output] = {};
    return corrector.displacements.count == before + 1;
  }

  CyclePlan plan;
  rom::Network network = tests::small_network();
  Corrector corrector = make_corrector(network, plan, runtime);
  Machine machine;
  SensedInputs sensed;
  Judgement judgement;
  double at_s = 0.0;
};

TEST(Correct, of_each_sensor_one_reading_an_interval_goes_to_the_estimator) {
  for (const double rate : {1.0, 4.0}) {
    CyclePlan plan = estimated();
    plan.clock_rate = rate;
    plan.sensors[1].interval_s = 40.0;
    Law law(plan);
    const auto at = [&](double model_s) { return s_ns + static_cast<std::int64_t>(1e9 * model_s / rate); };
    law.judgement.sensors[1] = SensorQuality::never_read;
    EXPECT_TRUE(law.takes(0, at(0.0)));
    EXPECT_FALSE(law.takes(0, at(0.0))) << "a repeat";
    EXPECT_TRUE(law.takes(0, at(1.0)));
    law.judgement.sensors[1] = SensorQuality::good;
    EXPECT_TRUE(law.takes(1, at(7.0))) << "the first one";
    EXPECT_FALSE(law.takes(1, at(7.0)));
    EXPECT_FALSE(law.takes(1, at(30.0)));
    EXPECT_FALSE(law.takes(1, at(46.998)));
    EXPECT_TRUE(law.takes(1, at(46.9995))) << "a device is not on time to the millisecond";
    EXPECT_FALSE(law.takes(1, at(80.0))) << "counted from the one that was taken";
    EXPECT_TRUE(law.takes(1, at(87.0)));
  }
}

TEST(Correct, a_reading_that_is_not_believed_is_not_taken_and_does_not_begin_an_interval) {
  CyclePlan plan = estimated();
  plan.sensors[2].interval_s = 40.0;
  Law law(plan);
  law.judgement.sensors[2] = SensorQuality::withheld;
  EXPECT_FALSE(law.takes(2, s_ns));
  law.judgement.sensors[2] = SensorQuality::good;
  EXPECT_TRUE(law.takes(2, 2 * s_ns));
}

TEST(Correct, channels_are_the_configured_sensors_whatever_place_they_have) {
  CyclePlan plan = estimated();
  plan.sensors[1].configured = false;
  Law law(plan);
  ASSERT_EQ(law.corrector.channels.size(), 2U);
  law.sensed.sensors[0].value = 301.0;
  law.sensed.sensors[1].value = 302.0;
  law.sensed.sensors[2].value = 303.0;
  law.correct_once();
  EXPECT_EQ(law.corrector.measured.value_K[0], 301.0);
  EXPECT_EQ(law.corrector.measured.value_K[1], 303.0);
  for (SensorPlan& sensor : plan.sensors) sensor.configured = false;
  EXPECT_TRUE(Law(plan).corrector.estimator) << "it still says how sure the open loop is";
}

TEST(Correct, without_a_key_point_there_is_nowhere_to_look_at) {
  rom::Network network = tests::small_network();
  network.key_points.clear();
  const Corrector corrector = make_corrector(network, open_loop(), runtime);
  EXPECT_FALSE(corrector.corrects);
  CyclePlan plan = estimated();
  for (SensorPlan& sensor : plan.sensors) sensor.configured = false;
  EXPECT_FALSE(make_corrector(network, plan, runtime).estimator);
}

TEST(Correct, it_waits_for_an_update_corrects_with_readings_and_is_frozen_without) {
  for (std::size_t channel = 0; channel < 3; ++channel) {
    Law law(estimated());
    const long period = std::lround(law.plan.estimator->period_s);
    const auto freeze = [&] { return static_cast<CorrectionFreeze>(law.corrector.freeze); };
    std::int64_t time_ns = s_ns;
    for (std::size_t k = 0; k < 3; ++k) law.judgement.sensors[k] = SensorQuality::stale;
    law.judgement.sensors[channel] = SensorQuality::good;
    law.sensed.sensors[channel].value += 0.1;
    while (law.corrector.estimator->updates() == 0) {
      EXPECT_EQ(freeze(), CorrectionFreeze::waiting);
      law.takes(channel, time_ns += s_ns);
    }
    EXPECT_EQ(freeze(), CorrectionFreeze::none) << "one sensor is enough";
    EXPECT_EQ(law.corrector.corrections, 1);
    for (long n = 0; n < 2 * period + 1; ++n) law.correct_once();
    EXPECT_EQ(freeze(), CorrectionFreeze::too_few_sensors) << "repeats only";
    law.corrector.enabled = false;
    law.correct_once();
    EXPECT_EQ(freeze(), CorrectionFreeze::waiting);
  }
}

TEST(Correct, is_on_from_the_start_where_there_is_a_law_that_corrects_and_is_to) {
  for (const bool corrects : {true, false}) {
    for (const bool enabled : {true, false}) {
      CyclePlan plan = estimated();
      plan.estimator_corrects = corrects;
      plan.correction_enabled = enabled;
      const Law law(plan);
      EXPECT_EQ(law.corrector.corrects, corrects);
      EXPECT_EQ(law.corrector.enabled, corrects && enabled);
    }
  }
}

TEST(Displacement, is_of_an_output_that_exists_a_number_and_with_a_deviation_above_zero) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  Law law(estimated());
  const auto taken = [&](int index, double value_m, double deviation_m) {
    return take_displacement(index, value_m, deviation_m, law.corrector);
  };
  EXPECT_TRUE(taken(0, 1e-6, 1e-6));
  EXPECT_TRUE(taken(1, -1e-6, 1e-8));
  EXPECT_EQ(law.corrector.displacements.count, 2);
  EXPECT_EQ(law.corrector.displacements.due, law.corrector.estimator->updates() + 1);
  EXPECT_FALSE(taken(-1, 1e-6, 1e-6));
  EXPECT_FALSE(taken(2, 1e-6, 1e-6));
  EXPECT_FALSE(taken(0, not_a_value, 1e-6));
  EXPECT_FALSE(taken(0, inf, 1e-6));
  for (const double deviation_m : {0.0, -1e-6, not_a_value, 1e-12, 1.1e-3, inf})
    EXPECT_FALSE(taken(0, 1e-6, deviation_m)) << deviation_m;
  law.corrector.enabled = false;
  EXPECT_FALSE(taken(0, 1e-6, 1e-6));
  EXPECT_EQ(law.corrector.displacements.count, 2);
  Law open(open_loop());
  EXPECT_FALSE(take_displacement(0, 1e-6, 1e-6, open.corrector));
}

CyclePlan probed(double rate) {
  CyclePlan plan = estimated();
  plan.clock_rate = rate;
  plan.probes[0] = plan.probes[1] = {true, 1e-7, -2e-4, 1e-4, 60.0, 3.0};
  return plan;
}

TEST(Probes, at_the_ends_of_range_and_age_a_reading_is_good_and_beyond_it_is_not) {
  Law law(probed(1.0));
  std::int64_t minute = 0;
  const auto takes = [&](double value_m, double age_s) {
    return law.takes_probe(0, {value_m, age_s, ++minute * 60 * s_ns});
  };
  EXPECT_TRUE(takes(-2e-4, 0.0));
  EXPECT_TRUE(takes(1e-4, 3.0));
  EXPECT_FALSE(takes(-2.01e-4, 0.0));
  EXPECT_FALSE(takes(1.01e-4, 0.0));
  EXPECT_FALSE(takes(0.0, 3.001));
  EXPECT_FALSE(takes(not_a_value, 0.0));
  EXPECT_TRUE(takes(0.0, 0.0));
}

TEST(Probes, one_reading_an_interval_of_model_time_is_taken_and_none_twice) {
  for (const double rate : {1.0, 4.0}) {
    Law law(probed(rate));
    const auto takes = [&](double model_s) {
      return law.takes_probe(1, {1e-6, 0.0, s_ns + static_cast<std::int64_t>(1e9 * model_s / rate)});
    };
    EXPECT_TRUE(takes(5.0)) << "the first one";
    EXPECT_FALSE(takes(5.0));
    EXPECT_FALSE(takes(64.998));
    EXPECT_TRUE(takes(64.9995));
    EXPECT_FALSE(takes(124.9));
    EXPECT_TRUE(takes(125.0));
  }
  CyclePlan always = probed(1.0);
  always.probes[0].interval_s = 0.0;
  Law law(always);
  EXPECT_TRUE(law.takes_probe(0, {1e-6, 0.0, s_ns}));
  EXPECT_FALSE(law.takes_probe(0, {1e-6, 0.0, s_ns})) << "a repeat";
  EXPECT_TRUE(law.takes_probe(0, {1e-6, 0.0, 2 * s_ns}));
}

TEST(Probes, one_of_all_goes_into_an_update) {
  Law law(probed(1.0));
  for (std::size_t d = 0; d < 2; ++d) law.sensed.displacements[d] = {1e-6, 0.0, s_ns};
  take_probes(law.plan, law.sensed, 0.0, law.corrector);
  EXPECT_EQ(law.corrector.displacements.count, 1);
  EXPECT_EQ(law.corrector.displacements.probed_ns[1], 0) << "it has not been looked at";
  take_probes(law.plan, law.sensed, 0.0, law.corrector);
  EXPECT_EQ(law.corrector.displacements.count, 1) << "before the update that it goes into";
  while (law.corrector.estimator->updates() == 0) law.correct_once();
  take_probes(law.plan, law.sensed, 0.0, law.corrector);
  EXPECT_EQ(law.corrector.displacements.count, 2) << "of the other one, with the next update";
  EXPECT_EQ(law.corrector.displacements.probed_ns[1], s_ns);
}

TEST(Probes, none_is_looked_at_that_is_not_configured_nor_while_nothing_corrects) {
  CyclePlan plan = probed(1.0);
  plan.probes[0].configured = false;
  Law law(plan);
  EXPECT_FALSE(law.takes_probe(0, {1e-6, 0.0, s_ns}));
  EXPECT_TRUE(law.takes_probe(1, {1e-6, 0.0, s_ns}));
  law.corrector.enabled = false;
  EXPECT_FALSE(law.takes_probe(1, {1e-6, 0.0, 90 * s_ns}));
  EXPECT_EQ(law.corrector.displacements.probed_ns[1], s_ns) << "nor does it begin an interval";
}

TEST(Probes, at_the_nose_what_is_read_counts_from_the_tare_and_elsewhere_from_nothing) {
  for (const std::size_t output : {0U, 1U}) {
    Law law(probed(1.0));
    law.correct_once();
    ASSERT_TRUE(law.takes_probe(output, {2e-6, 0.0, s_ns}, 3e-6));
    while (law.corrector.estimator->updates() == 0) law.correct_once();
    EXPECT_NEAR(law.corrector.estimator->displacement_record().observation_K, output == 0 ? 5e-6 : 2e-6, 1e-15);
  }
}

}  // namespace cycle_correct_test
}  // namespace spindle_twin::firmware
