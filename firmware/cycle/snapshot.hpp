#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "firmware/cycle/states.hpp"
#include "rom/units.hpp"

namespace spindle_twin::firmware {

inline constexpr double not_a_value = std::numeric_limits<double>::quiet_NaN();
using rom::zero_degC_K;

/// The first value of an array of numbers that do not exist yet.
inline constexpr struct NotValues {
  template <std::size_t count>
  constexpr operator std::array<double, count>() const {  // NOLINT(google-explicit-constructor): stands for any of them
    std::array<double, count> values{};
    values.fill(not_a_value);
    return values;
  }
} not_values;

template <class Code>
constexpr std::uint16_t bits(Code code) {
  return static_cast<std::uint16_t>(code);
}

/// What the machine tells besides the sensors; behind these the flow of each coolant circuit and the watts of each
/// measured heat. From the coolant on a machine need not tell them: coolant and ambient where the network has no such
/// surrounding.
enum class Signal : std::size_t { speed, load, coolant, ambient, current, power };
inline constexpr std::size_t first_optional_signal = 2;
inline constexpr std::size_t first_flow_signal = 6;
inline constexpr std::size_t first_heat_signal = first_flow_signal + slots::circuits;
inline constexpr std::size_t signal_count = first_heat_signal + slots::heats;

/// One reading; sensors, coolant and ambient in K, speed in rpm, load as a fraction of the rated load, the motor's
/// phase current in A and electrical power in W, flows in kg/s, negative when the coolant runs from the last segment to
/// the first, heats in W.
struct Reading {
  double value = not_a_value;
  std::int64_t time_ns = 0;  ///< monotonic; 0: never read
};

/// One data-acquisition device.
struct DeviceState {
  bool used = false;
  bool connected = false;
  std::uint32_t accepted = 0;  ///< answers or frames since the start; wraps
  std::uint32_t refused = 0;   ///< those that were not taken: exceptions, wrong, damaged, cut, doubled or none in time
};

/// What the data-acquisition devices last said; sensors in the order of the network's key points.
struct DeviceFrame {
  std::array<Reading, slots::key_points> sensors;
  std::array<Reading, signal_count> signals;
  std::array<Reading, slots::deformations> displacements;  ///< probes, in m; in the order of the network's deformations
  bool connected = false;                                  ///< all devices in use are
  std::array<DeviceState, slots::devices> devices;         ///< in the order of the configuration
};

/// A length that somebody measured at one of the deformation outputs: a touch-off or a probe. Counted as the published
/// value is: + = spindle longer, of the nose minus the tare.
struct Displacement {
  std::size_t output = 0;
  double value_m = not_a_value;
  double deviation_m = not_a_value;
};

enum class TareOrder : std::uint8_t { take, clear };
enum class SensorOrder : std::uint8_t { tare, clear_tare, acknowledge };
enum class SwitchOrder : std::uint8_t { as_configured, off, on };

/// What the PLC last told of the machine.
struct PlcSignals {
  std::array<Reading, signal_count> values;
  std::array<std::int64_t, signal_count> alive_ns{};  ///< monotonic, of the last request of the client that told each
                                                      ///< of them last; 0: never heard
};

/// A known value of the compensation, to try the control's input with; firmware/cycle/compensation_trial.hpp.
struct TrialOrder {
  double value_m = not_a_value;  ///< NaN: the trial ends
  std::uint32_t orders = 0;      ///< counts up with each order
  std::uint32_t renewals = 0;    ///< counts up each time that who gave it says to be there still
};

/// What the PLC wants of one cycle; of each kind of order one at most (OrderDesk hands them out).
struct PlcCommand {
  std::array<Reading, signal_count> signals;
  std::array<std::int64_t, signal_count> alive_ns{};  ///< as in PlcSignals
  SwitchOrder correction = SwitchOrder::as_configured;
  TareOrder tare_order = TareOrder::take;
  std::uint32_t tare_orders = 0;  ///< counts up with each order
  SensorOrder sensor_order = SensorOrder::tare;
  std::uint32_t sensor_orders = 0;  ///< counts up with each order
  Displacement displacement;
  std::uint32_t displacements = 0;     ///< counts up with each measurement
  std::uint32_t acknowledgements = 0;  ///< counts up with each order to take back latched faults
  SwitchOrder compensation = SwitchOrder::as_configured;
  TrialOrder trial;
};

/// What became of one order.
struct OrderRecord {
  std::uint32_t number = 0;  ///< counts the orders since the start; 0: there is none
  std::uint16_t id = 0;      ///< what the PLC called it
  OrderKind kind = OrderKind::none;
  OrderResult result = OrderResult::none;
};
inline constexpr std::size_t order_records = 8;

/// What the estimator's last update made of one channel; in K, or in m for a displacement.
struct ChannelUpdate {
  double observation = not_a_value;  ///< mean of the new readings since the update before
  double innovation = not_a_value;   ///< observation − prediction − offset
  double variance = not_a_value;     ///< expected of the innovation
  double test_ratio = not_a_value;   ///< innovation² / (gate² variance)
  double offset = not_a_value;
  double offset_deviation = not_a_value;
  std::uint16_t flags = 0;              ///< bits of Update
  std::uint16_t rejected_in_a_row = 0;  ///< saturates
};

/// Whether a sensor is believed (correction/health).
struct SensorHealthState {
  SensorState state = SensorState::good;
  SensorFault fault = SensorFault::none;
  std::int16_t partner = -1;  ///< key point whose temperature a swapped sensor shows
  std::uint16_t spikes = 0;
  double misfit_ratio = not_a_value;
};

/// What the CNC adds to its axis (compensate.hpp).
struct CompensationState {
  double value_m = not_a_value;
  double deviation_m = not_a_value;
  double age_s = not_a_value;  ///< since there was a prediction, model time
  Rung rung = Rung::none;
  std::uint16_t bits = 0;  ///< of CompensationBit
  double slope = not_a_value;
  double reference_m = not_a_value;
  double forecast_m = not_a_value;       ///< the value wanted after the look-ahead, nothing else changing
  double settled_after_s = not_a_value;  ///< from when on the growth hardly changes (Forecast)
  double trial_left_s = not_a_value;     ///< clock time until a trial ends by itself; 0 on the way back from it
};

/// The exchange of the network (exchange.hpp).
struct ExchangeView {
  ExchangeState state = ExchangeState::none;
  double running_K = not_a_value;    ///< rms of reading minus prediction, of the network that was there before
  double candidate_K = not_a_value;  ///< of the new one
  double left_s = not_a_value;       ///< of the trial, or of the watch behind it; model time with readings
};

/// Of the ln of a factor, 1σ: what the prior says at the present speed and temperatures, and how sure the estimate is
/// of what is in use; NaN without an estimator, the last while it corrects nothing.
struct FactorBand {
  float prior_mean = std::numeric_limits<float>::quiet_NaN();
  float prior_deviation = std::numeric_limits<float>::quiet_NaN();
  float deviation = std::numeric_limits<float>::quiet_NaN();
};

/// All that is known after a cycle: plain data of fixed size, so that it is copied between threads without the heap.
/// Entries beyond the counts, and values that do not exist, are NaN. Room as in states.toml.
struct Snapshot {  // NOLINT(public-members): one page of plain data, copied whole; registers show it member by member
  std::int64_t time_ns = 0;    ///< monotonic, end of the cycle
  std::int64_t clock_ns = 0;   ///< monotonic, when this cycle began, from the first one on
  std::uint64_t sequence = 0;  ///< number of the cycle
  State state = State::starting;
  std::uint16_t quality = 0;  ///< bits of Quality
  std::uint16_t fault = 0;    ///< bits of Fault
  double model_time_s = 0.0;  ///< since the start of the prediction; the instant that the predictions are for
  double data_age_s = not_a_value;
  std::uint32_t overruns = 0;
  std::uint16_t tare_count = 0;
  std::uint16_t correction_count = 0;
  std::uint16_t correction_freeze = 0;  ///< CorrectionFreeze; of the published law: of its first group
  bool correction_configured = false;
  bool correction_enabled = false;

