#include "firmware/serve/fill_image.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "firmware/serve/pack.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {
namespace {

/// put() that remembers whether anything was clipped.
struct Filler {
  RegisterImage& image;
  bool clipped = false;

  void value(Register which, double number, int slot = 0) { clipped = !put(image, which, number, slot) || clipped; }

  template <std::size_t room>
  void values(Register which, const std::array<double, room>& numbers, double shift = 0.0, double scale = 1.0) {
    for (std::size_t slot = 0; slot < room; ++slot) {
      value(which, (numbers[slot] + shift) * scale, static_cast<int>(slot));
    }
  }
};

using rom::um_per_m;
constexpr double grams_per_kg = 1e3;

void fill_status(const Snapshot& snapshot, std::int64_t now_ns, Filler& fill) {
  fill.value(Register::known_uint16, 0x1234);
  fill.value(Register::known_int16, -125);
  fill.value(Register::known_float32, -12.5);
  fill.value(Register::known_float32_cdab, -12.5);
  fill.value(Register::map_version, register_map_version);
  // The heartbeat wraps over all 16 bits, so it alone uses the not-present value too.
  fill.image[entry_of(Register::heartbeat).address] = static_cast<std::uint16_t>(snapshot.sequence & 0xFFFFU);
  // At 1 ms a cycle 32 bits last for 49.7 days; the last of their numbers says "not present".
  const auto sequence = static_cast<double>(snapshot.sequence % 0xFFFFFFFFU);
  for (const Register which :
       {Register::sequence, Register::temperatures_sequence, Register::parts_sequence, Register::factors_sequence,
        Register::deviations_sequence, Register::sensors_sequence, Register::estimator_sequence,
        Register::health_sequence, Register::motor_sequence, Register::service_sequence,
        Register::compensation_sequence, Register::devices_sequence, Register::exchange_sequence}) {
    fill.value(which, sequence);
  }
  fill.value(Register::state, static_cast<double>(snapshot.state));
  fill.value(Register::fault, snapshot.fault);
  const double age_s = snapshot.time_ns == 0 ? not_a_value : 1e-9 * static_cast<double>(now_ns - snapshot.time_ns);
  // An age at its end says so itself; it is no clipped prediction.
  put(fill.image, Register::prediction_age, std::max(age_s, 0.0));  // in this order NaN stays NaN
  put(fill.image, Register::data_age, snapshot.data_age_s);
  fill.value(Register::tare_count, snapshot.tare_count % 65535);
  fill.value(Register::correction_count, snapshot.correction_count % 65535);
  fill.value(Register::overruns, snapshot.overruns);
  fill.value(Register::model_time, snapshot.model_time_s);
  fill.value(Register::deformation_count, static_cast<double>(snapshot.deformations));
  fill.value(Register::key_point_count, static_cast<double>(snapshot.key_points));
  fill.value(Register::part_count, static_cast<double>(snapshot.parts));
  fill.value(Register::source_count, static_cast<double>(snapshot.sources));
  fill.value(Register::conductance_count, static_cast<double>(snapshot.conductances));
  fill.value(Register::correction_enabled, snapshot.correction_enabled ? 1.0 : 0.0);
  fill.value(Register::correction_freeze, snapshot.correction_configured ? snapshot.correction_freeze : not_a_value);
  const auto signal = [&](Signal which) { return snapshot.signals[static_cast<std::size_t>(which)]; };
  // An echo of what the machine tells is no prediction either.
  put(fill.image, Register::speed, std::abs(signal(Signal::speed)));
  put(fill.image, Register::load, 100.0 * signal(Signal::load));
  put(fill.image, Register::coolant_temperature, signal(Signal::coolant) - zero_degC_K);
  put(fill.image, Register::ambient_temperature, signal(Signal::ambient) - zero_degC_K);
  put(fill.image, Register::motor_current, signal(Signal::current));
  put(fill.image, Register::motor_power, 1e-3 * signal(Signal::power));
  fill.value(Register::circuit_count, static_cast<double>(snapshot.circuits));
  for (std::size_t c = 0; c < slots::circuits; ++c) {
    const double flow_kg_per_s = c < snapshot.circuits ? snapshot.signals[first_flow_signal + c] : not_a_value;
    put(fill.image, Register::coolant_flow, grams_per_kg * flow_kg_per_s, static_cast<int>(c));
  }
  for (std::size_t h = 0; h < slots::heats; ++h) {
    put(fill.image, Register::measured_heat, snapshot.signals[first_heat_signal + h], static_cast<int>(h));
  }
}

void fill_nose(const Snapshot& snapshot, Filler& fill) {
  const double nose_um = um_per_m * snapshot.nose_m;
  for (const Register which : {Register::nose_int16, Register::nose_offset16, Register::nose_int32,
                               Register::nose_float32, Register::nose_float32_cdab}) {
    fill.value(which, nose_um);
  }
  fill.value(Register::nose_uncorrected, um_per_m * snapshot.nose_uncorrected_m);
  fill.value(Register::tare, um_per_m * snapshot.tare_m);
  fill.value(Register::nose_network_sd, um_per_m * snapshot.nose_network_deviation_m);
  fill.values(Register::deformation, snapshot.deformation_m, 0.0, um_per_m);
  fill.values(Register::deformation_float32, snapshot.deformation_m, 0.0, um_per_m);
}

void fill_temperatures(const Snapshot& snapshot, Filler& fill) {
  fill.values(Register::key_point_measured, snapshot.measured_K, -zero_degC_K);
  fill.values(Register::key_point_predicted, snapshot.predicted_K, -zero_degC_K);
  fill.values(Register::key_point_uncorrected, snapshot.uncorrected_K, -zero_degC_K);
  fill.values(Register::key_point_measured_float32, snapshot.measured_K, -zero_degC_K);
  fill.values(Register::key_point_predicted_float32, snapshot.predicted_K, -zero_degC_K);
  fill.values(Register::key_point_uncorrected_float32, snapshot.uncorrected_K, -zero_degC_K);
  fill.values(Register::part_maximum, snapshot.part_maximum_K, -zero_degC_K);
  fill.values(Register::part_maximum_float32, snapshot.part_maximum_K, -zero_degC_K);
  for (std::size_t k = 0; k < slots::key_points; ++k) {
    fill.value(Register::sensor_quality, static_cast<double>(snapshot.sensor_quality[k]), static_cast<int>(k));
  }
}

void fill_deviations(const Snapshot& snapshot, Filler& fill) {
  fill.value(Register::nose_sd, um_per_m * snapshot.deformation_deviation_m[0]);
  fill.values(Register::key_point_sd, snapshot.predicted_deviation_K);
  fill.values(Register::part_maximum_sd, snapshot.part_maximum_deviation_K);
  fill.values(Register::deformation_sd, snapshot.deformation_deviation_m, 0.0, um_per_m);
  fill.values(Register::deformation_raw, snapshot.deformation_raw_m, 0.0, um_per_m);
  fill.value(Register::nose_raw, um_per_m * (snapshot.deformation_raw_m[0] - snapshot.tare_m));
}

/// What is clipped here is no prediction.
void fill_updates(const Snapshot& snapshot, RegisterImage& image) {
  for (std::size_t k = 0; k < slots::key_points; ++k) {
    const ChannelUpdate& update = snapshot.sensor_update[k];
    const int slot = static_cast<int>(k);
    put(image, Register::sensor_observation, update.observation - zero_degC_K, slot);
    put(image, Register::sensor_innovation, update.innovation, slot);
    put(image, Register::sensor_variance, update.variance, slot);
    put(image, Register::sensor_test_ratio, update.test_ratio, slot);
    put(image, Register::sensor_update, std::isnan(update.variance) ? not_a_value : update.flags, slot);
    put(image, Register::sensor_offset, update.offset, slot);
    put(image, Register::sensor_offset_sd, update.offset_deviation, slot);
  }
  const auto if_estimating = [&](double value) { return snapshot.parameters > 0 ? value : not_a_value; };
  put(image, Register::estimator_updates, if_estimating(snapshot.updates));
  put(image, Register::parameter_count, if_estimating(snapshot.parameters));
  put(image, Register::parameters_determined, if_estimating(snapshot.parameters_determined));
  put(image, Register::unexplained_heat_group,
      snapshot.unexplained_heat_group < 0 ? not_a_value : snapshot.unexplained_heat_group);
  put(image, Register::unexplained_heat, snapshot.unexplained_heat_W);
  put(image, Register::calibrated_at, snapshot.calibrated_unix_s);
  put(image, Register::calibration_promise, um_per_m * snapshot.calibration_promised_m);
  put(image, Register::displacement_count, if_estimating(snapshot.displacement_count % 65535));
  const ChannelUpdate& length = snapshot.displacement_update;
  put(image, Register::displacement_update, std::isnan(length.variance) ? not_a_value : length.flags);
  put(image, Register::displacement_innovation, um_per_m * length.innovation);
  put(image, Register::displacement_innovation_sd, um_per_m * std::sqrt(length.variance));
  put(image, Register::displacement_test_ratio, length.test_ratio);
}

void fill_health(const Snapshot& snapshot, RegisterImage& image) {
  for (std::size_t k = 0; k < slots::key_points; ++k) {
    const SensorHealthState& health = snapshot.sensor_health[k];
    const int slot = static_cast<int>(k);
    const bool watched = snapshot.health_watched && snapshot.sensor_quality[k] != SensorQuality::not_configured;
    const auto if_watched = [&](double value) { return watched ? value : not_a_value; };
    put(image, Register::sensor_state, if_watched(bits(health.state)), slot);
    put(image, Register::sensor_fault, if_watched(bits(health.fault)), slot);
    put(image, Register::sensor_partner, if_watched(health.partner < 0 ? not_a_value : health.partner), slot);
    put(image, Register::sensor_spikes, if_watched(health.spikes), slot);
    put(image, Register::sensor_misfit, if_watched(health.misfit_ratio), slot);
    put(image, Register::sensor_tare, snapshot.sensor_tare_K[k], slot);
  }
  put(image, Register::sensor_tare_count, snapshot.sensor_tare_count % 65535);
  put(image, Register::sensors_failed, snapshot.health_watched ? snapshot.sensors_failed : not_a_value);
  put(image, Register::model_in_doubt, snapshot.health_watched ? (snapshot.model_in_doubt ? 1.0 : 0.0) : not_a_value);
  put(image, Register::sensor_tare_wait, bits(snapshot.sensor_tare_wait));
  put(image, Register::sensor_tare_point, snapshot.sensor_tare_point < 0 ? not_a_value : snapshot.sensor_tare_point);
  put(image, Register::sensor_tare_left, std::ceil(snapshot.sensor_tare_left_s));
}

/// Orders and what is amiss; what is clipped here is no prediction.
void fill_service(const Snapshot& snapshot, RegisterImage& image) {
  put(image, Register::order_count, snapshot.orders);
  for (std::size_t i = 0; i < order_records; ++i) {
    const OrderRecord& order = snapshot.last_orders[i];
    put(image, Register::order_id, order.id, static_cast<int>(i));
    put(image, Register::order_kind, bits(order.kind), static_cast<int>(i));
    put(image, Register::order_result, bits(order.result), static_cast<int>(i));
  }
  put(image, Register::signals_held, snapshot.signals_held);
  put(image, Register::signals_implausible, snapshot.signals_implausible);
  put(image, Register::outputs_clamped, snapshot.outputs_clamped);
  put_not_present(image, Register::service_reserved);
  put(image, Register::history_rows_lost, static_cast<double>(snapshot.history_rows_lost));
  put(image, Register::log_lines_dropped, static_cast<double>(snapshot.log_lines_dropped));
}

void fill_compensation(const Snapshot& snapshot, Filler& fill) {
  const CompensationState& told = snapshot.compensation;
  for (const Register which : {Register::compensation, Register::compensation_cdab, Register::compensation_int32,
                               Register::compensation_int16}) {
    fill.value(which, um_per_m * told.value_m);
  }
  put(fill.image, Register::compensation_rung, bits(told.rung));
  put(fill.image, Register::compensation_bits, told.bits);
  put(fill.image, Register::compensation_age, told.age_s);
  fill.value(Register::compensation_sd, um_per_m * told.deviation_m);
  fill.value(Register::compensation_slope, um_per_m * told.slope);
  constexpr double mm_per_m = 1e3;
  fill.value(Register::compensation_reference, mm_per_m * told.reference_m);
  fill.value(Register::compensation_forecast, um_per_m * told.forecast_m);
  put(fill.image, Register::compensation_settled_after, told.settled_after_s / rom::seconds_per_minute);
  put(fill.image, Register::compensation_trial_left, std::ceil(told.trial_left_s));
  for (int slot = 0; slot < entry_of(Register::compensation_reserved).slots; ++slot) {
    put_not_present(fill.image, Register::compensation_reserved, slot);
  }
}

void fill_devices(const Snapshot& snapshot, RegisterImage& image) {
  int count = 0;
  int offline = 0;
  for (std::size_t d = 0; d < slots::devices; ++d) {
    const DeviceState& device = snapshot.devices[d];
    const int slot = static_cast<int>(d);
    count += device.used ? 1 : 0;
    offline |= device.used && !device.connected ? 1 << slot : 0;
    const auto counter = [&](std::uint32_t number) { return device.used ? number % 0xFFFFFFFFU : not_a_value; };
    put(image, Register::device_accepted, counter(device.accepted), slot);
    put(image, Register::device_refused, counter(device.refused), slot);
  }
  put(image, Register::device_count, count);
  put(image, Register::devices_offline, offline);
}

void fill_exchange(const Snapshot& snapshot, RegisterImage& image) {
  const ExchangeView& view = snapshot.exchange;
  put(image, Register::exchange_state, bits(view.state));
  put(image, Register::exchange_left, view.left_s / rom::seconds_per_minute);
  put(image, Register::network_id, snapshot.network_id == 0 ? not_a_value : snapshot.network_id % 0xFFFFFFFFU);
  put(image, Register::exchange_error_old, view.running_K);
  put(image, Register::exchange_error_new, view.candidate_K);
  for (int slot = 0; slot < entry_of(Register::exchange_reserved).slots; ++slot) {
    put_not_present(image, Register::exchange_reserved, slot);
  }
}

}  // namespace

