#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "firmware/cycle/cycle.hpp"
#include "firmware/keep/history.hpp"
#include "host_tools/replay/plan.hpp"
#include "host_tools/replay/replay.hpp"
#include "rom/by_hand/read_by_hand.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "tests/replay/bits.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::host_tools {
namespace measured_heat_test {

rom::Network two_node() { return rom::read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/two_node.toml"); }

std::string refusal(const ReplayOptions& options, const Log& log) {
  try {
    plan_replay(two_node(), log, options);
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "accepted";
}

Log log_of(const spindle_twin::tests::TemporaryFolder& folder, const std::string& columns, const std::string& values) {
  std::ostringstream text;
  text << "time_s,speed_rpm,load,ambient_degC" << columns << "\n";
  for (int s = 0; s <= 36000; s += 60) text << s << ",0,0,20" << values << "\n";
  return read_log(folder.write("day.csv", text.str()), two_node(), 60.0);
}

TEST(ReplayMeasuredHeat, the_watts_of_a_plain_log_heat_the_winding) {
  const spindle_twin::tests::TemporaryFolder folder;
  const rom::Network network = two_node();
  const auto housing_rise_K = [&](const std::string& columns, const std::string& values) {
    const Log log = log_of(folder, columns, values);
    ReplayOptions options;
    options.correction = "none";
    options.start_degC = 20.0;
    options.period_s = 60.0;
    double last_K = 0.0;
    replay(network, plan_replay(network, log, options), log,
           [&](const ReplayedCycle& cycle) { last_K = cycle.snapshot.predicted_K[1]; });
    return last_K - 293.15;
  };
  EXPECT_NEAR(housing_rise_K(",heat.loss_W", ",60"), 60.0 / 5.0, 0.05);
  EXPECT_NEAR(housing_rise_K("", ""), 150.0 / 5.0, 0.05) << "what the network says";
}

TEST(ReplayMeasuredHeat, a_history_gives_the_daemons_own_predictions_to_the_bit) {
  const rom::Network network = two_node();
  firmware::CyclePlan plan;
  plan.sensors[0].configured = plan.sensors[1].configured = true;
  for (const std::size_t s : {std::size_t{0}, std::size_t{1}, std::size_t{3}}) {
    plan.signals[s] = {firmware::SignalSource::constant, s < 2 ? 0.0 : 293.15, -1e5, 1e5, 0.0};
  }
  plan.signals[firmware::first_heat_signal] = {firmware::SignalSource::device, firmware::not_a_value, -1e5, 1e5, 0.0};
  plan.estimator = correction::EstimatorOptions{};
  firmware::Cycle cycle(network, plan, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  firmware::DeviceFrame frame;
  frame.connected = true;
  std::vector<firmware::Snapshot> lived;
  std::string history = firmware::history_header(network) + "\n";
  for (int n = 0; n < 600; ++n) {
    const std::int64_t now_ns = 5'000'000'000LL + 1'000'000'000LL * n;
    if (n > 30) frame.signals[firmware::first_heat_signal] = {n % 200 < 120 ? 100.0 + 0.1 * (n % 7) : 0.0, now_ns};
    for (std::size_t k = 0; k < 2; ++k) {
      frame.sensors[k] = {293.15 + (k == 0 ? 10.0 : 3.0) * (1.0 - std::exp(-n / 300.0)), now_ns};
    }
    lived.push_back(cycle.step(frame, {}, now_ns, 0));
    history += firmware::history_row(lived.back()) + "\n";
  }
  ASSERT_TRUE(std::isnan(lived[10].signals[firmware::first_heat_signal]));
  const spindle_twin::tests::TemporaryFolder folder;
  const Log log = read_log(folder.write("twin.csv", history), network, 60.0);
  EXPECT_TRUE(log.has_signal[firmware::first_heat_signal]);
  EXPECT_FALSE(log.has_signal[2]) << "there is no coolant";
  std::size_t n = 0;
  replay(network, plan, log, [&](const ReplayedCycle& replayed) {
    ASSERT_EQ(bits_of(replayed.snapshot), bits_of(lived[n])) << "cycle " << n;
    ++n;
  });
  EXPECT_EQ(n, lived.size());
}

TEST(ReplayOptions, the_command_line_reaches_the_estimator_and_the_health) {
  const spindle_twin::tests::TemporaryFolder folder;
  const Log log = log_of(folder, ",measured.winding_degC", ",21");
  ReplayOptions options;
  const firmware::CyclePlan plain = plan_replay(two_node(), log, options);
  EXPECT_TRUE(plain.health);
  options.floor_K = 0.4;
  options.offset_deviation_K = 0.25;
  options.lag_s = 7.0;
  options.start_K = 3.0;
  options.health = "off";
  const firmware::CyclePlan plan = plan_replay(two_node(), log, options);
  ASSERT_TRUE(plan.estimator);
  EXPECT_EQ(plan.estimator->floor_K, 0.4);
  EXPECT_EQ(plan.estimator->priors.start_K, 3.0);
  EXPECT_EQ(plan.sensors[0].offset_deviation_K, 0.25);
  EXPECT_EQ(plan.sensors[0].lag_s, 7.0);
  EXPECT_NE(plain.sensors[0].offset_deviation_K, 0.25);
  EXPECT_FALSE(plan.health);
  options.correction = "paper";
  EXPECT_NE(refusal(options, log).find("--floor-K: is of the estimator"), std::string::npos) << refusal(options, log);
}

}  // namespace measured_heat_test
}  // namespace spindle_twin::host_tools
