#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "rom/integrate/exact_stepper.hpp"
#include "tests/firmware/support/exchanging.hpp"

/// How long a trial and a watch last, what is told of them, and networks that break down in them.
namespace spindle_twin::firmware {
namespace cycle_exchange_limits_test {

/// Integrates until somebody says that it is broken.
class Breakable final : public rom::Stepper {
 public:
  Breakable(std::shared_ptr<const rom::NetworkOperator> shared, const bool& is_broken)
      : inner_(std::move(shared)), is_broken_(is_broken) {}
  void set_temperatures(const Eigen::VectorXd& temperatures_K) override { inner_.set_temperatures(temperatures_K); }
  rom::StepStatus advance(double period_s, const rom::BoundaryValues& values) override {
    if (is_broken_) throw std::runtime_error("broken");
    return inner_.advance(period_s, values);
  }
  const Eigen::VectorXd& temperatures_K() const override { return inner_.temperatures_K(); }

 private:
  rom::ExactStepper inner_;
  const bool& is_broken_;
};

MakeStepper breakable(const bool& is_broken) {
  return [&is_broken](const rom::Network& network) {
    const auto shared = std::make_shared<const rom::NetworkOperator>(network);
    return std::make_unique<rom::FallbackStepper>(std::make_unique<Breakable>(shared, is_broken),
                                                  std::make_unique<rom::ExactStepper>(shared));
  };
}

constexpr double trial_s = 200.0, watch_s = 100.0;

struct Breakdowns {
  bool old_is_broken = false, new_is_broken = false;
};

/// Networks of which either may break down.
struct Swapping : Breakdowns, Exchanging {
  Swapping(double runs, double comes, const CyclePlan& plan = with_sensors(),
           const ExchangePlan& judged = {trial_s, watch_s, 0.1, 0.05})
      : Exchanging(tests::with_conductances(runs), tests::with_conductances(comes), plan, judged,
                   breakable(old_is_broken), breakable(new_is_broken)) {}
};

/// One cycle to begin with, and one more behind the time that does not count.
constexpr int beside_the_time = 2;

TEST(ExchangeLimits, a_trial_and_a_watch_last_as_long_as_is_planned_and_say_what_is_left) {
  Swapping of(1.5, 1.0);
  of.run(600);
  EXPECT_TRUE(std::isnan(of.last.exchange.left_s));
  of.offer(of.new_cycle);
  of.step();
  ASSERT_EQ(of.last.exchange.state, ExchangeState::trial);
  EXPECT_EQ(of.last.exchange.left_s, trial_s);
  double before_s = trial_s;
  for (int i = 0; i < 50; ++i, before_s = of.last.exchange.left_s) {
    EXPECT_LE(of.step().exchange.left_s, before_s);
    EXPECT_GE(of.last.exchange.left_s, before_s - 1.0);
  }
  EXPECT_LT(of.last.exchange.candidate_K, of.last.exchange.running_K);
  EXPECT_EQ(of.until(ExchangeState::watching, 1000), trial_s + beside_the_time - 51);
  EXPECT_EQ(of.last.exchange.left_s, watch_s);
  EXPECT_EQ(of.until(ExchangeState::keeping, 1000), watch_s + beside_the_time);
  EXPECT_EQ(of.last.exchange.left_s, 0.0);
  of.run(20);
  EXPECT_EQ(of.last.exchange.left_s, 0.0) << "and no less";
}

TEST(ExchangeLimits, news_name_the_errors_of_either_network_as_theirs) {
  Swapping of(1.5, 1.0);
  of.run(600);
  of.offer(of.new_cycle);
  of.until(ExchangeState::watching, 1000);
  for (const ExchangeState state : {ExchangeState::watching, ExchangeState::keeping, ExchangeState::accepted}) {
    if (state == ExchangeState::accepted) of.exchange.confirm();
    of.until(state, 1000);
    const ExchangeNews news = of.news();
    EXPECT_EQ(news.state, state);
    EXPECT_EQ(news.reason, ExchangeReason::none);
    EXPECT_LT(news.candidate_K, news.running_K) << static_cast<int>(state);
  }
  Swapping worse(1.0, 0.5);
  worse.run(600);
  worse.offer(worse.new_cycle);
  worse.until(ExchangeState::refused, 1000);
  const ExchangeNews news = worse.news();
  EXPECT_EQ(news.state, ExchangeState::refused);
  EXPECT_EQ(news.reason, ExchangeReason::worse);
  EXPECT_GT(news.candidate_K, news.running_K);
  EXPECT_EQ(worse.n, 600 + trial_s + beside_the_time) << "not before its trial is over";
}

/// What no sensor sees is guessed where a candidate begins.
TEST(ExchangeLimits, the_first_half_of_a_trial_is_the_candidates_warming_up) {
  Swapping of(1.0, 1.0, with_sensors(), {2000.0, watch_s, 0.1, 0.05});
  of.run(60);
  of.new_cycle.start_at(start_field(of.new_network, of.last).array() + 3.0);
  of.exchange.offer(of.new_cycle);
  EXPECT_EQ(of.until(ExchangeState::watching, 3000), 2000 + beside_the_time);
}

TEST(ExchangeLimits, a_candidate_that_waits_for_its_sensors_has_not_failed) {
  CyclePlan plan = with_sensors();
  plan.start_temperature_K.reset();
  Swapping of(1.0, 1.0, plan);
  of.run(60);
  of.exchange.offer(of.new_cycle);
  for (int i = 0; i < 5; ++i) of.last = of.exchange.step({}, of.command, at_s(of.n++), 0);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::trial);
}

TEST(ExchangeLimits, a_candidate_whose_estimate_is_in_doubt_beside_one_that_is_not_is_refused_for_that) {
  Swapping of(1.0, 4.0, estimated(), {300.0, watch_s, 10.0, 10.0});  // however much worse it is
  of.run(600);
  of.offer(of.new_cycle);
  EXPECT_LT(of.until(ExchangeState::refused, 3000), 3000);
  EXPECT_EQ(of.news().reason, ExchangeReason::in_doubt);
}

TEST(ExchangeLimits, behind_one_exchange_there_is_a_next_one) {
  for (const bool first_is_accepted : {true, false}) {
    Swapping of(1.5, 1.0);
    Cycle third(of.new_network, with_sensors(), runtime);
    third.identify(std::string(64, 'c'));
    of.run(600);
    of.offer(of.new_cycle);
    of.until(ExchangeState::keeping, 1000);
    if (first_is_accepted) {
      of.exchange.confirm();
    } else {
      of.exchange.withdraw();
    }
    of.until(first_is_accepted ? ExchangeState::accepted : ExchangeState::went_back, 3);
    EXPECT_EQ(of.exchange.take_kept_changed(), first_is_accepted);
    of.run(5);
    EXPECT_EQ(of.shows_new(), first_is_accepted);
    of.offer(third);
    of.until(ExchangeState::keeping, 1000);
    ASSERT_EQ(of.last.exchange.state, ExchangeState::keeping) << first_is_accepted;
    of.run(5);
    EXPECT_EQ(of.last.exchange.state, ExchangeState::keeping) << "it was not confirmed";
    of.exchange.confirm();
    of.until(ExchangeState::accepted, 3);
    EXPECT_TRUE(of.exchange.take_kept_changed());
    EXPECT_EQ(of.last.network_id, 0xccccccccU);
    EXPECT_TRUE(std::isnan(of.last.exchange.left_s)) << "there is nothing to wait for";
    EXPECT_TRUE(std::isnan(of.last.exchange.candidate_K));
  }
}

TEST(ExchangeLimits, one_that_does_worse_behind_its_trial_goes_back_once_the_watch_has_settled) {
  CyclePlan plan = with_sensors();
  plan.signals[0] = {SignalSource::plc, 0.0, 0.0, 1e5, 0.0};
  Swapping of(1.0, 1.0, plan);
  for (rom::HeatSource& source : of.new_network.boundaries.sources) source.nominal_W *= 8.0;
  Cycle hot(of.new_network, plan, runtime);
  hot.identify(std::string(64, 'b'));
  of.machine.operating.speed_rpm = of.machine.operating.load = 0.0;
  of.command.signals[0] = {0.0, 1};
  of.run(100);
  of.offer(hot);
  of.until(ExchangeState::watching, 1000);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::watching);
  of.machine.operating = of.machine.network.boundaries.operating;
  of.command.signals[0] = {6000.0, 2};
  const int steps = of.until(ExchangeState::went_back, 1000);
  EXPECT_GT(steps, 0.1 * watch_s) << "a few readings judge nothing";
  EXPECT_LT(steps, 0.2 * watch_s);
  EXPECT_EQ(of.news().reason, ExchangeReason::worse);
}