void fill_image(const Snapshot& snapshot, std::int64_t now_ns, RegisterImage& image) {
  Filler fill{image};
  fill_status(snapshot, now_ns, fill);
  fill_nose(snapshot, fill);
  fill_temperatures(snapshot, fill);
  fill.values(Register::heat_factor, snapshot.heat_factor);
  fill.values(Register::conductance_factor, snapshot.conductance_factor);
  fill_deviations(snapshot, fill);
  fill_updates(snapshot, image);
  fill_health(snapshot, image);
  fill_service(snapshot, image);
  fill_compensation(snapshot, fill);
  fill_devices(snapshot, image);
  fill_exchange(snapshot, image);
  const int quality = snapshot.quality | (fill.clipped ? bits(Quality::saturated) : 0);
  put(image, Register::quality, quality);
  // What stands in a register is not what the twin says: no running prediction, whatever the cycle knows of itself.
  if (fill.clipped && snapshot.state == State::running) put(image, Register::state, bits(State::degraded));
  for (const auto& [copy, of] : {std::pair{Register::compensation_heartbeat, Register::heartbeat},
                                 {Register::compensation_state, Register::state},
                                 {Register::compensation_quality, Register::quality},
                                 {Register::compensation_fault, Register::fault}}) {
    image[entry_of(copy).address] = image[entry_of(of).address];
  }
}

}  // namespace spindle_twin::firmware
