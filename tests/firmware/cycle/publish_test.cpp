#include "firmware/cycle/publish.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <utility>

#include "tests/firmware/support/machine.hpp"

namespace spindle_twin::firmware {
namespace cycle_publish_test {

constexpr double um = 0x1p-20;  // a length that is halved and doubled to the bit
constexpr double inf = std::numeric_limits<double>::infinity();

/// What a model says that has these deformations.
Model that_says(std::initializer_list<double> deformations_m) {
  Model model;
  model.outputs.key_points_K = Eigen::VectorXd::Constant(3, 301.0);
  model.outputs.part_maximum_K = Eigen::VectorXd::Constant(2, 302.0);
  model.outputs.deformations_m.resize(static_cast<Eigen::Index>(deformations_m.size()));
  std::copy(deformations_m.begin(), deformations_m.end(), model.outputs.deformations_m.begin());
  return model;
}

Snapshot of_outputs(std::size_t deformations) {
  Snapshot snapshot;
  snapshot.key_points = 3;
  snapshot.parts = 2;
  snapshot.deformations = deformations;
  return snapshot;
}

std::array<double, slots::deformations> limits(double nose_m, double rear_m) {
  std::array<double, slots::deformations> all{};
  all.fill(inf);
  all[0] = nose_m;
  all[1] = rear_m;
  return all;
}

TEST(Publish, the_first_prediction_is_shown_at_once_and_each_later_one_at_the_slew_limit) {
  Snapshot now = of_outputs(2);
  publish_corrected(that_says({8 * um, -8 * um}), um, limits(inf, inf), now);
  EXPECT_EQ(now.deformation_m[0], 8 * um);
  EXPECT_EQ(now.deformation_m[1], -8 * um);
  EXPECT_EQ(now.quality & bits(Quality::slewing), 0);
  const Model other = that_says({10 * um, -5.5 * um});
  for (const auto& [nose, rear] : {std::pair{9.0, -7.0}, {10.0, -6.0}, {10.0, -5.5}}) {
    now.quality = 0;
    publish_corrected(other, um, limits(inf, inf), now);
    EXPECT_EQ(now.deformation_m[0], nose * um);
    EXPECT_EQ(now.deformation_m[1], rear * um);
    EXPECT_EQ(now.deformation_raw_m[0], 10 * um) << "what it is on its way to";
    EXPECT_EQ((now.quality & bits(Quality::slewing)) != 0, rear < -5.5) << "while one of them is on its way";
  }
}

TEST(Publish, at_its_limit_an_output_is_not_held_and_beyond_it_is_with_its_own_bit) {
  struct Case {
    double nose, rear;
    std::uint16_t clamped;
  };
  for (const Case& of : {Case{8.0, 4.0, 0}, Case{-8.0, -4.0, 0}, Case{8.5, 4.0, 1}, Case{-8.5, 0.0, 1},
                         Case{0.0, 4.5, 2}, Case{9.0, -9.0, 3}}) {
    Snapshot now = of_outputs(2);
    publish_corrected(that_says({of.nose * um, of.rear * um}), um, limits(8 * um, 4 * um), now);
    EXPECT_EQ(now.outputs_clamped, of.clamped) << of.nose << " " << of.rear;
    EXPECT_EQ(now.fault, of.clamped != 0 ? bits(Fault::output_clamped) : 0);
    EXPECT_EQ(now.deformation_m[0], std::clamp(of.nose, -8.0, 8.0) * um);
    EXPECT_EQ(now.deformation_m[1], std::clamp(of.rear, -4.0, 4.0) * um);
    EXPECT_EQ(now.deformation_raw_m[0], of.nose * um) << "the prediction is not";
  }
}

TEST(Publish, the_fault_of_a_held_output_goes_with_it_and_no_other_does) {
  Snapshot now = of_outputs(1);
  now.fault = bits(Fault::orders_lost);
  publish_corrected(that_says({9 * um}), inf, limits(8 * um, inf), now);
  EXPECT_EQ(now.fault, bits(Fault::orders_lost) | bits(Fault::output_clamped));
  publish_corrected(that_says({um}), inf, limits(8 * um, inf), now);
  EXPECT_EQ(now.fault, bits(Fault::orders_lost));
  EXPECT_EQ(now.outputs_clamped, 0);
}

TEST(Publish, the_nose_is_less_the_tare_and_within_the_limit_of_the_nose) {
  for (const double sign : {1.0, -1.0}) {
    Snapshot now = of_outputs(2);
    now.tare_m = -sign * 3 * um;
    publish_corrected(that_says({sign * 4 * um, 0.0}), um, limits(8 * um, um), now);
    EXPECT_EQ(now.nose_m, sign * 7 * um);
    EXPECT_EQ(now.outputs_clamped, 0);
    now.tare_m = -sign * 5 * um;
    publish_corrected(that_says({sign * 4 * um, 0.0}), um, limits(8 * um, um), now);
    EXPECT_EQ(now.nose_m, sign * 8 * um);
    EXPECT_EQ(now.outputs_clamped, 1);
    EXPECT_EQ(now.deformation_m[0], sign * 4 * um);
    now.tare_m = -sign * 2 * um;
    publish_nose(8 * um, now);
    EXPECT_EQ(now.nose_m, sign * 6 * um);
    publish_nose(5 * um, now);
    EXPECT_EQ(now.nose_m, sign * 5 * um);
  }
}

TEST(Publish, entries_beyond_what_the_network_has_do_not_exist) {
  Snapshot now = of_outputs(2);
  const Model model = that_says({um, um});
  publish_corrected(model, um, limits(inf, inf), now);
  publish_uncorrected(model, now);
  EXPECT_EQ(now.predicted_K[2], 301.0);
  EXPECT_EQ(now.uncorrected_K[2], 301.0);
  EXPECT_EQ(now.part_maximum_K[1], 302.0);
  for (std::size_t k = 3; k < slots::key_points; ++k) {
    EXPECT_TRUE(std::isnan(now.predicted_K[k]));
    EXPECT_TRUE(std::isnan(now.uncorrected_K[k]));
  }
  for (std::size_t p = 2; p < slots::parts; ++p) EXPECT_TRUE(std::isnan(now.part_maximum_K[p]));
  for (std::size_t d = 2; d < slots::deformations; ++d) {
    EXPECT_TRUE(std::isnan(now.deformation_m[d]));
    EXPECT_TRUE(std::isnan(now.deformation_raw_m[d]));
  }
}

TEST(Publish, a_tare_takes_what_is_foretold_within_the_limit_and_shows_it_at_once) {
  for (const double sign : {1.0, -1.0}) {
    Snapshot now = of_outputs(1);
    publish_corrected(that_says({0.0}), inf, limits(inf, inf), now);
    publish_corrected(that_says({sign * 6 * um}), um, limits(8 * um, inf), now);
    ASSERT_EQ(now.deformation_m[0], sign * um) << "on its way";
    EXPECT_TRUE(tare(8 * um, now));
    EXPECT_EQ(now.tare_m, sign * 6 * um);
    EXPECT_EQ(now.deformation_m[0], sign * 6 * um);
    EXPECT_TRUE(tare(4 * um, now));
    EXPECT_EQ(now.tare_m, sign * 4 * um);
    EXPECT_EQ(now.deformation_m[0], sign * 4 * um);
  }
}

TEST(Publish, without_a_nose_there_is_no_tare_and_no_uncorrected_nose) {
  Snapshot now = of_outputs(0);
  EXPECT_FALSE(tare(8 * um, now));
  EXPECT_EQ(now.tare_m, 0.0);
  publish_uncorrected(that_says({}), now);
  EXPECT_TRUE(std::isnan(now.nose_uncorrected_m));
}

TEST(Publish, the_uncorrected_nose_is_less_the_same_tare) {
  Snapshot now = of_outputs(1);
  now.tare_m = 3 * um;
  publish_uncorrected(that_says({5 * um}), now);
  EXPECT_EQ(now.nose_uncorrected_m, 2 * um);
}

TEST(Publish, of_a_key_point_without_sensor_nothing_is_read_whatever_the_device_says) {
  Snapshot now = of_outputs(1);
  SensedInputs sensed;
  Judgement judgement;
  judgement.sensors.fill(SensorQuality::not_configured);
  judgement.sensors[0] = judgement.sensors[1] = SensorQuality::stale;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto place = static_cast<double>(k);
    sensed.sensors[k] = {301.0 + place, 1.0 + place, 1};
    sensed.raw_K[k] = 311.0 + place;
  }
  sensed.displacements[0] = {5 * um, 2.0, 1};
  sensed.displacements[1] = {6 * um, 3.0, 1};
  publish_inputs(sensed, judgement, now);
  for (const std::size_t k : {0U, 1U}) {
    EXPECT_EQ(now.measured_K[k], sensed.sensors[k].value) << "also where it is not believed";
    EXPECT_EQ(now.raw_K[k], sensed.raw_K[k]);
    EXPECT_EQ(now.measured_age_s[k], sensed.sensors[k].age_s);
  }
  EXPECT_TRUE(std::isnan(now.measured_K[2]));
  EXPECT_TRUE(std::isnan(now.raw_K[2]));
  EXPECT_TRUE(std::isnan(now.measured_age_s[2]));
  EXPECT_EQ(now.probe_m[0], 5 * um);
  EXPECT_EQ(now.probe_age_s[0], 2.0);
  EXPECT_TRUE(std::isnan(now.probe_m[1])) << "the network has one deformation";
}

TEST(Publish, a_snapshot_begins_with_the_networks_counts_and_the_certificates_part) {
  rom::Network network = tests::small_network();
  const Snapshot now = first_snapshot(network);
  EXPECT_EQ(now.key_points, 3U);
  EXPECT_EQ(now.parts, 3U);
  EXPECT_EQ(now.sources, 2U);
  EXPECT_EQ(now.conductances, 4U);
  EXPECT_EQ(now.deformations, 2U);
  EXPECT_EQ(now.circuits, 0U);
  EXPECT_EQ(now.heats, 0U);
  EXPECT_DOUBLE_EQ(now.nose_network_deviation_m, std::hypot(1.5e-8, 1e-8));
  network.deformations.resize(1);
  network.certificate.deformations_m.resize(1);
  EXPECT_DOUBLE_EQ(first_snapshot(network).nose_network_deviation_m, std::hypot(1.5e-8, 1e-8));
  network.deformations.clear();
  network.certificate.deformations_m.clear();
  EXPECT_TRUE(std::isnan(first_snapshot(network).nose_network_deviation_m));
}

/// A twin of a machine as its network says, after so many seconds.
struct Followed {
  explicit Followed(const CyclePlan& plan) : cycle(network, plan, runtime), machine(network, 1.0) {}
  const Snapshot& until(int seconds) {
    for (; n < seconds; ++n) {
      last = cycle.step(machine.frame(at_s(n)), command, at_s(n), 0);
      machine.advance(1.0);
    }
    return last;
  }
  rom::Network network = tests::small_network();
  Cycle cycle;
  Machine machine;
  PlcCommand command;
  Snapshot last;
  int n = 0;
};

TEST(Publish, the_way_to_the_prediction_counts_in_the_deviation_at_right_angles) {
  CyclePlan quick = estimated(), slow = estimated();
  quick.slew_m_per_s = inf;
  slow.slew_m_per_s = 1e-9;
  Followed at_once(quick), on_the_way(slow);
  at_once.until(120);
  on_the_way.until(120);
  for (std::size_t d = 0; d < 2; ++d) {
    const double way_m = on_the_way.last.deformation_raw_m[d] - on_the_way.last.deformation_m[d];
    ASSERT_GT(std::abs(way_m), 1e-8);
    EXPECT_EQ(at_once.last.deformation_raw_m[d], on_the_way.last.deformation_raw_m[d]);
    EXPECT_DOUBLE_EQ(on_the_way.last.deformation_deviation_m[d],
                     std::hypot(at_once.last.deformation_deviation_m[d], way_m));
  }
}

TEST(Publish, parameters_that_the_sensors_determine_are_those_that_the_estimator_says) {
  Followed run(estimated());
  for (const int seconds : {5, 600}) {
    run.until(seconds);
    Remembered now;
    run.cycle.remember(now);
    std::size_t determined = 0;
    for (const correction::ParameterEstimate& each : now.parameters) determined += each.undetermined() ? 0 : 1;
    EXPECT_EQ(run.last.parameters, now.parameters.size());
    EXPECT_EQ(run.last.parameters_determined, determined);
  }
  EXPECT_GT(run.last.parameters_determined, 0);
}

TEST(Publish, of_an_update_there_is_nothing_to_tell_before_it_and_of_a_length_nothing_without_one) {
  Followed run(estimated());
  run.until(5);
  EXPECT_TRUE(std::isnan(run.last.sensor_update[0].variance));
  EXPECT_EQ(run.last.updates, 0U);
  run.until(60);
  const ChannelUpdate& told = run.last.sensor_update[0];
  EXPECT_GT(told.variance, 0.0);
  EXPECT_EQ(told.flags, bits(Update::fused));
  const double gate = estimated().estimator->gate;
  EXPECT_NEAR(told.test_ratio * told.variance * gate * gate, told.innovation * told.innovation, 1e-12)
      << "the gate is counted in deviations";
  EXPECT_EQ(run.last.displacement_count, 0);
  EXPECT_TRUE(std::isnan(run.last.displacement_update.variance));
  EXPECT_EQ(run.last.unexplained_heat_group, -1);
  EXPECT_TRUE(std::isnan(run.last.unexplained_heat_W));
  EXPECT_TRUE(std::isnan(run.last.calibrated_unix_s));
  run.command.displacement = {0, run.last.nose_m, 1e-6};
  run.command.displacements = 1;
  run.until(80);
  EXPECT_EQ(run.last.displacement_count, 1);
  EXPECT_GT(run.last.displacement_update.variance, 1e-12) << "at least its own";
}

TEST(Publish, factors_have_bands_as_far_as_the_network_has_factors) {
  Followed run(estimated());
  run.until(30);
  for (std::size_t i = 0; i < slots::sources; ++i) {
    EXPECT_EQ(std::isnan(run.last.heat_band[i].deviation), i >= 2) << i;
    EXPECT_EQ(std::isnan(run.last.heat_factor[i]), i >= 2) << i;
  }
  for (std::size_t j = 0; j < slots::conductances; ++j) {
    EXPECT_EQ(std::isnan(run.last.conductance_band[j].deviation), j >= 4) << j;
    EXPECT_EQ(std::isnan(run.last.conductance_factor[j]), j >= 4) << j;
  }
}

TEST(Publish, the_forecast_is_the_nose_less_the_tare_and_what_is_to_come_in_the_controls_sense_and_limit) {
  const rom::Network network = tests::small_network();
  Machine machine(network, 1.0);
  Forecast forecast(network, {Forecast::stride_s, 1e-6, 1}, runtime);
  for (std::size_t n = 0; n < Forecast::strides; ++n) {
    forecast.step(machine.model, machine.operating, machine.factors);
  }
  const double change_m = forecast.change_m();
  ASSERT_GT(change_m, um);
  for (const double sign : {1.0, -1.0}) {
    CompensationPlan plan;
    plan.sign = sign;
    Snapshot now = of_outputs(1);
    now.deformation_raw_m[0] = 5 * um;
    now.tare_m = 3 * um;
    publish_forecast(forecast, plan, now);
    EXPECT_DOUBLE_EQ(now.compensation.forecast_m, sign * (2 * um + change_m));
    EXPECT_EQ(now.compensation.settled_after_s, forecast.settled_after_s());
    plan.limit_m = um;
    publish_forecast(forecast, plan, now);
    EXPECT_EQ(now.compensation.forecast_m, sign * um);
  }
}

TEST(PublishEstimate, a_sensor_that_would_have_to_be_off_by_more_than_5_K_puts_the_estimate_in_doubt) {
  const rom::Network network = tests::small_network();
  for (const double off_K : {4.9, -4.9, 5.1, -5.1}) {
    for (Eigen::Index sensor = 0; sensor < 3; ++sensor) {
      Corrector corrector = make_corrector(network, estimated(), runtime);
      corrector.estimator->note_tare(sensor, -off_K, 0.1);
      Snapshot snapshot = first_snapshot(network);
      publish_estimate(corrector, snapshot);
      EXPECT_EQ((snapshot.quality & bits(Quality::estimate_in_doubt)) != 0, std::abs(off_K) > 5.0) << off_K;
    }
  }
}

TEST(PublishEstimate, a_joint_beyond_belief_puts_the_estimate_in_doubt) {
  const rom::Network network = tests::small_network();
  for (const double deviations : {2.9, 3.1}) {
    Corrector corrector = make_corrector(network, estimated(), runtime);
    const correction::ParameterModel& parameters = corrector.estimator->parameters();
    Eigen::VectorXd theta = parameters.mean();
    const int joint = parameters.conductance(0);
    theta[joint] -= deviations * parameters.list()[static_cast<std::size_t>(joint)].deviation;
    corrector.estimator->set_parameters(theta);
    Snapshot snapshot = first_snapshot(network);
    publish_estimate(corrector, snapshot);
    EXPECT_EQ((snapshot.quality & bits(Quality::estimate_in_doubt)) != 0, deviations > 3.0) << deviations;
  }
}

}  // namespace cycle_publish_test
}  // namespace spindle_twin::firmware
