#include <gtest/gtest.h>

#include "firmware/keep/keeper.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace cycle_known_machine_test {

constexpr double saved_unix_s = 1.7e9;
constexpr double true_heat = 0.5;
const std::string sha256(64, 'a');

/// What a twin remembers that has followed a machine with half of the described heat for an hour.
Remembered hour_of(const rom::Network& network, const CyclePlan& plan) {
  Cycle cycle(network, plan, runtime);
  Machine machine(network, true_heat);
  for (int n = 0; n < 3600; ++n) {
    cycle.step(machine.frame(at_s(n)), {}, at_s(n), 0);
    machine.advance(1.0);
  }
  Remembered remembered;
  cycle.remember(remembered);
  return remembered;
}

/// Of the first cycle without a reading.
Snapshot first_of(Cycle& cycle) { return cycle.step({}, {}, at_s(0), 0); }

struct AfterAPause {
  AfterAPause() {
    plan.checkpoint_path = folder.file("machine.checkpoint");
    Checkpoint checkpoint;
    checkpoint.network_sha256 = sha256;
    checkpoint.saved_unix_s = saved_unix_s;
    checkpoint.remembered = hour_of(network, estimated());
    write_checkpoint(checkpoint, plan.checkpoint_path);
  }

  Resumed resume(Cycle& cycle, double pause_s, const std::string& hash = sha256) const {
    return resume_from_checkpoint(plan, look_for_checkpoint(plan), {hash, 1.0, saved_unix_s + pause_s}, cycle);
  }

  tests::TemporaryFolder folder;
  rom::Network network = tests::small_network();
  KeepPlan plan;
};

TEST(KnownMachine, is_not_forgotten_over_a_holiday) {
  const AfterAPause of;
  Cycle unknown(of.network, estimated(), runtime);
  Cycle again(of.network, estimated(), runtime);
  EXPECT_EQ(of.resume(again, 21.0 * 86400.0), Resumed::nothing) << "the temperatures are of no use any more";
  const Snapshot known = first_of(again), prior = first_of(unknown);
  EXPECT_NEAR(known.predicted_K[0], start_K, 0.05) << "a cold start";
  EXPECT_NEAR(known.heat_factor[0], true_heat, 0.15);
  EXPECT_GT(prior.heat_factor[0], 1.0);
}

TEST(KnownMachine, foretells_the_next_day_before_any_sensor_has_said_much) {
  const AfterAPause of;
  const auto worst_m = [&](bool knows) {
    Cycle cycle(of.network, estimated(), runtime);
    if (knows) of.resume(cycle, 3.0 * 86400.0);
    Machine machine(of.network, true_heat);
    double worst = 0.0;
    for (int n = 0; n < 900; ++n) {
      const Snapshot& now = cycle.step(machine.frame(at_s(n)), {}, at_s(n), 0);
      machine.advance(1.0);
      worst = std::max(worst, std::abs(now.deformation_raw_m[0] - machine.model.outputs.deformations_m[0]));
    }
    return worst;
  };
  EXPECT_LT(worst_m(true), 0.5 * worst_m(false));
}

TEST(KnownMachine, goes_over_to_another_network_of_the_same_spindle_with_other_nominal_values) {
  const AfterAPause of;
  rom::Network renewed = of.network;
  for (rom::HeatSource& source : renewed.boundaries.sources) source.nominal_W *= 2.0;
  Cycle cycle(renewed, estimated(), runtime);
  EXPECT_EQ(of.resume(cycle, 60.0, std::string(64, 'b')), Resumed::nothing);
  EXPECT_NEAR(first_of(cycle).heat_factor[0], 0.5 * true_heat, 0.08) << "the same watts";
}

TEST(KnownMachine, of_another_spindle_is_not_taken) {
  const AfterAPause of;
  rom::Network other = of.network;
  other.spindle = "large";
  Cycle cycle(other, estimated(), runtime);
  of.resume(cycle, 60.0, std::string(64, 'b'));
  EXPECT_GT(first_of(cycle).heat_factor[0], 1.0) << "of the prior";
}

