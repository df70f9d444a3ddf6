#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <string>

#include "tests/firmware/support/machine.hpp"

/// What a cycle makes of each order, and what holds of them from one run to the next.
namespace spindle_twin::firmware {
namespace cycle_cycle_orders_test {

DeviceFrame frame_of(std::initializer_list<double> sensors_K, int n) {
  DeviceFrame frame;
  frame.connected = true;
  std::size_t k = 0;
  for (const double value_K : sensors_K) frame.sensors[k++] = {value_K, at_s(n)};
  return frame;
}

OrderResult result_of(const Cycle& cycle, OrderKind kind) {
  return cycle.order_results()[static_cast<std::size_t>(kind)];
}

TEST(Orders, a_switch_without_anything_to_switch_is_refused_and_any_other_position_is_done) {
  rom::Network network = tests::small_network();
  rom::Network no_nose = network;
  no_nose.deformations.clear();
  no_nose.certificate.deformations_m.clear();
  for (const SwitchOrder order : {SwitchOrder::as_configured, SwitchOrder::off, SwitchOrder::on}) {
    PlcCommand command;
    command.correction = command.compensation = order;
    Cycle open(network, open_loop(), runtime), closed(network, estimated(), runtime);
    Cycle without(no_nose, open_loop(), runtime);
    for (Cycle* cycle : {&open, &closed, &without}) cycle->step({}, command, at_s(0), 0);
    EXPECT_EQ(result_of(open, OrderKind::correction),
              order == SwitchOrder::on ? OrderResult::refused : OrderResult::done);
    EXPECT_EQ(result_of(closed, OrderKind::correction), OrderResult::done);
    EXPECT_EQ(result_of(open, OrderKind::compensation), OrderResult::done);
    EXPECT_EQ(result_of(without, OrderKind::compensation),
              order == SwitchOrder::as_configured ? OrderResult::done : OrderResult::refused);
    EXPECT_EQ(result_of(without, OrderKind::trial), OrderResult::refused);
    EXPECT_EQ(result_of(open, OrderKind::trial), OrderResult::none);
  }
}

TEST(Orders, the_correction_stands_as_configured_until_it_is_switched) {
  const rom::Network network = tests::small_network();
  for (const bool enabled : {true, false}) {
    CyclePlan plan = estimated();
    plan.correction_enabled = enabled;
    Cycle cycle(network, plan, runtime);
    PlcCommand command;
    EXPECT_EQ(cycle.step({}, command, at_s(0), 0).correction_enabled, enabled);
    command.correction = enabled ? SwitchOrder::off : SwitchOrder::on;
    const Snapshot& now = cycle.step({}, command, at_s(1), 0);
    EXPECT_EQ(now.correction_enabled, !enabled);
    EXPECT_EQ((now.quality & bits(Quality::correction_off)) != 0, enabled);
    EXPECT_EQ(cycle.standing_orders().correction, command.correction);
  }
}

TEST(Orders, a_trial_lasts_as_long_as_the_clock_says) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = open_loop();
  plan.clock_rate = 4.0;  // of the model: a person waits by the clock
  Cycle cycle(network, plan, runtime);
  PlcCommand command;
  constexpr int begins = 5;
  for (int n = 0; n < begins; ++n) cycle.step({}, command, at_s(n), 0);
  command.trial = {1e-6, 1, 1};
  for (int n = 0; n < 60; ++n) {
    EXPECT_NEAR(cycle.step({}, command, at_s(begins + n), 0).compensation.trial_left_s, 60.0 - n, 1e-9);
    EXPECT_EQ(result_of(cycle, OrderKind::trial), n == 0 ? OrderResult::done : OrderResult::none);
  }
  EXPECT_EQ(cycle.step({}, command, at_s(begins + 60), 0).compensation.trial_left_s, 0.0);
}

TEST(Orders, a_tare_stays_within_the_limit_of_the_nose) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = open_loop();
  plan.start_temperature_K = 310.0;
  plan.output_limit_m[0] = 2e-6;
  plan.output_limit_m[1] = 1e-6;
  Cycle cycle(network, plan, runtime);
  PlcCommand command;
  ASSERT_GT(cycle.step({}, command, at_s(0), 0).deformation_raw_m[0], 2e-6);
  command.tare_orders = 1;
  EXPECT_EQ(cycle.step({}, command, at_s(1), 0).tare_m, 2e-6);
}