TEST(ExchangeLimits, a_candidate_that_breaks_down_is_refused_or_given_up_and_the_old_one_goes_on) {
  for (const bool in_trial : {true, false}) {
    Swapping of(1.0, 1.0);
    of.run(60);
    of.offer(of.new_cycle);
    of.until(in_trial ? ExchangeState::trial : ExchangeState::watching, 1000);
    of.run(5);
    EXPECT_EQ(of.shows_new(), !in_trial);
    of.new_is_broken = true;
    of.run(2);
    EXPECT_EQ(of.last.exchange.state, in_trial ? ExchangeState::refused : ExchangeState::went_back);
    EXPECT_EQ(of.news().reason, ExchangeReason::failed);
    EXPECT_FALSE(of.shows_new());
    of.run(100);
    EXPECT_EQ(of.last.state, State::running);
    EXPECT_NEAR(of.last.deformation_m[0], of.machine.model.outputs.deformations_m[0], 1e-7);
  }
}

TEST(ExchangeLimits, of_the_old_one_breaking_down_a_trial_saves_nobody_and_a_watch_goes_on) {
  Swapping trial(1.0, 1.0);
  trial.run(60);
  trial.offer(trial.new_cycle);
  trial.run(5);
  trial.old_is_broken = true;
  EXPECT_THROW(trial.step(), std::runtime_error);
  Swapping watch(1.0, 1.0);
  watch.run(60);
  watch.offer(watch.new_cycle);
  watch.until(ExchangeState::watching, 1000);
  watch.old_is_broken = true;
  watch.run(30);
  EXPECT_EQ(watch.last.exchange.state, ExchangeState::watching);
  EXPECT_TRUE(watch.shows_new());
  EXPECT_EQ(watch.last.state, State::running);
}