  std::size_t key_points = 0;
  std::size_t parts = 0;
  std::size_t sources = 0;
  std::size_t conductances = 0;
  std::size_t deformations = 0;
  std::size_t circuits = 0;
  std::size_t heats = 0;   ///< measured ones
  std::size_t flows = 0;   ///< of heat from body to body that are told: as many as there is room for
  std::size_t bodies = 0;  ///< parts and volumes of air, likewise

  std::uint32_t orders = 0;                            ///< taken up since the start
  std::array<OrderRecord, order_records> last_orders;  ///< newest first
  std::uint16_t signals_held = 0;                      ///< bit s: signal s is not believed, what it was is in use
  std::uint16_t signals_implausible = 0;               ///< of these, those outside their limits or too fast
  std::uint16_t outputs_clamped = 0;                   ///< bit d: deformation output d is held at its limit
  std::array<DeviceState, slots::devices> devices;
  std::uint64_t history_rows_lost = 0;
  std::uint64_t log_lines_dropped = 0;

  std::array<double, signal_count> signals = not_values;  ///< in use; NaN: not told
  std::array<double, slots::key_points> measured_K = not_values;
  std::array<double, slots::key_points> raw_K = not_values;           ///< the same before the sensor tare
  std::array<double, slots::key_points> measured_age_s = not_values;  ///< model time since the reading
  std::array<SensorQuality, slots::key_points> sensor_quality = [] {
    std::array<SensorQuality, slots::key_points> qualities{};
    qualities.fill(SensorQuality::not_configured);
    return qualities;
  }();
  std::array<double, slots::deformations> probe_m = not_values;  ///< what displacement probes read
  std::array<double, slots::deformations> probe_age_s = not_values;
  std::array<double, slots::key_points> predicted_K = not_values;
  std::array<double, slots::key_points> uncorrected_K = not_values;
  std::array<double, slots::parts> part_maximum_K = not_values;
  std::array<double, slots::deformations> deformation_raw_m =
      not_values;                                                      ///< the first is the nose, + = spindle longer
  std::array<double, slots::deformations> deformation_m = not_values;  ///< follows the one above at the slew limit
  double nose_m = not_a_value;                                         ///< deformation_m[0] minus the tare
  double nose_uncorrected_m = not_a_value;                             ///< minus the tare
  double tare_m = 0.0;
  double nose_network_deviation_m = not_a_value;  ///< the certificate's part of the nose's standard deviation
  // Standard deviations of what is published, NaN with the published law, which knows none.
  std::array<double, slots::key_points> predicted_deviation_K = not_values;
  std::array<double, slots::parts> part_maximum_deviation_K = not_values;
  std::array<double, slots::deformations> deformation_deviation_m = not_values;
  std::array<double, slots::sources> heat_factor = not_values;
  std::array<double, slots::conductances> conductance_factor = not_values;
  std::array<FactorBand, slots::sources> heat_band{};
  std::array<FactorBand, slots::conductances> conductance_band{};
  std::array<double, slots::flows> flow_W = not_values;   ///< by rom::flow_paths(), each in its sense
  std::array<double, slots::bodies> made_W = not_values;  ///< what rom::FlowRows says that a body is given otherwise