TEST(Orders, lengths_sensor_orders_and_tares_wait_for_the_start_and_are_obeyed_once_then) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.start_temperature_K.reset();
  Cycle cycle(network, plan, runtime);
  PlcCommand command;
  command.displacement = {0, 1e-6, 1e-6};
  command.sensor_order = SensorOrder::acknowledge;
  command.displacements = command.sensor_orders = command.tare_orders = 5;
  Snapshot now;
  for (int n = 0; n < 2; ++n) {
    now = cycle.step({}, command, at_s(n), 0);
    for (const OrderKind kind : {OrderKind::length, OrderKind::sensors, OrderKind::tare}) {
      EXPECT_EQ(result_of(cycle, kind), OrderResult::waiting);
    }
    EXPECT_EQ(now.displacement_orders + now.sensor_orders + now.tare_count, 0U);
  }
  // The cycle in which it starts still takes them up before the start.
  cycle.step(frame_of({300.0, 300.0, 300.0}, 2), command, at_s(2), 0);
  now = cycle.step(frame_of({300.0, 300.0, 300.0}, 3), command, at_s(3), 0);
  for (const OrderKind kind : {OrderKind::sensors, OrderKind::tare}) {
    EXPECT_EQ(result_of(cycle, kind), OrderResult::done);
  }
  EXPECT_EQ(now.sensor_order, SensorOrder::acknowledge);
  int n = 4;
  const auto step = [&] { now = cycle.step(frame_of({300.0, 300.0, 300.0}, n), command, at_s(n), 0), ++n; };
  while (result_of(cycle, OrderKind::length) == OrderResult::waiting && n < 30) step();
  EXPECT_EQ(result_of(cycle, OrderKind::length), OrderResult::done) << "once an update has taken it in";
  EXPECT_EQ(now.displacement_update.flags, bits(Update::fused));
  step();
  for (const OrderKind kind : {OrderKind::length, OrderKind::sensors, OrderKind::tare}) {
    EXPECT_EQ(result_of(cycle, kind), OrderResult::none);
  }
  EXPECT_EQ(now.displacement_orders, 1U);
  EXPECT_EQ(now.displacement.value_m, 1e-6);
  EXPECT_EQ(now.sensor_orders, 1U);
  EXPECT_EQ(now.tare_count, 1);
}

TEST(Orders, a_tare_is_cleared_before_the_start_too) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.start_temperature_K.reset();
  Cycle cycle(network, plan, runtime);
  StandingOrders orders;
  orders.tare_m = 2e-6;
  cycle.stand_by_orders(orders);
  PlcCommand command;
  EXPECT_EQ(cycle.step({}, command, at_s(0), 0).tare_m, 2e-6);
  EXPECT_NE(cycle.step({}, command, at_s(1), 0).quality & bits(Quality::tared), 0);
  command.tare_order = TareOrder::clear;
  command.tare_orders = 1;
  const Snapshot& now = cycle.step({}, command, at_s(2), 0);
  EXPECT_EQ(result_of(cycle, OrderKind::tare), OrderResult::done);
  EXPECT_EQ(now.tare_m, 0.0);
  EXPECT_EQ(now.tare_count, 1);
  EXPECT_EQ(now.quality & bits(Quality::tared), 0);
}

TEST(Orders, what_cannot_be_obeyed_is_counted_and_refused) {
  rom::Network no_nose = tests::small_network();
  no_nose.deformations.clear();
  no_nose.certificate.deformations_m.clear();
  Cycle cycle(no_nose, open_loop(), runtime);
  PlcCommand command;
  cycle.step({}, command, at_s(0), 0);
  command.displacement = {0, 1e-6, 1e-6};
  command.sensor_order = SensorOrder::tare;
  command.displacements = command.sensor_orders = command.tare_orders = 1;
  const Snapshot& now = cycle.step({}, command, at_s(1), 0);
  for (const OrderKind kind : {OrderKind::length, OrderKind::sensors, OrderKind::tare}) {
    EXPECT_EQ(result_of(cycle, kind), OrderResult::refused);
  }
  EXPECT_EQ(now.displacement_orders, 1U);
  EXPECT_EQ(now.sensor_orders, 1U);
  EXPECT_EQ(now.tare_count, 1);
  EXPECT_EQ(now.tare_m, 0.0);
}

