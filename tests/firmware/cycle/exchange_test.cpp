#include "firmware/cycle/exchange.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "tests/firmware/support/exchanging.hpp"

namespace spindle_twin::firmware {
namespace cycle_exchange_test {

constexpr double quick_s = 600.0;

ExchangePlan quick() { return {quick_s, quick_s, 0.1, 0.05}; }

/// With these as they stand in most tests.
struct QuickExchange : Exchanging {
  QuickExchange(const rom::Network& runs, const rom::Network& comes, const CyclePlan& plan = with_sensors(),
                const ExchangePlan& judged = quick())
      : Exchanging(runs, comes, plan, judged) {}
};

TEST(Exchange, a_better_network_is_tried_shown_watched_and_accepted_without_a_step) {
  QuickExchange of(tests::with_conductances(1.5), tests::small_network());
  const double most_m = with_sensors().slew_m_per_s * (1.0 + 1e-9);
  of.run(1200);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::none);
  of.offer(of.new_cycle);
  EXPECT_LE(of.way_until(ExchangeState::watching, 1000), most_m);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::watching);
  EXPECT_EQ(of.exchange.kept().standing_orders().network_sha256[0], 'a') << "what is kept stays the old one's";
  const int watched_from = of.n;
  EXPECT_LE(of.way_until(ExchangeState::keeping, 1000), most_m);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::keeping);
  EXPECT_EQ(of.n - watched_from, quick_s + 2) << "the watch in cycles of a second, and one at either end";
  EXPECT_LT(of.last.exchange.candidate_K, of.last.exchange.running_K);
  of.run(10);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::keeping) << "until its file is on the disk";
  EXPECT_FALSE(of.exchange.take_kept_changed());
  of.exchange.confirm();
  EXPECT_LE(of.way_until(ExchangeState::accepted, 2), most_m);
  EXPECT_TRUE(of.exchange.take_kept_changed());
  EXPECT_FALSE(of.exchange.take_kept_changed());
  EXPECT_EQ(of.exchange.kept().standing_orders().network_sha256[0], 'b');
  EXPECT_EQ(of.last.network_id, 0xbbbbbbbbU);
  of.run(600);
  EXPECT_NEAR(of.last.deformation_m[0], of.machine.model.outputs.deformations_m[0], 1e-7);
  EXPECT_EQ(of.last.sequence, static_cast<std::uint64_t>(of.n));
  EXPECT_DOUBLE_EQ(of.last.model_time_s, of.n);
}

TEST(Exchange, a_network_with_conductances_off_by_half_is_refused_with_and_without_a_correction) {
  for (const CyclePlan& plan : {with_sensors(), estimated()}) {
    for (const double factor : {0.5, 1.5}) {
      QuickExchange of(tests::small_network(), tests::with_conductances(factor), plan);
      of.run(1200);
      of.offer(of.new_cycle);
      of.until(ExchangeState::refused, 2000);
      EXPECT_EQ(of.last.exchange.state, ExchangeState::refused) << factor << (plan.estimator ? " estimator" : "");
      ExchangeNews news;
      EXPECT_TRUE(of.exchange.read(news));
      EXPECT_NE(news.reason, ExchangeReason::none);
      EXPECT_EQ(of.last.network_id, 0xaaaaaaaaU);
    }
  }
}

TEST(Exchange, a_refused_network_leaves_the_old_one_as_if_it_had_never_been_there) {
  QuickExchange of(tests::small_network(), tests::with_conductances(0.5));
  QuickExchange alone(tests::small_network(), tests::with_conductances(0.5));
  for (QuickExchange* each : {&of, &alone}) each->run(600);
  of.offer(of.new_cycle);
  for (QuickExchange* each : {&of, &alone}) each->run(900);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::refused);
  EXPECT_EQ(of.last.deformation_m[0], alone.last.deformation_m[0]);
  EXPECT_EQ(of.last.deformation_m[1], alone.last.deformation_m[1]);
  EXPECT_EQ(of.last.compensation.value_m, alone.last.compensation.value_m);
}

/// Passes its trial, because the machine is at rest there; with load its heats are wrong.
rom::Network wrong_under_load() {
  rom::Network network = tests::small_network();
  for (rom::HeatSource& source : network.boundaries.sources) source.nominal_W *= 2.0;
  return network;
}

TEST(Exchange, one_that_passes_and_then_does_worse_goes_back_without_a_step) {
  CyclePlan plan = with_sensors();
  plan.signals[0] = {SignalSource::plc, 0.0, 0.0, 1e5, 0.0};
  QuickExchange of(tests::small_network(), wrong_under_load(), plan);
  of.machine.operating.speed_rpm = 0.0;
  of.machine.operating.load = 0.0;
  of.command.signals[0] = {0.0, 1};
  of.run(600);
  of.offer(of.new_cycle);
  const double most_m = plan.slew_m_per_s * (1.0 + 1e-9);
  EXPECT_LE(of.way_until(ExchangeState::watching, 1000), most_m);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::watching);
  of.machine.operating = of.machine.network.boundaries.operating;
  of.command.signals[0] = {6000.0, 2};
  EXPECT_LE(of.way_until(ExchangeState::went_back, 1000), most_m);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::went_back);
  EXPECT_LE(of.way_of(of.last), most_m);
  ExchangeNews news;
  ASSERT_TRUE(of.exchange.read(news));
  EXPECT_EQ(news.reason, ExchangeReason::worse);
  EXPECT_GT(news.candidate_K, news.running_K);
  of.run(1);
  EXPECT_EQ(of.last.network_id, 0xaaaaaaaaU);
  double way_m = 0.0;
  for (int i = 0; i < 600; ++i) way_m = std::max(way_m, of.way_of(of.step()));
  EXPECT_LE(way_m, most_m);
  EXPECT_NEAR(of.last.deformation_m[0], of.machine.model.outputs.deformations_m[0], 1e-7);
}

