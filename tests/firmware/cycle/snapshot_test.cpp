#include "firmware/cycle/snapshot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "firmware/cycle/device_inbox.hpp"
#include "firmware/cycle/exchange.hpp"

/// What stands where nobody has said anything yet.
namespace spindle_twin::firmware {
namespace cycle_snapshot_test {

template <class Values>
void expect_none(const Values& values) {
  for (const auto& value : values) EXPECT_TRUE(std::isnan(value));
}

TEST(BeforeAnything, nothing_has_happened) {
  const Snapshot now;
  for (const std::uint64_t count : {std::uint64_t{now.sequence},
                                    std::uint64_t{now.quality},
                                    std::uint64_t{now.fault},
                                    std::uint64_t{now.overruns},
                                    std::uint64_t{now.tare_count},
                                    std::uint64_t{now.correction_count},
                                    std::uint64_t{now.correction_freeze},
                                    std::uint64_t{now.key_points},
                                    std::uint64_t{now.parts},
                                    std::uint64_t{now.sources},
                                    std::uint64_t{now.conductances},
                                    std::uint64_t{now.deformations},
                                    std::uint64_t{now.circuits},
                                    std::uint64_t{now.heats},
                                    std::uint64_t{now.flows},
                                    std::uint64_t{now.bodies},
                                    std::uint64_t{now.orders},
                                    std::uint64_t{now.signals_held},
                                    std::uint64_t{now.signals_implausible},
                                    std::uint64_t{now.outputs_clamped},
                                    std::uint64_t{now.history_rows_lost},
                                    std::uint64_t{now.log_lines_dropped},
                                    std::uint64_t{now.network_id},
                                    std::uint64_t{now.updates},
                                    std::uint64_t{now.parameters},
                                    std::uint64_t{now.parameters_determined},
                                    std::uint64_t{now.displacement_count},
                                    std::uint64_t{now.displacement_orders},
                                    std::uint64_t{now.sensors_failed},
                                    std::uint64_t{now.sensor_tare_count},
                                    std::uint64_t{now.sensor_orders},
                                    std::uint64_t{now.compensation.bits},
                                    std::uint64_t{now.displacement.output}}) {
    EXPECT_EQ(count, 0U);
  }
  for (const bool says : {now.correction_configured, now.correction_enabled, now.health_watched, now.model_in_doubt}) {
    EXPECT_FALSE(says);
  }
  EXPECT_EQ(now.time_ns, 0);
  EXPECT_EQ(now.clock_ns, 0);
  EXPECT_EQ(now.model_time_s, 0.0);
  EXPECT_EQ(now.tare_m, 0.0);
  for (const OrderRecord& order : now.last_orders) EXPECT_EQ(order.number + order.id, 0U);
  EXPECT_EQ(now.last_orders.size(), 8U) << "as the registers promise";
}

TEST(BeforeAnything, nothing_is_known) {
  const Snapshot now;
  EXPECT_EQ(now.unexplained_heat_group, -1);
  EXPECT_EQ(now.sensor_tare_point, -1);
  for (const ChannelUpdate& update : now.sensor_update) {
    EXPECT_EQ(update.flags, 0);
    EXPECT_EQ(update.rejected_in_a_row, 0);
    EXPECT_TRUE(std::isnan(update.observation));
  }
  for (const SensorHealthState& health : now.sensor_health) {
    EXPECT_EQ(health.partner, -1);
    EXPECT_EQ(health.spikes, 0);
  }
  for (const DeviceState& device : now.devices) {
    EXPECT_FALSE(device.used || device.connected);
    EXPECT_EQ(device.accepted + device.refused, 0U);
  }
  expect_none(now.signals);
  expect_none(now.predicted_K);
  expect_none(now.deformation_m);
  expect_none(now.heat_factor);
  expect_none(std::initializer_list<double>{now.nose_m, now.data_age_s, now.exchange.left_s, now.compensation.value_m,
                                            now.unexplained_heat_W, now.calibrated_unix_s});
}

TEST(BeforeAnything, nothing_was_read_or_ordered) {
  const DeviceFrame frame;
  EXPECT_FALSE(frame.connected);
  for (const Reading& reading : frame.sensors) EXPECT_EQ(reading.time_ns, 0);
  const SensedInputs sensed;
  EXPECT_FALSE(sensed.device_connected || sensed.signals[0].silent);
  for (const Sensed& each : sensed.sensors) EXPECT_EQ(each.time_ns, 0);
  const PlcCommand command;
  EXPECT_EQ(command.tare_orders + command.sensor_orders + command.displacements + command.acknowledgements +
                command.trial.orders + command.trial.renewals,
            0U);
  EXPECT_EQ(command.alive_ns[0], 0);
  EXPECT_EQ(PlcSignals{}.alive_ns[0], 0);
  const StandingOrders orders;
  EXPECT_EQ(orders.revision + orders.sensor_tares + orders.acknowledgements, 0U);
  EXPECT_EQ(orders.tare_m, 0.0);
  EXPECT_FALSE(orders.lost);
  EXPECT_EQ(Order{}.id + Order{}.code, 0);
  const Remembered remembered;
  EXPECT_FALSE(remembered.started);
  EXPECT_EQ(remembered.tare_m + remembered.trial_away_m + remembered.model_time_s, 0.0);
  const Troubles troubles;
  EXPECT_EQ(troubles.faults(), 0);
  EXPECT_EQ(troubles.history_rows_lost.load(), 0U);
}

/// Where neither the configuration nor a test says otherwise.
TEST(BeforeAnything, a_plan_is_of_a_cycle_a_second_and_as_cautious_as_the_documents_say) {
  const CyclePlan plan;
  EXPECT_EQ(plan.period_s, 1.0);
  EXPECT_EQ(plan.clock_rate, 1.0);
  EXPECT_TRUE(plan.compare_uncorrected && plan.correction_enabled && plan.estimator_corrects);
  EXPECT_FALSE(plan.tare_to_ambient);
  EXPECT_EQ(plan.plc_timeout_s, 0.0);
  EXPECT_EQ(plan.return_within_K, 0.5);
  EXPECT_EQ(plan.slew_m_per_s, 5e-7);
  EXPECT_EQ(plan.start_wait_s, 60.0);
  const SensorPlan sensor;
  EXPECT_FALSE(sensor.configured);
  EXPECT_DOUBLE_EQ(sensor.min_K, zero_degC_K - 20.0);
  EXPECT_DOUBLE_EQ(sensor.max_K, zero_degC_K + 150.0);
  EXPECT_EQ(sensor.stale_after_s, 3.0);
  EXPECT_EQ(sensor.noise_K, 0.03);
  EXPECT_EQ(sensor.offset_deviation_K, 0.02);
  EXPECT_EQ(sensor.lag_s, 0.0);
  EXPECT_EQ(sensor.interval_s, 0.0);
  EXPECT_EQ(sensor.resolution_K, 0.01);
  const ProbePlan probe;
  EXPECT_FALSE(probe.configured);
  EXPECT_EQ(probe.deviation_m, 1e-6);
  EXPECT_EQ(probe.min_m, -1e-3);
  EXPECT_EQ(probe.max_m, 1e-3);
  EXPECT_EQ(probe.interval_s, 60.0);
  EXPECT_EQ(probe.stale_after_s, 3.0);
  EXPECT_EQ(SignalPlan{}.stale_after_s, 0.0);
  const CompensationPlan compensation;
  EXPECT_TRUE(compensation.enabled);
  EXPECT_EQ(compensation.sign, 1.0);
  EXPECT_EQ(compensation.slew_m_per_s, 5e-7);
  EXPECT_EQ(compensation.step_m, 0.0);
  EXPECT_EQ(compensation.hold_s, 600.0);
  EXPECT_EQ(compensation.decay_s, 1800.0);
  EXPECT_EQ(compensation.distance_m, 0.0);
  EXPECT_EQ(compensation.reference_m, 0.0);
  const ForecastPlan forecast;
  EXPECT_EQ(forecast.ahead_s, 0.0);
  EXPECT_EQ(forecast.settled_m, 1e-6);
  EXPECT_EQ(forecast.every_cycles, 1U);
  EXPECT_EQ(Forecast::strides * Forecast::stride_s, 4.0 * 3600.0) << "a horizon of four hours";
  EXPECT_EQ(Forecast::settled_within_s, 600.0);
  EXPECT_EQ(ExchangePlan{}, (ExchangePlan{3600.0, 3600.0, 0.1, 0.05}));
}

TEST(DeviceInbox, is_connected_where_all_that_are_in_use_are_and_keeps_each_devices_values) {
  for (const int connected : {0, 1, 2, 3}) {
    DeviceInbox inbox;
    DeviceFrame all;
    inbox.read(all);
    EXPECT_FALSE(all.connected) << "there is none";
    for (const std::size_t number : {std::size_t{0}, slots::devices - 1}) {
      const std::size_t which = number == 0 ? 0 : 1;
      DeviceFrame frame;
      frame.devices[number].used = true;
      frame.devices[number].connected = (connected & (1 << which)) != 0;
      frame.sensors[which] = {300.0 + static_cast<double>(which), 1};
      frame.signals[signal_count - 1 - which] = {7.0 + static_cast<double>(which), 2};
      frame.displacements[which] = {1e-6, 3};
      inbox.of(number).write(frame);
    }
    inbox.read(all);
    EXPECT_EQ(all.connected, connected == 3) << connected;
    for (const std::size_t which : {0U, 1U}) {
      EXPECT_EQ(all.sensors[which].value, 300.0 + static_cast<double>(which));
      EXPECT_EQ(all.signals[signal_count - 1 - which].value, 7.0 + static_cast<double>(which));
      EXPECT_EQ(all.displacements[which].value, 1e-6);
    }
    EXPECT_EQ(all.sensors[2].time_ns, 0);
  }
}

}  // namespace cycle_snapshot_test
}  // namespace spindle_twin::firmware