TEST(Orders, a_length_counts_from_the_tare_at_the_nose_and_from_nothing_at_other_outputs) {
  const rom::Network network = tests::small_network();
  for (const std::size_t output : {0U, 1U}) {
    Cycle cycle(network, estimated(), runtime);
    StandingOrders orders;
    orders.tare_m = 3e-6;
    cycle.stand_by_orders(orders);
    PlcCommand command;
    Machine machine(network, 1.0);
    Snapshot now;
    for (int n = 0; n < 40; ++n) {
      command.displacements = n < 15 ? 0 : 1;
      command.displacement = {output, 1e-6, 1e-5};
      now = cycle.step(machine.frame(at_s(n)), command, at_s(n), 0);
      machine.advance(1.0);
    }
    EXPECT_EQ(now.displacement_count, 1);
    EXPECT_NEAR(now.displacement_update.observation, output == 0 ? 4e-6 : 1e-6, 1e-12);
    EXPECT_EQ(now.displacement.value_m, 1e-6) << "as it was told";
  }
}

/// Lengths told one after the other through the desk, as a control writes them.
struct ToldLengths {
  explicit ToldLengths(const CyclePlan& plan) : network(tests::small_network()), cycle(network, plan, runtime) {
    for (int i = 0; i < 600; ++i) step();
  }
  void step() {
    desk.hand_out(command);
    now = cycle.step(machine.frame(at_s(n)), command, at_s(n), 0);
    ++n;
    desk.settle(cycle.order_results(), cycle.standing_orders(), now);
    machine.advance(1.0);
    if (now.displacement_count != count) seen.push_back(now.displacement);
    count = now.displacement_count;
  }
  void tell(std::size_t output, double value_m) { desk.give({OrderKind::length, 0, 1, {output, value_m, 1e-6}}); }
  rom::Network network;
  Machine machine{network, 1.0};
  Cycle cycle;
  OrderDesk desk;
  PlcCommand command;
  Snapshot now;
  std::vector<Displacement> seen;
  std::uint32_t count = 0;
  int n = 0;
};

TEST(Orders, lengths_told_within_one_update_are_all_taken_in_one_after_the_other) {
  ToldLengths run(estimated());
  const double grown_m = run.now.deformation_raw_m[0], other_m = run.now.deformation_raw_m[1];
  run.tell(0, grown_m + 1e-7);
  run.tell(1, other_m);
  run.tell(0, grown_m - 1e-7);
  for (int i = 0; i < 60; ++i) run.step();
  ASSERT_EQ(run.seen.size(), 3U);
  EXPECT_EQ(run.seen[1].output, 1U);
  EXPECT_EQ(run.seen[2].value_m, grown_m - 1e-7);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(run.now.last_orders[i].result, OrderResult::done) << i;
}

TEST(Orders, a_length_beyond_the_gate_is_refused_and_forgotten) {
  ToldLengths run(estimated()), untold(estimated());
  const auto steps = [&](int count) {
    for (int i = 0; i < count; ++i) run.step(), untold.step();
  };
  const double wrong_m = run.now.deformation_raw_m[0] + 9e-5;
  run.tell(0, wrong_m);
  steps(40);
  EXPECT_EQ(run.now.last_orders[0].result, OrderResult::refused);
  EXPECT_EQ(run.now.displacement_update.flags, bits(Update::rejected));
  EXPECT_NEAR(run.now.deformation_deviation_m[0], untold.now.deformation_deviation_m[0],
              1e-3 * untold.now.deformation_deviation_m[0]);
}

TEST(Orders, a_length_that_no_spindle_can_have_is_refused_and_stands_in_no_history) {
  const rom::Network network = tests::small_network();
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (const Displacement& length :
       {Displacement{0, 1e3, 1e-7}, Displacement{0, -0.011, 1e-6}, Displacement{0, 3e-5, 1e-6},
        Displacement{0, 1e-6, 0.0}, Displacement{0, none, 1e-6}}) {
    CyclePlan plan = estimated();
    plan.output_limit_m[0] = 1e-5;
    Cycle cycle(network, plan, runtime), untold(network, plan, runtime);
    PlcCommand command;
    Machine machine(network, 1.0);
    for (int n = 0; n < 60; ++n) {
      if (n == 20) command.displacements = 1, command.displacement = length;
      const Snapshot& now = cycle.step(machine.frame(at_s(n)), command, at_s(n), 0);
      const Snapshot& alone = untold.step(machine.frame(at_s(n)), {}, at_s(n), 0);
      EXPECT_EQ(now.displacement_orders, 0U);
      EXPECT_EQ(now.deformation_deviation_m[0], alone.deformation_deviation_m[0]);
      if (n == 20) {
        EXPECT_EQ(result_of(cycle, OrderKind::length), OrderResult::refused) << length.value_m;
      }
      machine.advance(1.0);
    }
  }
}

