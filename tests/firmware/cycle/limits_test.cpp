#include <gtest/gtest.h>

#include <cmath>

#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "tests/firmware/support/machine.hpp"

namespace spindle_twin::firmware {
namespace cycle_limits_test {

constexpr std::size_t speed = 0, load = 1, coolant = 2, ambient = 3;

/// All four signals from the PLC, within limits; told anew each second.
struct Told {
  explicit Told(CyclePlan the_plan = plan()) : network(tests::small_network()), cycle(network, the_plan, runtime) {
    command.signals[speed].value = 6000.0;
    command.signals[load].value = 1.0;
    command.signals[coolant].value = command.signals[ambient].value = start_K;
  }
  static CyclePlan plan() {
    CyclePlan plan = open_loop();
    plan.signals[speed] = {SignalSource::plc, 0.0, -12000.0, 12000.0, 0.0};
    plan.signals[load] = {SignalSource::plc, 0.0, -3.0, 3.0, 0.0};
    plan.signals[coolant] = {SignalSource::plc, start_K, start_K - 25.0, start_K + 25.0, 0.0, 2.0};
    plan.signals[ambient] = {SignalSource::plc, start_K, start_K - 30.0, start_K + 30.0, 0.0, 0.5};
    return plan;
  }
  const Snapshot& run(int seconds) {
    for (int i = 0; i < seconds; ++i, ++n) {
      for (std::size_t s = 0; s < 4; ++s) command.signals[s].time_ns = at_s(n);
      last = cycle.step({}, command, at_s(n), 0);
    }
    return last;
  }

  rom::Network network;
  Cycle cycle;
  PlcCommand command;
  Snapshot last;
  int n = 0;
};

TEST(SignalLimits, what_no_machine_does_is_held_shown_and_does_not_move_the_nose) {
  struct Absurd {
    std::size_t signal;
    double value;
  };
  for (const Absurd& absurd : {Absurd{speed, 60000.0}, Absurd{load, 9.9}, Absurd{coolant, 523.15},
                               Absurd{ambient, 523.15}, Absurd{coolant, 273.15}, Absurd{speed, not_a_value}}) {
    SCOPED_TRACE(std::to_string(absurd.signal) + " " + std::to_string(absurd.value));
    Told good, bad;
    ASSERT_EQ(good.run(600).state, State::running);
    bad.run(600);
    bad.command.signals[absurd.signal].value = absurd.value;
    EXPECT_EQ(bad.run(600).nose_m, good.run(600).nose_m);
    EXPECT_EQ(bad.last.state, State::degraded);
    EXPECT_NE(bad.last.quality & bits(Quality::signal_held), 0);
    EXPECT_EQ(bad.last.signals_held, 1U << absurd.signal);
    EXPECT_EQ(bad.last.signals_implausible, std::isnan(absurd.value) ? 0 : 1U << absurd.signal);
  }
}

TEST(SignalLimits, a_change_is_believed_once_it_could_have_come_so_fast) {
  Told told;
  told.run(60);
  told.command.signals[coolant].value = start_K + 10.0;
  EXPECT_EQ(told.run(4).signals[coolant], start_K);
  EXPECT_EQ(told.last.signals_implausible, 1U << coolant);
  EXPECT_EQ(told.run(1).signals[coolant], start_K + 10.0) << "10 K at 2 K/s";
  EXPECT_EQ(told.last.signals_held, 0);
  EXPECT_EQ(told.last.state, State::running);
}

TEST(PlcTimeout, a_plc_that_talked_and_is_silent_is_no_longer_believed) {
  CyclePlan plan = Told::plan();
  plan.plc_timeout_s = 10.0;
  Told told(plan);
  EXPECT_EQ(told.run(60).state, State::running) << "it writes on change only, nobody ever heard it talk";
  told.command.alive_ns.fill(at_s(told.n));
  EXPECT_EQ(told.run(11).state, State::running);
  EXPECT_EQ(told.run(1).state, State::degraded);
  EXPECT_EQ(told.last.signals_held, 15U);
  EXPECT_EQ(told.last.signals_implausible, 0U);
  told.command.alive_ns.fill(at_s(told.n));
  EXPECT_EQ(told.run(1).state, State::running);
}

TEST(OutputLimits, a_published_deformation_stays_within_its_limit_and_the_fault_says_so) {
  CyclePlan plan = Told::plan();
  plan.output_limit_m[0] = 2e-6;
  Told told(plan);
  double most_m = 0.0;
  for (int n = 0; n < 3600; ++n) most_m = std::max(most_m, std::abs(told.run(1).nose_m));
  ASSERT_GT(told.last.deformation_raw_m[0], 3e-6);
  EXPECT_DOUBLE_EQ(most_m, 2e-6);
  EXPECT_EQ(told.last.outputs_clamped, 1U);
  EXPECT_NE(told.last.fault & bits(Fault::output_clamped), 0);
  EXPECT_EQ(told.last.state, State::degraded);
  ++told.command.tare_orders;
  told.run(1);
  EXPECT_DOUBLE_EQ(told.last.tare_m, 2e-6) << "a tare beyond the limit would carry the rest into the next prediction";
  EXPECT_EQ(told.last.nose_m, 0.0);
  told.command.signals[speed].value = told.command.signals[load].value = 0.0;
  told.run(36000);
  EXPECT_EQ(told.last.fault & bits(Fault::output_clamped), 0) << "it is back";
  EXPECT_EQ(told.last.state, State::running);
}

TEST(Saturated, a_clipped_prediction_is_no_running_one) {
  Snapshot snapshot;
  snapshot.state = State::running;
  RegisterImage image{};
  fill_image(snapshot, 0, image);
  EXPECT_EQ(get(image, Register::state), bits(State::running));
  snapshot.nose_m = 0.339;
  fill_image(snapshot, 0, image);
  EXPECT_EQ(get(image, Register::state), bits(State::degraded));
  snapshot.nose_m = 0.0;
  snapshot.signals[speed] = 80000.0;
  fill_image(snapshot, 0, image);
  EXPECT_EQ(get(image, Register::state), bits(State::running)) << "a fast spindle is none either";
}

TEST(Sequence, goes_on_beyond_32_bits_and_the_clock_with_it) {
  Snapshot snapshot;
  RegisterImage image{};
  snapshot.sequence = 0xFFFFFFFFULL;
  fill_image(snapshot, 0, image);
  EXPECT_EQ(get(image, Register::sequence), 0.0);
  snapshot.sequence = 0x1'0000'0004ULL;
  fill_image(snapshot, 0, image);
  EXPECT_EQ(get(image, Register::sequence), 5.0);
  EXPECT_EQ(get(image, Register::service_sequence), 5.0);
}

}  // namespace cycle_limits_test
}  // namespace spindle_twin::firmware
