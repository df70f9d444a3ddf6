#include "firmware/cycle/order_desk.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <utility>

#include "tests/firmware/support/machine.hpp"

namespace spindle_twin::firmware {
namespace cycle_order_desk_test {

Order order(OrderKind kind, std::uint16_t code, std::uint16_t id = 0) { return {kind, id, code, {}}; }

/// A cycle that orders reach through the desk; the disk obeys when told.
struct Desked {
  explicit Desked(const CyclePlan& plan = open_loop())
      : network(tests::small_network()), cycle(network, plan, runtime) {}

  const Snapshot& step() {
    desk.hand_out(command);
    last = cycle.step({}, command, at_s(n), 0);
    ++n;
    desk.settle(cycle.order_results(), cycle.standing_orders(), last);
    return last;
  }
  OrderResult result(std::size_t newest) const { return last.last_orders[newest].result; }

  rom::Network network;
  Cycle cycle;
  OrderDesk desk;
  PlcCommand command;
  Snapshot last;
  int n = 0;
};

TEST(OrderDesk, every_order_of_one_cycle_is_obeyed_in_its_order_and_gets_its_own_result) {
  Desked run;
  for (int n = 0; n < 600; ++n) run.step();
  const double grown_m = run.last.nose_m;
  ASSERT_GT(grown_m, 1e-6);
  run.desk.give(order(OrderKind::tare, 1, 11));
  run.desk.give(order(OrderKind::tare, 2, 12));
  run.desk.give(order(OrderKind::tare, 7, 13));
  run.desk.give(order(OrderKind::tare, 1, 14));
  for (int n = 0; n < 4; ++n) run.step();
  EXPECT_EQ(run.last.orders, 4U);
  EXPECT_EQ(run.last.tare_count, 3);
  EXPECT_NEAR(run.last.tare_m, grown_m, 1e-7);
  run.desk.note_kept(3);
  run.step();
  const std::array<std::uint16_t, 4> ids{14, 13, 12, 11};
  const std::array<OrderResult, 4> results{OrderResult::done, OrderResult::unknown, OrderResult::done,
                                           OrderResult::done};
  for (std::size_t i = 0; i < ids.size(); ++i) {
    EXPECT_EQ(run.last.last_orders[i].id, ids[i]) << i;
    EXPECT_EQ(run.result(i), results[i]) << i;
  }
}

TEST(OrderDesk, an_order_is_done_only_when_it_is_on_the_disk) {
  Desked run;
  run.step();
  run.desk.give(order(OrderKind::tare, 1));
  run.step();
  EXPECT_NE(run.last.tare_m, 0.0) << "it holds at once";
  EXPECT_EQ(run.result(0), OrderResult::waiting);
  StandingOrders standing;
  ASSERT_TRUE(run.desk.standing().read(standing));
  EXPECT_EQ(standing.tare_m, run.last.tare_m);
  run.desk.note_not_kept(standing.revision);
  run.step();
  EXPECT_EQ(run.result(0), OrderResult::not_kept);
  run.desk.note_kept(standing.revision);
  run.step();
  EXPECT_EQ(run.result(0), OrderResult::done);
}

TEST(OrderDesk, what_cannot_be_obeyed_is_refused_and_says_so) {
  Desked run;
  run.step();
  for (const OrderKind kind : {OrderKind::correction, OrderKind::length, OrderKind::sensors}) {
    run.desk.give(order(kind, 1));
    run.step();
    EXPECT_EQ(run.last.last_orders[0].kind, kind);
    EXPECT_EQ(run.result(0), OrderResult::refused) << "there is neither law nor rest";
  }
}

TEST(OrderDesk, before_the_prediction_begins_orders_wait_in_their_order) {
  CyclePlan plan = with_sensors();
  plan.start_temperature_K.reset();
  Desked run(plan);
  run.desk.give(order(OrderKind::tare, 1, 1));
  run.desk.give(order(OrderKind::tare, 2, 2));
  for (int n = 0; n < 3; ++n) run.step();
  EXPECT_EQ(run.last.orders, 1U);
  EXPECT_EQ(run.result(0), OrderResult::waiting);
  DeviceFrame frame;
  frame.connected = true;
  for (std::size_t k = 0; k < 3; ++k) frame.sensors[k] = {start_K + 5.0, at_s(run.n)};
  for (int n = 0; n < 3; ++n) {
    run.desk.hand_out(run.command);
    run.last = run.cycle.step(frame, run.command, at_s(run.n), 0);
    run.desk.settle(run.cycle.order_results(), run.cycle.standing_orders(), run.last);
  }
  EXPECT_EQ(run.last.tare_count, 2);
  EXPECT_EQ(run.last.tare_m, 0.0) << "cleared last";
}

TEST(OrderDesk, a_trial_is_done_without_the_disk_and_that_it_goes_on_gets_no_record) {
  Desked run;
  run.step();
  run.desk.give({OrderKind::trial, 7, trial_begins, {}, 5e-6});
  run.step();
  EXPECT_EQ(run.result(0), OrderResult::done);
  EXPECT_EQ(run.last.last_orders[0].id, 7);
  run.desk.give({OrderKind::trial, 0, trial_goes_on, {}});
  run.step();
  EXPECT_EQ(run.last.orders, 1U);
  EXPECT_GT(run.last.compensation.trial_left_s, 0.0);
  run.desk.give({OrderKind::trial, 8, trial_ends, {}});
  run.desk.give({OrderKind::trial, 9, 4, {}});
  for (int n = 0; n < 30; ++n) run.step();
  EXPECT_EQ(run.result(0), OrderResult::unknown);
  EXPECT_EQ(run.result(1), OrderResult::done);
  EXPECT_TRUE(std::isnan(run.last.compensation.trial_left_s));
  StandingOrders standing;
  EXPECT_FALSE(run.desk.standing().read(standing)) << "nothing of it outlives a restart";
}

/// What has no meaning is said to have none, and changes nothing.
TEST(OrderDesk, each_kind_knows_its_own_codes) {
  struct Known {
    OrderKind kind;
    std::uint16_t least, most;
  };
  for (const Known& of : {Known{OrderKind::tare, 1, 2}, Known{OrderKind::sensors, 1, 3}, Known{OrderKind::trial, 1, 3},
                          Known{OrderKind::length, 1, 1}, Known{OrderKind::acknowledge, 1, 1}}) {
    for (std::uint16_t code = 0; code <= 5; ++code) {
      if (of.kind == OrderKind::trial && code == trial_goes_on) continue;  // it is no order
      OrderDesk desk;
      PlcCommand command;
      Snapshot snapshot;
      desk.give(order(of.kind, code, 5));
      desk.hand_out(command);
      OrderResults none{};
      none.fill(OrderResult::refused);
      desk.settle(none, {}, snapshot);
      const bool known = code >= of.least && code <= of.most;
      EXPECT_EQ(snapshot.last_orders[0].result, known ? OrderResult::refused : OrderResult::unknown)
          << static_cast<int>(of.kind) << " " << code;
      const std::uint32_t handed = command.tare_orders + command.sensor_orders + command.trial.orders +
                                   command.displacements + command.acknowledgements;
      EXPECT_EQ(handed, known ? 1U : 0U);
      EXPECT_EQ(snapshot.orders, 1U);
      EXPECT_EQ(snapshot.last_orders[0].number, 1U);
      EXPECT_EQ(snapshot.last_orders[1].number, 0U) << "there was none before";
      EXPECT_EQ(snapshot.last_orders[1].result, OrderResult::none);
    }
  }
}

TEST(OrderDesk, a_switch_is_off_on_or_as_configured_and_nothing_else) {
  for (const OrderKind kind : {OrderKind::correction, OrderKind::compensation}) {
    for (const int code : {0, 1, 2, 7, 65534, 65535}) {
      OrderDesk desk;
      PlcCommand command;
      Snapshot snapshot;
      desk.give(order(kind, static_cast<std::uint16_t>(code)));
      desk.hand_out(command);
      OrderResults refused{};
      refused.fill(OrderResult::refused);
      desk.settle(refused, {}, snapshot);
      const bool known = code <= 1 || code == 65535;
      EXPECT_EQ(snapshot.last_orders[0].result, known ? OrderResult::refused : OrderResult::unknown) << code;
      if (!known) {
        EXPECT_EQ(command.correction, SwitchOrder::as_configured);
        EXPECT_EQ(command.compensation, SwitchOrder::as_configured);
      }
    }
  }
}

TEST(OrderDesk, what_waits_holds_up_only_its_own_kind) {
  CyclePlan plan = with_sensors();
  plan.start_temperature_K.reset();
  Desked run(plan);
  run.desk.give(order(OrderKind::tare, 1, 1));
  run.desk.give(order(OrderKind::compensation, 0, 2));
  run.desk.give(order(OrderKind::acknowledge, 1, 3));
  for (int n = 0; n < 3; ++n) run.step();
  EXPECT_EQ(run.last.orders, 3U);
  EXPECT_EQ(run.cycle.standing_orders().compensation, SwitchOrder::off) << "at once, before there is a prediction";
  EXPECT_EQ(run.last.tare_count, 0);
}

/// The desk alone: the first of three lengths waits for an update of the estimator.
TEST(OrderDesk, switches_overtake_lengths_that_wait_and_tares_do_not) {
  OrderDesk desk;
  PlcCommand command;
  Snapshot snapshot;
  OrderResults results{};
  for (int n = 0; n < 3; ++n) desk.give(order(OrderKind::length, 1));
  desk.give(order(OrderKind::compensation, 0));
  desk.give(order(OrderKind::tare, 1));
  desk.give(order(OrderKind::trial, trial_ends));
  desk.give(order(OrderKind::acknowledge, 1));
  const auto cycle = [&](OrderResult length) {
    desk.hand_out(command);
    results.fill(OrderResult::done);
    results[static_cast<std::size_t>(OrderKind::length)] = length;
    desk.settle(results, {}, snapshot);
  };
  cycle(OrderResult::waiting);
  EXPECT_EQ(command.displacements, 1U);
  EXPECT_EQ(command.compensation, SwitchOrder::off);
  EXPECT_EQ(command.trial.orders, 1U);
  cycle(OrderResult::waiting);
  EXPECT_EQ(command.acknowledgements, 1U) << "of an earlier kind than the end of a trial: a cycle later";
  EXPECT_EQ(command.displacements, 1U);
  EXPECT_EQ(command.tare_orders, 0U);
  for (std::uint32_t n = 2; n <= 3; ++n) {
    cycle(OrderResult::done);
    cycle(OrderResult::waiting);
    EXPECT_EQ(command.displacements, n);
    EXPECT_EQ(command.tare_orders, n == 3 ? 1U : 0U) << "the zero that they were measured from is theirs";
  }
}

TEST(OrderDesk, codes_mean_what_the_registers_say) {
  const auto command_of = [](OrderKind kind, std::uint16_t code) {
    OrderDesk desk;
    PlcCommand command;
    Order given = order(kind, code);
    given.trial_m = 3e-6;
    desk.give(given);
    desk.hand_out(command);
    return command;
  };
  for (const auto& [code, wanted] : {std::pair<std::uint16_t, SwitchOrder>{0, SwitchOrder::off},
                                     {1, SwitchOrder::on},
                                     {not_present_code, SwitchOrder::as_configured}}) {
    EXPECT_EQ(command_of(OrderKind::correction, code).correction, wanted);
    EXPECT_EQ(command_of(OrderKind::correction, code).compensation, SwitchOrder::as_configured);
    EXPECT_EQ(command_of(OrderKind::compensation, code).compensation, wanted);
  }
  EXPECT_EQ(command_of(OrderKind::sensors, 1).sensor_order, SensorOrder::tare);
  EXPECT_EQ(command_of(OrderKind::sensors, 2).sensor_order, SensorOrder::clear_tare);
  EXPECT_EQ(command_of(OrderKind::sensors, 3).sensor_order, SensorOrder::acknowledge);
  EXPECT_EQ(command_of(OrderKind::tare, 1).tare_order, TareOrder::take);
  EXPECT_EQ(command_of(OrderKind::tare, 2).tare_order, TareOrder::clear);
  EXPECT_EQ(command_of(OrderKind::trial, trial_begins).trial.value_m, 3e-6);
  EXPECT_TRUE(std::isnan(command_of(OrderKind::trial, trial_ends).trial.value_m));
}

/// Each order that is done raises the revision by one, on from the run before, and is kept with it or a later one.
TEST(OrderDesk, revisions_go_on_from_the_run_before_and_tell_what_is_on_the_disk) {
  OrderDesk desk;
  StandingOrders before;
  before.revision = 7;
  desk.begin_with(before);
  PlcCommand command;
  Snapshot snapshot;
  OrderResults done{};
  done.fill(OrderResult::done);
  StandingOrders now;
  const auto settle = [&] { desk.settle(done, before, snapshot); };
  for (std::uint32_t n = 1; n <= 2; ++n) {
    desk.give(order(OrderKind::tare, 1));
    desk.hand_out(command);
    settle();
    ASSERT_TRUE(desk.standing().read(now));
    EXPECT_EQ(now.revision, 7 + n);
    EXPECT_EQ(snapshot.last_orders[0].result, OrderResult::waiting);
  }
  desk.note_kept(8);
  settle();
  EXPECT_EQ(snapshot.last_orders[1].result, OrderResult::done);
  EXPECT_EQ(snapshot.last_orders[0].result, OrderResult::waiting);
  desk.note_not_kept(9);
  settle();
  EXPECT_EQ(snapshot.last_orders[1].result, OrderResult::done) << "it is there";
  EXPECT_EQ(snapshot.last_orders[0].result, OrderResult::not_kept);
  EXPECT_FALSE(desk.standing().read(now)) << "nothing new stands";
  desk.renew(before);
  ASSERT_TRUE(desk.standing().read(now));
  EXPECT_EQ(now.revision, 9U);
  desk.note_kept(9);
  settle();
  EXPECT_EQ(snapshot.last_orders[0].result, OrderResult::done);
}

TEST(OrderDesk, a_full_queue_takes_no_more) {
  OrderDesk desk;
  for (std::size_t i = 0; i < OrderDesk::room; ++i) {
    EXPECT_TRUE(desk.has_room_for(1));
    desk.give(order(OrderKind::tare, 1));
  }
  EXPECT_FALSE(desk.has_room_for(1));
}

TEST(OrderDesk, the_switch_of_a_run_before_holds_until_another_order) {
  OrderDesk desk;
  StandingOrders standing;
  standing.correction = SwitchOrder::off;
  desk.begin_with(standing);
  EXPECT_EQ(desk.first_command().correction, SwitchOrder::off);
}

TEST(StandBy, orders_of_a_run_before_hold_from_the_first_cycle_on_and_a_loss_stays_until_acknowledged) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, estimated(), runtime);
  StandingOrders standing;
  standing.tare_m = 3e-6;
  standing.sensor_tares = 2;
  standing.sensor_tare_K[1] = 0.4;
  standing.lost = true;
  cycle.stand_by_orders(standing);
  DeviceFrame frame;
  frame.connected = true;
  for (std::size_t k = 0; k < 3; ++k) frame.sensors[k] = {start_K, at_s(0)};
  PlcCommand command;
  Snapshot last = cycle.step(frame, command, at_s(0), 0);
  EXPECT_NEAR(last.nose_m, last.deformation_m[0] - 3e-6, 1e-12);
  EXPECT_NEAR(last.measured_K[1], start_K - 0.4, 1e-9);
  EXPECT_EQ(last.sensor_tare_count, 2);
  EXPECT_NE(last.fault & bits(Fault::orders_lost), 0);
  EXPECT_EQ(last.state, State::degraded);
  ++command.acknowledgements;
  last = cycle.step(frame, command, at_s(1), 0);
  EXPECT_EQ(last.fault & bits(Fault::orders_lost), 0);
  EXPECT_FALSE(cycle.standing_orders().lost);
  EXPECT_EQ(cycle.standing_orders().tare_m, 3e-6);
}

}  // namespace cycle_order_desk_test
}  // namespace spindle_twin::firmware
