#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/firmware/support/machine.hpp"

/// What a cycle takes from another one of the same spindle, and how the tare goes over without a step.
namespace spindle_twin::firmware {
namespace cycle_beside_test {

constexpr double warm_K = 310.15;
constexpr double most_m = 1e-8;  ///< of the slew, in a cycle

/// At rest and as warm as its surroundings, so that only an exchange moves what is published.
CyclePlan at_rest_and_warm() {
  CyclePlan plan = open_loop();
  plan.signals[0].value = plan.signals[1].value = 0.0;
  plan.signals[2].value = plan.signals[3].value = warm_K;
  plan.start_temperature_K = warm_K;
  plan.slew_m_per_s = most_m;
  return plan;
}

/// Grows so many times as much with each kelvin.
rom::Network longer(double times) {
  rom::Network network = tests::small_network();
  network.deformations.resize(1);
  network.certificate.deformations_m.resize(1);
  network.deformations[0].row_m_per_K *= times;
  return network;
}

double nose_m(const rom::Network& network) {
  return network.deformations[0].row_m_per_K.sum() * (warm_K - network.boundaries.reference_temperature_K);
}

/// A twin of one network, and what it is told.
struct Told {
  explicit Told(double times) : network(longer(times)), cycle(network, at_rest_and_warm(), runtime) {}
  const Snapshot& step() { return last = cycle.step({}, command, at_s(n++), 0); }
  void take_tare() {
    command.tare_order = TareOrder::take;
    ++command.tare_orders;
    step();
  }
  void clear_tare() {
    command.tare_order = TareOrder::clear;
    ++command.tare_orders;
    step();
  }
  rom::Network network;
  Cycle cycle;
  PlcCommand command;
  Snapshot last;
  int n = 0;
};

/// Steps until nothing moves any more, no further than the slew lets it; gives how many cycles something moved in.
int cycles_until_it_stands(Told& of, int most) {
  int moved = 0;
  for (int n = 0; n < most; ++n) {
    const Snapshot before = of.last;
    of.step();
    for (const double way_m : {of.last.nose_m - before.nose_m, of.last.deformation_m[0] - before.deformation_m[0],
                               of.last.tare_m - before.tare_m}) {
      EXPECT_LE(std::abs(way_m), most_m * (1.0 + 1e-6)) << n;
      if (std::abs(way_m) > 1e-6 * most_m) moved = n + 1;
    }
  }
  return moved;
}

/// `of` as it is shown from now on: no step yet has been published.
void take_over(Told& of, const Told& shown, Cycle::TareOf tare_of) {
  of.cycle.take_over(shown.cycle, tare_of);
  of.command = shown.command;
  of.n = shown.n;
  of.last = shown.last;
}

TEST(TakeOver, the_growth_since_a_tare_stays_what_was_shown_while_deformation_and_tare_go_over) {
  for (const double times : {1.25, 0.75}) {
    Told old_one(1.0), new_one(times);
    old_one.step();
    old_one.take_tare();
    new_one.step();
    new_one.cycle.begin_beside(old_one.cycle);
    new_one.step();
    take_over(new_one, old_one, Cycle::TareOf::other);
    const double tare_m = nose_m(old_one.network), wanted_m = times * tare_m;
    EXPECT_NEAR(new_one.cycle.standing_orders().tare_m, wanted_m, 1e-15) << "with what is to come";
    Remembered remembered;
    new_one.cycle.remember(remembered);
    EXPECT_NEAR(remembered.tare_m, wanted_m, 1e-15);
    const int cycles = cycles_until_it_stands(new_one, 1500);
    EXPECT_NEAR(cycles, std::abs(wanted_m - tare_m) / most_m, 1.0);
    EXPECT_NEAR(new_one.last.tare_m, wanted_m, 1e-15);
    EXPECT_NEAR(new_one.last.deformation_m[0], wanted_m, 1e-15);
    EXPECT_NEAR(new_one.last.nose_m, 0.0, 1e-15);
    EXPECT_EQ(new_one.cycle.standing_orders().tare_m, new_one.last.tare_m) << "it has all come";
  }
}

TEST(TakeOver, an_own_tare_comes_back_no_faster_than_the_slew_lets_the_nose_less_the_tare_move) {
  struct Case {
    double times;
    bool shown_is_tared, own_is_tared;
  };
  for (const Case& of : {Case{1.25, true, false}, {0.75, true, false}, {1.25, false, true}, {0.75, false, true}}) {
    SCOPED_TRACE(of.times);
    Told shown(1.0), own(of.times);
    for (Told* each : {&shown, &own}) each->step();
    if (of.shown_is_tared) shown.take_tare();
    if (of.own_is_tared) own.take_tare();
    take_over(own, shown, Cycle::TareOf::itself);
    const double shown_m = nose_m(shown.network), own_m = of.times * shown_m;
    const double from_m = of.shown_is_tared ? 0.0 : shown_m;  // of the nose less the tare
    const double to_m = of.own_is_tared ? 0.0 : own_m;
    EXPECT_NEAR(own.cycle.standing_orders().tare_m, of.own_is_tared ? own_m : 0.0, 1e-15);
    const double tare_way_m = (of.own_is_tared ? own_m : 0.0) - (of.shown_is_tared ? shown_m : 0.0);
    // The longest of the three ways is gone at the slew limit all the time.
    const double way_m = std::max({std::abs(to_m - from_m), std::abs(own_m - shown_m), std::abs(tare_way_m)});
    EXPECT_NEAR(cycles_until_it_stands(own, 4000), way_m / most_m, 2.0);
    EXPECT_NEAR(own.last.nose_m, to_m, 1e-14);
    EXPECT_NEAR(own.last.deformation_m[0], own_m, 1e-14);
    EXPECT_NEAR(own.last.tare_m, of.own_is_tared ? own_m : 0.0, 1e-14);
  }
}

TEST(TakeOver, a_tare_that_was_still_to_come_comes_with_the_next_network_too) {
  Told first(1.0), second(1.25), third(1.5);
  for (Told* each : {&first, &second, &third}) each->step();
  second.take_tare();
  take_over(second, first, Cycle::TareOf::itself);
  ASSERT_EQ(second.last.tare_m, 0.0);
  take_over(third, second, Cycle::TareOf::other);
  EXPECT_NEAR(third.cycle.standing_orders().tare_m, nose_m(third.network), 1e-15)
      << "what the second has tared, moved by what the two say apart";
}

TEST(TakeOver, twice_is_as_once) {
  Told first(1.0), second(1.25);
  for (Told* each : {&first, &second}) each->step();
  second.take_tare();
  for (int times = 0; times < 2; ++times) {
    take_over(second, first, Cycle::TareOf::itself);
    EXPECT_NEAR(second.cycle.standing_orders().tare_m, nose_m(second.network), 1e-15);
  }
}

TEST(TakeOver, without_any_tare_none_comes) {
  Told old_one(1.0), new_one(1.25);
  for (Told* each : {&old_one, &new_one}) each->step();
  take_over(new_one, old_one, Cycle::TareOf::other);
  cycles_until_it_stands(new_one, 600);
  EXPECT_EQ(new_one.last.tare_m, 0.0);
  EXPECT_EQ(new_one.last.quality & bits(Quality::tared), 0);
  EXPECT_NEAR(new_one.last.nose_m, nose_m(new_one.network), 1e-15);
}

TEST(TakeOver, an_order_while_a_tare_is_still_to_come_has_the_last_word) {
  for (const TareOrder order : {TareOrder::take, TareOrder::clear}) {
    Told old_one(1.0), new_one(1.25);
    old_one.step();
    old_one.take_tare();
    new_one.step();
    take_over(new_one, old_one, Cycle::TareOf::other);
    for (int n = 0; n < 20; ++n) new_one.step();
    if (order == TareOrder::take) {
      new_one.take_tare();
    } else {
      new_one.clear_tare();
    }
    const double wanted_m = order == TareOrder::take ? nose_m(new_one.network) : 0.0;
    EXPECT_NEAR(new_one.cycle.standing_orders().tare_m, wanted_m, 1e-15);
    for (int n = 0; n < 500; ++n) new_one.step();
    EXPECT_NEAR(new_one.last.tare_m, wanted_m, 1e-15);
  }
}

TEST(BeginBeside, goes_on_with_time_counts_tares_and_orders_that_were_obeyed) {
  Told running(1.0), beside(1.25);
  running.command.acknowledgements = running.command.sensor_orders = running.command.displacements = 1;
  running.command.sensor_order = SensorOrder::clear_tare;
  running.command.displacement = {0, 3e-6, 1e-6};
  running.command.correction = SwitchOrder::off;
  running.step();
  running.take_tare();
  StandingOrders orders;
  orders.lost = true;
  orders.acknowledgements = 4;
  orders.sensor_tare_K[1] = 0.5;
  orders.sensor_tare_deviation_K[1] = 0.01;
  orders.sensor_tares = 2;
  orders.tare_m = running.last.tare_m;
  running.cycle.stand_by_orders(orders);
  running.cycle.step({}, running.command, at_s(running.n++), 3);
  beside.cycle.begin_beside(running.cycle);
  const int now = running.n;
  const Snapshot last = running.cycle.step({}, running.command, at_s(now), 0);
  const Snapshot first = beside.cycle.step({}, running.command, at_s(now), 0);
  EXPECT_EQ(first.sequence, last.sequence);
  EXPECT_EQ(first.clock_ns, last.clock_ns);
  EXPECT_EQ(first.model_time_s, last.model_time_s);
  EXPECT_EQ(first.overruns, 3U);
  EXPECT_EQ(first.tare_m, last.tare_m);
  EXPECT_EQ(first.tare_count, 1);
  EXPECT_EQ(first.sensor_orders, 1U);
  EXPECT_EQ(first.sensor_order, SensorOrder::clear_tare);
  EXPECT_EQ(first.displacement_orders, 1U);
  EXPECT_EQ(first.displacement.value_m, 3e-6);
  EXPECT_EQ(first.sensor_tare_count, 2);
  EXPECT_NE(first.fault & bits(Fault::orders_lost), 0);
  const StandingOrders stands = beside.cycle.standing_orders();
  EXPECT_EQ(stands.acknowledgements, 4U);
  EXPECT_EQ(stands.correction, SwitchOrder::off);
  EXPECT_EQ(stands.sensor_tare_K[1], 0.5);
  for (const OrderKind kind : {OrderKind::tare, OrderKind::length, OrderKind::sensors, OrderKind::acknowledge}) {
    EXPECT_EQ(beside.cycle.order_results()[static_cast<std::size_t>(kind)], OrderResult::none) << "obeyed before";
  }
}

TEST(TakeOver, a_loss_of_orders_goes_over_and_so_does_its_end_and_no_other_fault) {
  for (const bool lost : {true, false}) {
    Told running(1.0), other(1.0);
    StandingOrders orders;
    orders.lost = lost;
    running.cycle.stand_by_orders(orders);
    orders.lost = !lost;
    other.cycle.stand_by_orders(orders);
    Troubles troubles;
    troubles.set(Fault::checkpoint_lost, true);
    running.cycle.note_troubles(troubles);
    running.step();
    other.step();
    other.cycle.take_over(running.cycle, Cycle::TareOf::other);
    other.command = running.command;
    EXPECT_EQ(other.step().fault, lost ? bits(Fault::orders_lost) : 0);
  }
}

TEST(Identify, the_number_of_a_network_is_the_first_eight_digits_of_its_hash) {
  Told of(1.0);
  of.cycle.identify("00f1a2b9" + std::string(56, 'f'));
  EXPECT_EQ(of.step().network_id, 0x00f1a2b9U);
}

}  // namespace cycle_beside_test
}  // namespace spindle_twin::firmware