std::shared_ptr<const correction::CalibratedPrior> of_a_test(const std::string& origin) {
  auto prior = std::make_shared<correction::CalibratedPrior>();
  prior->origin = origin;
  prior->names = {"heat bearing"};
  prior->mean = Eigen::VectorXd::Constant(1, -0.1);
  prior->covariance = Eigen::MatrixXd::Constant(1, 1, 0.01);
  return prior;
}

TEST(KnownMachine, gives_way_to_a_calibration_that_came_since_and_goes_with_one_that_was_revoked) {
  const rom::Network network = tests::small_network();
  CyclePlan first = estimated(), second = estimated();
  first.estimator->priors.calibrated = of_a_test("one");
  second.estimator->priors.calibrated = of_a_test("two");
  const Remembered remembered = hour_of(network, first);
  Cycle same(network, first, runtime), newer(network, second, runtime), none(network, estimated(), runtime);
  EXPECT_GT(same.begin_with_machine(remembered), 0);
  EXPECT_EQ(newer.begin_with_machine(remembered), 0);
  EXPECT_EQ(none.begin_with_machine(remembered), 0);
}

TEST(KnownMachine, of_which_nothing_was_kept_gives_no_parameter) {
  const rom::Network network = tests::small_network();
  Remembered remembered = hour_of(network, estimated());
  Cycle cycle(network, estimated(), runtime);
  remembered.unknowns.clear();
  EXPECT_EQ(cycle.begin_with_machine(remembered), 0);
  EXPECT_GT(first_of(cycle).heat_factor[0], 1.0) << "of the prior";
}

TEST(KnownMachine, is_wider_by_what_may_have_changed_meanwhile) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  const Remembered remembered = hour_of(network, plan);
  const auto heat_deviation = [&](double drift) {
    plan.drift.heat = drift;
    Cycle cycle(network, plan, runtime);
    EXPECT_GT(cycle.begin_with_machine(remembered), 0);
    cycle.step({}, {}, at_s(0), 0);
    Remembered now;
    cycle.remember(now);
    return now.parameters[0].deviation;
  };
  const double at_once = heat_deviation(0.0), later = heat_deviation(0.2);
  EXPECT_NEAR(later * later, at_once * at_once + 0.04, 1e-9);
}

TEST(KnownMachine, written_before_names_were_kept_says_nothing) {
  const rom::Network network = tests::small_network();
  Remembered remembered = hour_of(network, estimated());
  EXPECT_TRUE(known_of_machine(remembered));
  Remembered before = remembered;
  before.unknowns.clear();
  EXPECT_FALSE(known_of_machine(before));
  before = remembered;
  before.estimator.scale.clear();
  EXPECT_FALSE(known_of_machine(before));
  before = remembered;
  before.estimator.nominal[0] = not_a_value;
  EXPECT_FALSE(known_of_machine(before));
}

/// A checkpoint's value is filled by one cycle after another when a network was exchanged.
TEST(KnownMachine, is_remembered_with_the_nominal_values_of_the_network_that_runs_now) {
  const rom::Network network = tests::small_network();
  rom::Network renewed = network;
  for (rom::HeatSource& source : renewed.boundaries.sources) source.nominal_W *= 2.0;
  Cycle before(network, estimated(), runtime), after(renewed, estimated(), runtime);
  Remembered remembered;
  for (Cycle* cycle : {&before, &after}) {
    first_of(*cycle);
    cycle->remember(remembered);
  }
  const std::optional<correction::KnownParameters> known = known_of_machine(remembered);
  ASSERT_TRUE(known);
  ASSERT_EQ(known->names[0], "heat " + renewed.boundaries.sources[0].name);
  EXPECT_EQ(known->nominal[0], renewed.boundaries.sources[0].nominal_W);
}

}  // namespace cycle_known_machine_test
}  // namespace spindle_twin::firmware