TEST(ExchangeLimits, a_file_that_no_cycle_has_run_is_told_as_refused_once) {
  Swapping of(1.0, 1.0);
  of.run(3);
  of.exchange.note_refused();
  of.step();
  EXPECT_EQ(of.last.exchange.state, ExchangeState::refused);
  EXPECT_FALSE(of.shows_new());
  of.offer(of.new_cycle);
  of.run(3);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::trial);
}

TEST(ExchangeLimits, a_file_refused_just_before_or_beside_a_candidate_leaves_it_on_trial) {
  Swapping before(1.0, 1.0);
  before.run(3);
  before.exchange.note_refused();
  before.offer(before.new_cycle);
  before.step();
  EXPECT_EQ(before.last.exchange.state, ExchangeState::trial);
  before.exchange.note_refused();
  before.step();
  EXPECT_EQ(before.last.exchange.state, ExchangeState::trial);
  before.run(60);
  EXPECT_EQ(before.last.exchange.state, ExchangeState::trial) << "judged as one that is on trial";
  EXPECT_FALSE(before.shows_new());
}

TEST(ExchangeLimits, both_are_told_of_troubles) {
  Troubles troubles;
  Swapping of(1.0, 1.0);
  of.run(3);
  troubles.set(Fault::history_lost, true);
  of.exchange.note_troubles(troubles);
  EXPECT_EQ(of.step().fault, bits(Fault::history_lost));
  of.offer(of.new_cycle);
  of.until(ExchangeState::trial, 3);
  of.exchange.note_troubles(troubles);
  of.until(ExchangeState::watching, 1000);
  EXPECT_TRUE(of.last.exchange.state == ExchangeState::watching);
  of.step();
  EXPECT_TRUE(of.shows_new());
  EXPECT_EQ(of.last.fault, bits(Fault::history_lost));
}

}  // namespace cycle_exchange_limits_test
}  // namespace spindle_twin::firmware