TEST(Orders, an_acknowledgement_takes_a_loss_back_and_is_counted_on_from_runs_before) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  StandingOrders orders;
  orders.lost = true;
  orders.acknowledgements = 7;
  cycle.stand_by_orders(orders);
  PlcCommand command;
  EXPECT_EQ(cycle.step({}, command, at_s(0), 0).fault, bits(Fault::orders_lost));
  EXPECT_EQ(result_of(cycle, OrderKind::acknowledge), OrderResult::none);
  EXPECT_TRUE(cycle.standing_orders().lost);
  EXPECT_EQ(cycle.standing_orders().acknowledgements, 7U);
  command.acknowledgements = 1;
  EXPECT_EQ(cycle.step({}, command, at_s(1), 0).fault, 0);
  EXPECT_EQ(result_of(cycle, OrderKind::acknowledge), OrderResult::done);
  EXPECT_FALSE(cycle.standing_orders().lost);
  EXPECT_EQ(cycle.standing_orders().acknowledgements, 8U);
  cycle.step({}, command, at_s(2), 0);
  EXPECT_EQ(result_of(cycle, OrderKind::acknowledge), OrderResult::none);
  EXPECT_EQ(cycle.standing_orders().acknowledgements, 8U);
}

TEST(Orders, what_stands_goes_from_one_run_to_the_next_unchanged) {
  const rom::Network network = tests::small_network();
  StandingOrders orders;
  orders.correction = SwitchOrder::off;
  orders.compensation = SwitchOrder::on;
  orders.tare_m = -4e-6;
  orders.sensor_tares = 3;
  orders.acknowledgements = 2;
  orders.lost = true;
  for (std::size_t k = 0; k < 3; ++k) {
    orders.sensor_tare_K[k] = 0.1 * static_cast<double>(k + 1);
    orders.sensor_tare_deviation_K[k] = 0.01 * static_cast<double>(k + 1);
  }
  for (const CyclePlan& plan : {estimated(), open_loop()}) {
    Cycle cycle(network, plan, runtime);
    cycle.identify(std::string(64, 'c'));
    cycle.stand_by_orders(orders);
    const StandingOrders stands = cycle.standing_orders();
    EXPECT_EQ(stands.correction, orders.correction);
    EXPECT_EQ(stands.compensation, orders.compensation);
    EXPECT_EQ(stands.tare_m, orders.tare_m);
    EXPECT_EQ(stands.sensor_tares, orders.sensor_tares);
    EXPECT_EQ(stands.sensor_tare_K, orders.sensor_tare_K);
    EXPECT_EQ(stands.sensor_tare_deviation_K, orders.sensor_tare_deviation_K);
    EXPECT_EQ(stands.acknowledgements, orders.acknowledgements);
    EXPECT_EQ(stands.lost, orders.lost);
    EXPECT_EQ(std::string(stands.network_sha256.begin(), stands.network_sha256.end()), std::string(64, 'c'));
  }
}

/// The control has followed the nose to where it was: what is shown of it is no step behind a restart.
TEST(Orders, a_standing_tare_beside_a_resumed_cycle_counts_from_its_first_step_on_without_a_step) {
  const rom::Network network = tests::small_network();
  Cycle before(network, open_loop(), runtime);
  for (int n = 0; n < 600; ++n) before.step({}, {}, at_s(n), 0);
  Remembered remembered;
  before.remember(remembered);
  const double tare_m = 5e-6, nose_m = before.step({}, {}, at_s(600), 0).deformation_m[0] - tare_m;
  ASSERT_GT(std::abs(nose_m), 1e-6);
  CyclePlan slow = open_loop();
  slow.slew_m_per_s = slow.compensation.slew_m_per_s = 1e-9;
  Cycle after(network, slow, runtime);
  ASSERT_EQ(after.resume(remembered, 0.0), Resumed::temperatures);
  StandingOrders orders;
  orders.tare_m = tare_m;
  after.stand_by_orders(orders);
  const Snapshot& first = after.step({}, {}, at_s(0), 0);
  EXPECT_NEAR(first.nose_m, nose_m, 2e-8);
  EXPECT_NEAR(first.compensation.value_m, nose_m, 2e-8);
}

}  // namespace cycle_cycle_orders_test
}  // namespace spindle_twin::firmware