TEST(Exchange, the_growth_since_a_tare_goes_on_and_going_back_brings_the_old_tare_back) {
  rom::Network longer = tests::small_network();
  longer.deformations[0].row_m_per_K *= 1.2;
  QuickExchange of(tests::small_network(), longer);
  of.run(1200);
  of.command.tare_orders = 1;
  of.step();
  const double tare_m = of.last.tare_m;
  ASSERT_GT(tare_m, 1e-6);
  EXPECT_NEAR(of.last.nose_m, 0.0, 1e-8);
  of.run(600);
  of.offer(of.new_cycle);
  of.until(ExchangeState::watching, 1000);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::watching);
  const double nose_m = of.last.nose_m;
  Remembered checkpoint;
  of.new_cycle.remember(checkpoint);
  EXPECT_NEAR(checkpoint.tare_m, 1.2 * of.machine.model.outputs.deformations_m[0] - nose_m, 1e-7)
      << "with what is to come of it";
  EXPECT_EQ(of.new_cycle.standing_orders().tare_m, checkpoint.tare_m);
  for (int i = 0; i < 100; ++i) {
    const double grown_m = of.machine.model.outputs.deformations_m[0];
    of.step();
    // Tare and nose go the same way: what is left is the growth itself.
    EXPECT_NEAR(of.last.nose_m - of.before.nose_m, 1.2 * (of.machine.model.outputs.deformations_m[0] - grown_m), 2e-8);
  }
  EXPECT_NEAR(of.last.nose_m, nose_m, 1e-6);
  EXPECT_NEAR(of.last.tare_m, 1.2 * of.machine.model.outputs.deformations_m[0] - of.last.nose_m, 1e-6);
  EXPECT_EQ(of.last.tare_count, 1) << "an order of before is no new one";
  of.exchange.withdraw();
  const double most_m = with_sensors().slew_m_per_s * (1.0 + 1e-9);
  EXPECT_LE(of.way_until(ExchangeState::went_back, 2), most_m);
  double way_m = 0.0;
  for (int i = 0; i < 300; ++i) way_m = std::max(way_m, of.way_of(of.step()));
  EXPECT_LE(way_m, most_m);
  EXPECT_NEAR(of.last.tare_m, tare_m, 1e-15);
}

TEST(Exchange, after_the_first_steps_of_a_trial_nothing_allocates_there_and_back) {
  QuickExchange of(tests::small_network(), tests::with_conductances(1.001), estimated(), ExchangePlan{});
  of.run(1200);
  of.offer(of.new_cycle);
  of.run(100);
  EXPECT_GT(of.heap_calls, 0) << "the counter does not count";
  of.heap_calls = 0;
  of.until(ExchangeState::watching, 4000);
  ExchangeNews news;
  of.exchange.read(news);
  ASSERT_EQ(of.last.exchange.state, ExchangeState::watching)
      << static_cast<int>(news.reason) << " " << news.candidate_K << " " << news.running_K;
  of.run(100);
  of.exchange.withdraw();
  of.until(ExchangeState::went_back, 2);
  of.run(100);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::went_back);
  EXPECT_EQ(of.heap_calls, 0);
}

TEST(Exchange, one_that_cannot_be_integrated_is_refused_and_the_old_one_goes_on) {
  const rom::Network network = tests::small_network();
  QuickExchange of(network, network);
  Cycle unfit(network, with_sensors(), runtime);
  unfit.identify(std::string(64, 'b'));
  unfit.start_at(Eigen::VectorXd::Constant(5, not_a_value));
  of.run(60);
  of.exchange.offer(unfit);
  of.run(1000);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::refused);
  EXPECT_EQ(of.last.state, State::running);
  EXPECT_EQ(of.last.network_id, 0xaaaaaaaaU);
}

TEST(Exchange, who_takes_the_file_away_ends_the_trial) {
  QuickExchange of(tests::small_network(), tests::small_network());
  of.run(60);
  of.offer(of.new_cycle);
  of.run(5);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::trial);
  of.exchange.withdraw();
  of.run(1);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::refused);
  ExchangeNews news;
  ASSERT_TRUE(of.exchange.read(news));
  EXPECT_EQ(news.reason, ExchangeReason::withdrawn);
}

TEST(Exchange, without_readings_a_trial_does_not_end) {
  QuickExchange of(tests::small_network(), tests::with_conductances(0.5));
  of.run(60);
  of.offer(of.new_cycle);
  for (int i = 0; i < 2000; ++i) of.last = of.exchange.step({}, {}, at_s(of.n++), 0);
  EXPECT_EQ(of.last.exchange.state, ExchangeState::trial);
  EXPECT_NEAR(of.last.exchange.left_s, quick_s, 10.0);
}

}  // namespace cycle_exchange_test
}  // namespace spindle_twin::firmware
