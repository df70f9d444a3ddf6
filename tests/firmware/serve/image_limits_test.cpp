#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"

/// Counts that wrap, what is not there, and times at their ends.
namespace spindle_twin::firmware {
namespace serve_image_limits_test {

RegisterImage shown(const Snapshot& snapshot, std::int64_t now_ns = 0) {
  RegisterImage image{};
  fill_image(snapshot, now_ns, image);
  return image;
}
bool is_absent(const RegisterImage& image, Register which, int slot = 0) { return std::isnan(get(image, which, slot)); }

TEST(ImageLimits, counts_wrap_before_the_number_that_says_not_present) {
  for (const auto& [count, stands] : {std::pair{65533, 65533.0}, {65534, 65534.0}, {65535, 0.0}}) {
    Snapshot snapshot;
    snapshot.parameters = 1;
    snapshot.tare_count = snapshot.correction_count = snapshot.sensor_tare_count = snapshot.displacement_count =
        static_cast<std::uint16_t>(count);
    const RegisterImage image = shown(snapshot);
    for (const Register which : {Register::tare_count, Register::correction_count, Register::sensor_tare_count,
                                 Register::displacement_count}) {
      EXPECT_EQ(get(image, which), stands) << entry_of(which).name;
    }
  }
  for (const auto& [count, stands] : {std::pair{0xFFFFFFFEU, 4294967294.0}, {0xFFFFFFFFU, 0.0}}) {
    Snapshot snapshot;
    snapshot.network_id = count;
    snapshot.devices[7] = {true, true, count, count};
    const RegisterImage image = shown(snapshot);
    EXPECT_EQ(get(image, Register::device_accepted, 7), stands);
    EXPECT_EQ(get(image, Register::device_refused, 7), stands);
    EXPECT_EQ(get(image, Register::network_id), stands);
  }
}

TEST(ImageLimits, the_first_of_what_is_counted_from_zero_is_there) {
  Snapshot snapshot;
  snapshot.health_watched = true;
  snapshot.sensor_quality[0] = SensorQuality::good;
  snapshot.sensor_health[0].partner = 0;
  snapshot.unexplained_heat_group = 0;
  snapshot.sensor_tare_point = 0;
  snapshot.network_id = 1;
  RegisterImage image = shown(snapshot);
  EXPECT_EQ(get(image, Register::sensor_partner), 0.0);
  EXPECT_EQ(get(image, Register::unexplained_heat_group), 0.0);
  EXPECT_EQ(get(image, Register::sensor_tare_point), 0.0);
  EXPECT_EQ(get(image, Register::network_id), 1.0);
  snapshot.sensor_health[0].partner = -1;
  snapshot.unexplained_heat_group = snapshot.sensor_tare_point = -1;
  snapshot.network_id = 0;
  image = shown(snapshot);
  for (const Register which : {Register::sensor_partner, Register::unexplained_heat_group, Register::sensor_tare_point,
                               Register::network_id}) {
    EXPECT_TRUE(is_absent(image, which)) << entry_of(which).name;
  }
}

TEST(ImageLimits, an_estimator_of_one_parameter_is_one) {
  Snapshot snapshot;
  snapshot.updates = 70000;
  snapshot.parameters = 1;
  const RegisterImage image = shown(snapshot);
  EXPECT_EQ(get(image, Register::estimator_updates), 70000.0);
  EXPECT_EQ(get(image, Register::parameter_count), 1.0);
  EXPECT_EQ(get(image, Register::parameters_determined), 0.0);
  EXPECT_EQ(get(image, Register::displacement_count), 0.0);
}

TEST(ImageLimits, health_is_said_of_sensors_that_are_watched_and_there) {
  Snapshot snapshot;
  snapshot.sensor_quality[1] = SensorQuality::stale;
  EXPECT_TRUE(is_absent(shown(snapshot), Register::sensor_state, 1));
  EXPECT_TRUE(is_absent(shown(snapshot), Register::model_in_doubt));
  snapshot.health_watched = true;
  const RegisterImage image = shown(snapshot);
  EXPECT_EQ(get(image, Register::sensor_state, 1), bits(SensorState::good));
  EXPECT_EQ(get(image, Register::sensor_spikes, 1), 0.0);
  EXPECT_TRUE(is_absent(image, Register::sensor_state, 0)) << "there is none";
  EXPECT_EQ(get(image, Register::model_in_doubt), 0.0);
  EXPECT_EQ(get(image, Register::sensors_failed), 0.0);
}

TEST(ImageLimits, a_device_counts_where_it_is_used_and_is_offline_where_it_is_not_connected) {
  Snapshot snapshot;
  for (std::size_t d = 0; d < slots::devices; ++d) {
    snapshot.devices = {};
    snapshot.devices[d] = {true, false, 5, 6};
    EXPECT_EQ(get(shown(snapshot), Register::devices_offline), std::exp2(static_cast<double>(d)));
    EXPECT_EQ(get(shown(snapshot), Register::device_count), 1.0);
    snapshot.devices[d].connected = true;
    EXPECT_EQ(get(shown(snapshot), Register::devices_offline), 0.0);
    snapshot.devices[d].used = snapshot.devices[d].connected = false;
    EXPECT_EQ(get(shown(snapshot), Register::devices_offline), 0.0);
    EXPECT_TRUE(is_absent(shown(snapshot), Register::device_accepted, static_cast<int>(d)));
  }
}

TEST(ImageLimits, the_age_of_a_prediction_is_never_below_zero_nor_beyond_its_register_and_is_no_clipped_value) {
  Snapshot snapshot;
  snapshot.state = State::running;
  EXPECT_TRUE(is_absent(shown(snapshot, 99), Register::prediction_age)) << "there was no cycle";
  snapshot.time_ns = 1;
  EXPECT_EQ(get(shown(snapshot, 1), Register::prediction_age), 0.0);
  snapshot.time_ns = 5'000'000'000;
  EXPECT_EQ(get(shown(snapshot, 4'000'000'000), Register::prediction_age), 0.0);
  const RegisterImage old = shown(snapshot, 500'000'000'000);
  EXPECT_NEAR(get(old, Register::prediction_age), 65.534, 1e-9);
  EXPECT_EQ(get(old, Register::quality), 0.0);
  EXPECT_EQ(get(old, Register::state), bits(State::running));
}

TEST(ImageLimits, a_clipped_value_makes_what_runs_degraded_and_leaves_other_states) {
  for (const auto& [state, shows] : {std::pair{State::running, State::degraded},
                                     {State::degraded, State::degraded},
                                     {State::fault, State::fault},
                                     {State::starting, State::starting}}) {
    Snapshot snapshot;
    snapshot.state = state;
    snapshot.quality = bits(Quality::tared);
    EXPECT_EQ(get(shown(snapshot), Register::state), bits(state));
    snapshot.heat_factor[15] = 65.534;
    EXPECT_EQ(get(shown(snapshot), Register::quality), bits(Quality::tared));
    snapshot.heat_factor[15] = 65.6;
    const RegisterImage image = shown(snapshot);
    for (const Register which : {Register::state, Register::compensation_state}) {
      EXPECT_EQ(get(image, which), bits(shows));
    }
    for (const Register which : {Register::quality, Register::compensation_quality}) {
      EXPECT_EQ(get(image, which), bits(Quality::tared) | bits(Quality::saturated));
    }
  }
}

TEST(ImageLimits, what_is_left_of_a_time_is_rounded_up_in_seconds_and_minutes_have_sixty) {
  Snapshot snapshot;
  snapshot.sensor_tare_left_s = 10.2;
  snapshot.compensation.trial_left_s = 0.1;
  snapshot.compensation.settled_after_s = 7200.0;
  snapshot.exchange = {ExchangeState::trial, 0.5, 0.25, 3600.0};
  snapshot.sensor_tare_wait = TareWait::change;
  RegisterImage image = shown(snapshot);
  EXPECT_EQ(get(image, Register::sensor_tare_left), 11.0);
  EXPECT_EQ(get(image, Register::compensation_trial_left), 1.0);
  EXPECT_EQ(get(image, Register::compensation_settled_after), 120.0);
  EXPECT_EQ(get(image, Register::exchange_state), bits(ExchangeState::trial));
  EXPECT_EQ(get(image, Register::exchange_left), 60.0);
  EXPECT_EQ(get(image, Register::exchange_error_old), 0.5);
  EXPECT_EQ(get(image, Register::exchange_error_new), 0.25);
  EXPECT_EQ(get(image, Register::sensor_tare_wait), bits(TareWait::change));
  snapshot.sensor_tare_left_s = 10.0;
  snapshot.compensation.trial_left_s = 0.0;
  image = shown(snapshot);
  EXPECT_EQ(get(image, Register::sensor_tare_left), 10.0);
  EXPECT_EQ(get(image, Register::compensation_trial_left), 0.0);
}

TEST(ImageLimits, orders_stand_newest_first_each_in_its_slot) {
  Snapshot snapshot;
  snapshot.orders = 70001;
  for (std::size_t i = 0; i < order_records; ++i) {
    snapshot.last_orders[i] = {static_cast<std::uint32_t>(i), static_cast<std::uint16_t>(100 + i), OrderKind::tare,
                               OrderResult::done};
  }
  snapshot.last_orders[1].kind = OrderKind::sensors;
  snapshot.last_orders[2].result = OrderResult::refused;
  const RegisterImage image = shown(snapshot);
  EXPECT_EQ(get(image, Register::order_count), 70001.0);
  for (int i = 0; i < static_cast<int>(order_records); ++i) {
    EXPECT_EQ(get(image, Register::order_id, i), 100.0 + i);
    EXPECT_EQ(get(image, Register::order_kind, i), bits(i == 1 ? OrderKind::sensors : OrderKind::tare));
    EXPECT_EQ(get(image, Register::order_result, i), bits(i == 2 ? OrderResult::refused : OrderResult::done));
  }
}

TEST(ImageLimits, an_update_says_what_it_made_of_a_reading_of_the_last_sensor_too) {
  Snapshot snapshot;
  constexpr int last = static_cast<int>(slots::key_points) - 1;
  snapshot.sensor_update[last] = {303.15, -0.25, 0.5, 1.25, 0.125, 0.0624, bits(Update::fused), 0};
  snapshot.displacement_update = {5e-6, -1.5e-6, 4e-12, 0.75, not_a_value, not_a_value, bits(Update::rejected), 0};
  const RegisterImage image = shown(snapshot);
  EXPECT_NEAR(get(image, Register::sensor_observation, last), 30.0, 1e-9);
  EXPECT_NEAR(get(image, Register::sensor_innovation, last), -0.25, 1e-9);
  EXPECT_NEAR(get(image, Register::sensor_variance, last), 0.5, 1e-9);
  EXPECT_NEAR(get(image, Register::sensor_test_ratio, last), 1.25, 1e-9);
  EXPECT_NEAR(get(image, Register::sensor_offset, last), 0.125, 1e-9);
  EXPECT_NEAR(get(image, Register::sensor_offset_sd, last), 0.062, 1e-9);
  EXPECT_EQ(get(image, Register::sensor_update, last), bits(Update::fused));
  EXPECT_TRUE(is_absent(image, Register::sensor_update, 0));
  EXPECT_EQ(get(image, Register::displacement_update), bits(Update::rejected));
  EXPECT_NEAR(get(image, Register::displacement_innovation), -1.5, 1e-6);
  EXPECT_NEAR(get(image, Register::displacement_innovation_sd), 2.0, 1e-6);
  EXPECT_NEAR(get(image, Register::displacement_test_ratio), 0.75, 1e-9);
}

}  // namespace serve_image_limits_test
}  // namespace spindle_twin::firmware
