#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"

/// Each register holds what its cycle said, in the unit of the register map.
namespace spindle_twin::firmware {
namespace serve_image_values_test {

struct Value {
  Register which;
  double expected;
  int slot = 0;
};

void expect_values(const Snapshot& snapshot, const std::vector<Value>& values) {
  RegisterImage image{};
  fill_image(snapshot, snapshot.time_ns + 1'500'000'000, image);
  for (const Value& value : values) {
    const double stands = get(image, value.which, value.slot);
    if (std::isnan(value.expected)) {
      EXPECT_TRUE(std::isnan(stands)) << entry_of(value.which).name << " " << value.slot << ": " << stands;
    } else {
      EXPECT_NEAR(stands, value.expected, 1e-6 * std::max(1.0, std::abs(value.expected)))
          << entry_of(value.which).name << " " << value.slot;
    }
  }
}

TEST(ImageValues, a_twin_that_has_done_nothing_has_counted_nothing_and_says_nothing) {
  std::vector<Value> values = {
      {Register::state, bits(State::starting)},
      {Register::quality, 0},
      {Register::fault, 0},
      {Register::heartbeat, 0},
      {Register::sequence, 0},
      {Register::tare_count, 0},
      {Register::correction_count, 0},
      {Register::correction_enabled, 0},
      {Register::overruns, 0},
      {Register::model_time, 0},
      {Register::deformation_count, 0},
      {Register::key_point_count, 0},
      {Register::part_count, 0},
      {Register::source_count, 0},
      {Register::conductance_count, 0},
      {Register::circuit_count, 0},
      {Register::tare, 0},
      {Register::order_count, 0},
      {Register::order_id, 0},
      {Register::order_kind, bits(OrderKind::none)},
      {Register::order_result, bits(OrderResult::none)},
      {Register::signals_held, 0},
      {Register::signals_implausible, 0},
      {Register::outputs_clamped, 0},
      {Register::history_rows_lost, 0},
      {Register::log_lines_dropped, 0},
      {Register::sensor_tare_count, 0},
      {Register::device_count, 0},
      {Register::devices_offline, 0},
      {Register::compensation_bits, 0},
      {Register::compensation_rung, bits(Rung::none)},
  };
  for (const Register which : {Register::prediction_age,
                               Register::data_age,
                               Register::correction_freeze,
                               Register::speed,
                               Register::load,
                               Register::coolant_temperature,
                               Register::motor_current,
                               Register::motor_power,
                               Register::nose_int16,
                               Register::nose_uncorrected,
                               Register::nose_network_sd,
                               Register::key_point_predicted,
                               Register::part_maximum,
                               Register::heat_factor,
                               Register::conductance_factor,
                               Register::nose_sd,
                               Register::nose_raw,
                               Register::estimator_updates,
                               Register::parameter_count,
                               Register::displacement_count,
                               Register::unexplained_heat_group,
                               Register::unexplained_heat,
                               Register::sensor_state,
                               Register::sensors_failed,
                               Register::model_in_doubt,
                               Register::sensor_tare,
                               Register::device_accepted,
                               Register::compensation,
                               Register::compensation_age,
                               Register::compensation_sd,
                               Register::compensation_settled_after,
                               Register::coolant_flow,
                               Register::measured_heat}) {
    values.push_back({which, not_a_value});
  }
  expect_values(Snapshot{}, values);
}

TEST(ImageValues, numbers_of_cycles_go_round_without_the_one_that_says_not_present) {
  Snapshot snapshot;
  for (const auto& [sequence, shown] : std::vector<std::pair<std::uint64_t, double>>{
           {0xFFFFFFFEU, 0xFFFFFFFEU}, {0xFFFFFFFFU, 0.0}, {0x100000000U, 1.0}, {3 * 0xFFFFFFFFULL + 5, 5.0}}) {
    snapshot.sequence = sequence;
    expect_values(snapshot, {{Register::sequence, shown}, {Register::compensation_sequence, shown}});
  }
}

TEST(ImageValues, of_the_cycle_stand_in_their_units) {
  Snapshot snapshot;
  snapshot.time_ns = 7'000'000'000;
  snapshot.sequence = 70000;
  snapshot.state = State::degraded;
  snapshot.quality = bits(Quality::signal_held);
  snapshot.fault = bits(Fault::output_clamped);
  snapshot.model_time_s = 1234.0;
  snapshot.data_age_s = 0.7;
  snapshot.overruns = 17;
  snapshot.tare_count = 3;
  snapshot.correction_count = 65535;
  snapshot.correction_configured = snapshot.correction_enabled = true;
  snapshot.correction_freeze = 4;
  snapshot.key_points = 5;
  snapshot.parts = 6;
  snapshot.sources = 7;
  snapshot.conductances = 8;
  snapshot.deformations = 2;
  snapshot.circuits = 1;
  snapshot.signals_held = 5;
  snapshot.signals_implausible = 4;
  snapshot.outputs_clamped = 2;
  snapshot.history_rows_lost = 9;
  snapshot.log_lines_dropped = 11;
  snapshot.signals[0] = -6000.0;
  snapshot.signals[1] = 0.455;
  snapshot.signals[2] = 293.15;
  snapshot.signals[3] = 298.15;
  snapshot.signals[4] = 12.3;
  snapshot.signals[5] = 4560.0;
  snapshot.signals[first_flow_signal] = 0.0823;
  snapshot.signals[first_flow_signal + 1] = 0.05;
  snapshot.signals[first_heat_signal] = 410.0;
  expect_values(snapshot, {{Register::prediction_age, 1.5},
                           {Register::heartbeat, 70000 - 65536},
                           {Register::sequence, 70000},
                           {Register::devices_sequence, 70000},
                           {Register::state, bits(State::degraded)},
                           {Register::compensation_state, bits(State::degraded)},
                           {Register::quality, bits(Quality::signal_held)},
                           {Register::compensation_quality, bits(Quality::signal_held)},
                           {Register::fault, bits(Fault::output_clamped)},
                           {Register::compensation_fault, bits(Fault::output_clamped)},
                           {Register::compensation_heartbeat, 70000 - 65536},
                           {Register::model_time, 1234},
                           {Register::data_age, 0.7},
                           {Register::overruns, 17},
                           {Register::tare_count, 3},
                           {Register::correction_count, 0},
                           {Register::correction_enabled, 1},
                           {Register::correction_freeze, 4},
                           {Register::key_point_count, 5},
                           {Register::part_count, 6},
                           {Register::source_count, 7},
                           {Register::conductance_count, 8},
                           {Register::deformation_count, 2},
                           {Register::circuit_count, 1},
                           {Register::signals_held, 5},
                           {Register::signals_implausible, 4},
                           {Register::outputs_clamped, 2},
                           {Register::history_rows_lost, 9},
                           {Register::log_lines_dropped, 11},
                           {Register::speed, 6000},
                           {Register::load, 45.5},
                           {Register::coolant_temperature, 20},
                           {Register::ambient_temperature, 25},
                           {Register::motor_current, 12.3},
                           {Register::motor_power, 4.56},
                           {Register::coolant_flow, 82.3},
                           {Register::coolant_flow, not_a_value, 1},
                           {Register::measured_heat, 410},
                           {Register::measured_heat, not_a_value, 1}});
}

TEST(ImageValues, of_the_spindle_stand_in_their_units) {
  Snapshot snapshot;
  snapshot.nose_m = 12.3e-6;
  snapshot.nose_uncorrected_m = 20e-6;
  snapshot.tare_m = 4e-6;
  snapshot.nose_network_deviation_m = 0.25e-6;
  snapshot.deformation_m[1] = -3.5e-6;
  snapshot.deformation_raw_m[0] = 17e-6;
  snapshot.deformation_raw_m[1] = -3.6e-6;
  snapshot.deformation_deviation_m[1] = 0.5e-6;
  snapshot.measured_K[2] = 301.15;
  snapshot.predicted_K[2] = 301.45;
  snapshot.uncorrected_K[2] = 304.15;
  snapshot.predicted_deviation_K[2] = 0.125;
  snapshot.part_maximum_K[1] = 310.15;
  snapshot.part_maximum_deviation_K[1] = 0.25;
  snapshot.heat_factor[1] = 0.46;
  snapshot.conductance_factor[2] = 1.75;
  snapshot.sensor_quality[2] = SensorQuality::stale;
  snapshot.health_watched = true;
  snapshot.model_in_doubt = true;
  snapshot.sensors_failed = 2;
  snapshot.sensor_tare_count = 5;
  snapshot.sensor_health[2] = {SensorState::failed, SensorFault::swapped, 3, 6, 1.5};
  snapshot.sensor_tare_K[2] = -0.12;
  snapshot.compensation = {-8e-6, 0.5e-6, 3.0, Rung::none, 5, 1.5e-5, 0.12, -9e-6, 600.0};
  snapshot.devices[0] = {true, true, 100, 3};
  snapshot.devices[2] = {true, false, 7, 1};
  expect_values(snapshot, {{Register::nose_int16, 12.3},
                           {Register::nose_int32, 12.3},
                           {Register::nose_uncorrected, 20.0},
                           {Register::tare, 4.0},
                           {Register::nose_network_sd, 0.25},
                           {Register::deformation, -3.5, 1},
                           {Register::deformation_float32, -3.5, 1},
                           {Register::deformation_raw, -3.6, 1},
                           {Register::deformation_sd, 0.5, 1},
                           {Register::nose_raw, 13.0},
                           {Register::key_point_measured, 28.0, 2},
                           {Register::key_point_predicted, 28.3, 2},
                           {Register::key_point_uncorrected, 31.0, 2},
                           {Register::key_point_sd, 0.125, 2},
                           {Register::part_maximum, 37.0, 1},
                           {Register::part_maximum_sd, 0.25, 1},
                           {Register::heat_factor, 0.46, 1},
                           {Register::conductance_factor, 1.75, 2},
                           {Register::sensor_quality, static_cast<double>(SensorQuality::stale), 2},
                           {Register::sensor_state, bits(SensorState::failed), 2},
                           {Register::sensor_fault, bits(SensorFault::swapped), 2},
                           {Register::sensor_partner, 3, 2},
                           {Register::sensor_spikes, 6, 2},
                           {Register::sensor_misfit, 1.5, 2},
                           {Register::sensor_tare, -0.12, 2},
                           {Register::sensor_tare_count, 5},
                           {Register::sensors_failed, 2},
                           {Register::model_in_doubt, 1},
                           {Register::compensation, -8.0},
                           {Register::compensation_int32, -8.0},
                           {Register::compensation_sd, 0.5},
                           {Register::compensation_age, 3.0},
                           {Register::compensation_bits, 5},
                           {Register::compensation_slope, 15.0},
                           {Register::compensation_reference, 120.0},
                           {Register::compensation_forecast, -9.0},
                           {Register::compensation_settled_after, 10.0},
                           {Register::device_count, 2},
                           {Register::devices_offline, 4},
                           {Register::device_accepted, 100, 0},
                           {Register::device_refused, 3, 0},
                           {Register::device_accepted, not_a_value, 1},
                           {Register::device_accepted, 7, 2}});
}

}  // namespace serve_image_values_test
}  // namespace spindle_twin::firmware