  CompensationState compensation;

  std::uint32_t network_id = 0;  ///< the first eight hex digits of the network file's SHA-256; 0: not said
  ExchangeView exchange;

  std::uint32_t updates = 0;  ///< of the estimator since the start
  std::uint16_t parameters = 0;
  std::uint16_t parameters_determined = 0;   ///< of which the sensors tell more than a tenth of the prior deviation
  std::int16_t unexplained_heat_group = -1;  ///< thermal group with a heat that no source explains; -1: none
  double unexplained_heat_W = not_a_value;
  double calibrated_unix_s = not_a_value;       ///< when the calibration that the estimator began with was made
  double calibration_promised_m = not_a_value;  ///< 1σ of the nose, as of NosePromise
  std::uint16_t displacement_count = 0;         ///< measured lengths taken in since the start
  std::uint32_t displacement_orders = 0;        ///< those that the PLC gave, and the last of them
  Displacement displacement;
  std::array<ChannelUpdate, slots::key_points> sensor_update{};
  ChannelUpdate displacement_update;

  bool health_watched = false;
  bool model_in_doubt = false;
  std::uint16_t sensors_failed = 0;
  std::uint16_t sensor_tare_count = 0;
  TareWait sensor_tare_wait = TareWait::start;
  std::int16_t sensor_tare_point = -1;      ///< key point that it waits for; -1: no single one
  double sensor_tare_left_s = not_a_value;  ///< model time until the tare is judged next
  std::uint32_t sensor_orders = 0;          ///< those that the PLC gave for its sensors, and the last of them
  SensorOrder sensor_order = SensorOrder::tare;
  std::array<SensorHealthState, slots::key_points> sensor_health{};
  std::array<double, slots::key_points> sensor_tare_K = not_values;  ///< subtracted from the readings
};

}  // namespace spindle_twin::firmware
