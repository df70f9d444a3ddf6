#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <utility>
#include <vector>

#include "tests/firmware/support/machine.hpp"
#include "tests/firmware/support/recorded_steps.hpp"

/// How a cycle starts, catches up and says how it is.
namespace spindle_twin::firmware {
namespace cycle_cycle_state_test {

/// At rest in surroundings as warm as itself nothing ever moves.
CyclePlan still_at(double temperature_K) {
  CyclePlan plan = open_loop();
  plan.signals[0].value = plan.signals[1].value = 0.0;
  plan.signals[2].value = plan.signals[3].value = temperature_K;
  plan.start_temperature_K = temperature_K;
  return plan;
}

DeviceFrame frame_of(std::initializer_list<double> sensors_K, int n) {
  DeviceFrame frame;
  frame.connected = true;
  std::size_t k = 0;
  for (const double value_K : sensors_K) frame.sensors[k++] = {value_K, at_s(n)};
  return frame;
}

TEST(CatchUp, goes_through_a_gap_in_equal_steps_of_a_minute_at_most_and_in_sixty_at_most) {
  const rom::Network network = tests::small_network();
  struct Case {
    std::int64_t missed;
    std::size_t steps;
  };
  for (const Case& of :
       {Case{1, 1}, {59, 1}, {60, 1}, {61, 2}, {120, 2}, {121, 3}, {3600, 60}, {3601, 60}, {86400, 60}}) {
    RecordedSteps steps;
    Cycle cycle(network, open_loop(), steps.maker());
    cycle.step({}, {}, at_s(0), 0);
    steps.take(0);
    steps.take(1);
    const auto gap_s = static_cast<double>(of.missed);
    const Snapshot& now = cycle.step({}, {}, at_s(1), of.missed);
    EXPECT_NEAR(now.model_time_s, gap_s + 2.0, 1e-9 * gap_s);
    for (const std::size_t model : {0U, 1U}) {
      const std::vector<double> taken = steps.take(model);
      ASSERT_EQ(taken.size(), of.steps + 1) << of.missed;
      for (std::size_t n = 0; n < of.steps; ++n) EXPECT_DOUBLE_EQ(taken[n], gap_s / static_cast<double>(of.steps));
      EXPECT_EQ(taken.back(), 1.0) << "and then its own period";
    }
  }
}

TEST(CatchUp, without_a_gap_or_a_start_there_is_nothing_to_go_through) {
  const rom::Network network = tests::small_network();
  RecordedSteps steps;
  Cycle cycle(network, open_loop(), steps.maker());
  cycle.step({}, {}, at_s(0), 500);
  EXPECT_EQ(steps.take(0).size(), 1U) << "it starts now, whatever was missed before";
  cycle.step({}, {}, at_s(1), 0);
  EXPECT_EQ(steps.take(0).size(), 1U);
}

TEST(CatchUp, the_uncorrected_model_goes_through_it_only_where_it_is_compared) {
  const rom::Network network = tests::small_network();
  for (const bool compare : {true, false}) {
    RecordedSteps steps;
    CyclePlan plan = open_loop();
    plan.compare_uncorrected = compare;
    Cycle cycle(network, plan, steps.maker());
    cycle.step({}, {}, at_s(0), 0);
    cycle.step({}, {}, at_s(1), 90);
    EXPECT_EQ(steps.take(0).size(), 4U);
    EXPECT_EQ(steps.take(1).size(), compare ? 4U : 0U);
  }
}

TEST(Start, a_node_field_comes_before_a_temperature_and_that_before_the_sensors) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = still_at(310.0);
  for (SensorPlan& sensor : plan.sensors) sensor.configured = true;
  Cycle uniform(network, plan, runtime);
  EXPECT_NEAR(uniform.step(frame_of({320.0, 320.0, 320.0}, 0), {}, at_s(0), 0).predicted_K[0], 310.0, 1e-6);
  Cycle field(network, plan, runtime);
  field.start_at(Eigen::VectorXd::Constant(5, 330.0));
  EXPECT_GT(field.step(frame_of({320.0, 320.0, 320.0}, 0), {}, at_s(0), 0).predicted_K[0], 325.0);
  Cycle of_other_size(network, plan, runtime);
  of_other_size.start_at(Eigen::VectorXd::Constant(4, 330.0));
  EXPECT_NEAR(of_other_size.step({}, {}, at_s(0), 0).predicted_K[0], 310.0, 1e-6);
}

TEST(Start, is_at_the_mean_of_those_sensors_that_are_good) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = still_at(302.0);
  for (std::size_t k = 0; k < 3; ++k) plan.sensors[k].configured = true;
  plan.start_temperature_K.reset();
  Cycle all(network, plan, runtime);
  EXPECT_NEAR(all.step(frame_of({300.0, 301.0, 305.0}, 0), {}, at_s(0), 0).predicted_K[0], 302.0, 1e-6);
  plan.start_wait_s = 0.0;
  Cycle two(network, plan, runtime);
  EXPECT_NEAR(two.step(frame_of({300.0, 1000.0, 304.0}, 0), {}, at_s(0), 0).predicted_K[0], 302.0, 1e-6);
  Cycle none(network, plan, runtime);
  EXPECT_EQ(none.step(frame_of({1000.0, 1000.0, 1000.0}, 0), {}, at_s(0), 0).state, State::fault);
}

TEST(Start, waits_for_all_sensors_as_long_as_is_configured_and_not_a_cycle_longer) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = still_at(302.0);
  for (std::size_t k = 0; k < 3; ++k) plan.sensors[k].configured = true;
  plan.start_temperature_K.reset();
  plan.start_wait_s = 10.0;
  for (const std::int64_t missed : {0, 3}) {
    Cycle cycle(network, plan, runtime);
    int cycles = 0;
    double waited_s = 0.0;
    Snapshot now;
    for (; now.state != State::running && now.state != State::degraded; ++cycles) {
      ASSERT_LT(cycles, 100);
      now = cycle.step(frame_of({302.0}, cycles), {}, at_s(cycles), missed);
      if (now.state == State::degraded) break;
      waited_s += 1.0 + static_cast<double>(missed);
      EXPECT_EQ(now.state, State::starting) << "one reading is good, after " << waited_s;
      EXPECT_EQ(now.model_time_s, 0.0);
    }
    EXPECT_EQ(waited_s, missed == 0 ? 10.0 : 12.0);
    EXPECT_EQ(now.fault, 0);
    EXPECT_NEAR(now.predicted_K[0], 302.0, 1e-6);
  }
}

TEST(Cycle, counts_cycles_missed_ones_and_the_clock_from_its_first_step_on) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  Snapshot now = cycle.step({}, {}, 5'000'000'000, 3);
  EXPECT_EQ(now.sequence, 1U);
  EXPECT_EQ(now.overruns, 3U);
  EXPECT_EQ(now.clock_ns, 0);
  EXPECT_NE(now.quality & bits(Quality::overrun), 0);
  now = cycle.step({}, {}, 6'500'000'000, 0);
  EXPECT_EQ(now.sequence, 2U);
  EXPECT_EQ(now.overruns, 3U);
  EXPECT_EQ(now.clock_ns, 1'500'000'000);
  EXPECT_EQ(now.quality & bits(Quality::overrun), 0);
  now = cycle.step({}, {}, 9'500'000'000, 1);
  EXPECT_EQ(now.overruns, 4U);
  EXPECT_NE(now.quality & bits(Quality::overrun), 0) << "one is enough";
}

TEST(Cycle, foretells_the_growth_to_come_only_where_it_is_to_look_ahead) {
  rom::Network network = tests::small_network();
  for (const double ahead_s : {0.0, Forecast::stride_s}) {
    CyclePlan plan = open_loop();
    plan.forecast.ahead_s = ahead_s;
    Cycle cycle(network, plan, runtime);
    Snapshot now;
    for (int n = 0; n < 60; ++n) now = cycle.step({}, {}, at_s(n), 0);
    EXPECT_EQ(std::isfinite(now.compensation.forecast_m), ahead_s > 0.0);
  }
}

TEST(Troubles, of_others_are_shown_while_they_last_and_only_lost_orders_degrade) {
  const rom::Network network = tests::small_network();
  Cycle cycle(network, open_loop(), runtime);
  std::atomic<std::uint64_t> dropped{4};
  Troubles troubles;
  troubles.log_lines_dropped = &dropped;
  troubles.history_rows_lost = 9;
  int n = 0;
  for (const Fault fault : {Fault::history_lost, Fault::checkpoint_lost, Fault::orders_not_kept}) {
    troubles.set(fault, true);
    cycle.note_troubles(troubles);
    Snapshot now = cycle.step({}, {}, at_s(n++), 0);
    EXPECT_EQ(now.fault, bits(fault));
    EXPECT_EQ(now.state, fault == Fault::orders_not_kept ? State::degraded : State::running);
    EXPECT_EQ(now.history_rows_lost, 9U);
    EXPECT_EQ(now.log_lines_dropped, 4U);
    troubles.set(fault, false);
    cycle.note_troubles(troubles);
    now = cycle.step({}, {}, at_s(n++), 0);
    EXPECT_EQ(now.fault, 0);
    EXPECT_EQ(now.state, State::running);
  }
  troubles.set(Fault::integrator_failed, true);
  cycle.note_troubles(troubles);
  EXPECT_EQ(cycle.step({}, {}, at_s(n), 0).fault, 0) << "that is the cycle's own to say";
}

TEST(Quality, a_correction_that_waits_or_finds_nothing_to_correct_is_not_frozen) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = corrected();
  plan.paper->guards.reading_uncertainty_K = 0.01;
  plan.paper->guards.minimum_rise_K = 0.05;
  Cycle cycle(network, plan, runtime);
  Machine machine(network, 1.0);
  int waiting = 0, deadband = 0, frozen = 0;
  for (int n = 0; n < 1200; ++n) {
    const DeviceFrame frame = n < 900 ? machine.frame(at_s(n)) : DeviceFrame{};
    const Snapshot& now = cycle.step(frame, {}, at_s(n), 0);
    machine.advance(1.0);
    const bool says = (now.quality & bits(Quality::correction_frozen)) != 0;
    const auto freeze = static_cast<CorrectionFreeze>(now.correction_freeze);
    waiting += freeze == CorrectionFreeze::waiting ? 1 : 0;
    deadband += freeze == CorrectionFreeze::deadband ? 1 : 0;
    frozen += freeze == CorrectionFreeze::too_few_sensors ? 1 : 0;
    if (freeze == CorrectionFreeze::waiting || freeze == CorrectionFreeze::deadband) {
      EXPECT_FALSE(says) << n;
    } else if (freeze != CorrectionFreeze::none) {
      EXPECT_TRUE(says) << n;
    }
  }
  EXPECT_GT(waiting, 0);
  EXPECT_GT(deadband, 0);
  EXPECT_GT(frozen, 0);
}

/// Integrates, and grows hotter by 300 K at once where it is told so.
class Leaping final : public rom::Stepper {
 public:
  Leaping(std::shared_ptr<const rom::NetworkOperator> shared, const bool& leaps)
      : inner_(std::move(shared)), leaps_(leaps) {}
  void set_temperatures(const Eigen::VectorXd& temperatures_K) override { inner_.set_temperatures(temperatures_K); }
  rom::StepStatus advance(double period_s, const rom::BoundaryValues& values) override {
    const rom::StepStatus status = inner_.advance(period_s, values);
    if (leaps_) inner_.set_temperatures(inner_.temperatures_K().array() + 300.0);
    return status;
  }
  const Eigen::VectorXd& temperatures_K() const override { return inner_.temperatures_K(); }

 private:
  rom::ExactStepper inner_;
  const bool& leaps_;
};

/// What no reading allows is not shown: the uncorrected model is, and for ten minutes it is said so.
TEST(Guard, of_an_implausible_prediction_the_uncorrected_is_shown_and_a_fault_for_ten_minutes) {
  const rom::Network network = tests::small_network();
  for (CyclePlan plan : {open_loop(), corrected(), estimated()}) {
    plan.period_s = 20.0;
    bool leaps = false;
    const bool never = false;
    int made = 0;
    Cycle cycle(network, plan, [&](const rom::Network& of) {
      const auto shared = std::make_shared<const rom::NetworkOperator>(of);
      return std::make_unique<rom::FallbackStepper>(std::make_unique<Leaping>(shared, made++ == 0 ? leaps : never),
                                                    std::make_unique<rom::ExactStepper>(shared));
    });
    int n = 0;
    for (; n < 10; ++n) EXPECT_EQ(cycle.step({}, {}, at_s(20 * n), 0).fault, 0);
    leaps = true;
    const Snapshot shown = cycle.step({}, {}, at_s(20 * n++), 0);
    leaps = false;
    EXPECT_EQ(shown.fault, bits(Fault::implausible_prediction));
    EXPECT_EQ(shown.state, State::degraded);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(shown.predicted_K[k], shown.uncorrected_K[k]);
    EXPECT_EQ(shown.deformation_raw_m[0], shown.nose_uncorrected_m);
    for (int cycles = 1; cycles < 30; ++cycles) {
      ASSERT_EQ(cycle.step({}, {}, at_s(20 * n++), 0).fault, bits(Fault::implausible_prediction))
          << 20 * cycles << " s";
    }
    EXPECT_EQ(cycle.step({}, {}, at_s(20 * n++), 0).fault, 0) << "600 s behind it";
  }
}

}  // namespace cycle_cycle_state_test
}  // namespace spindle_twin::firmware
