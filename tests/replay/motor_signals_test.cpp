#include <gtest/gtest.h>

#include <cmath>
#include <random>
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
namespace motor_signals_test {

using firmware::Snapshot;

/// The hand-written motor spindle, whose copper follows the current, and its jacket's film the flow.
rom::Network laws_network() {
  return rom::read_by_hand(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle_laws.toml");
}

constexpr auto current = static_cast<std::size_t>(firmware::Signal::current);

TEST(ReplayMotorSignals, a_history_with_current_and_flow_gives_the_daemons_own_predictions_to_the_bit) {
  const rom::Network network = laws_network();
  firmware::CyclePlan plan;
  for (std::size_t k = 0; k < network.key_points.size(); ++k) plan.sensors[k].configured = true;
  const auto device = [&](std::size_t s, double first, double stale_s) {
    plan.signals[s] = {firmware::SignalSource::device, first, -1e5, 1e5, stale_s};
  };
  for (std::size_t s = 0; s < 4; ++s) device(s, s < 2 ? 0.0 : 293.15, 0.0);
  device(current, firmware::not_a_value, 3.0);
  device(firmware::first_flow_signal, 0.083, 0.0);
  plan.estimator = correction::EstimatorOptions{};
  firmware::Cycle cycle(network, plan, [](const rom::Network& of) { return rom::make_runtime_stepper(of); });

  std::mt19937 random(11);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::normal_distribution<double> noise_K(0.0, 0.03);
  firmware::DeviceFrame frame;
  frame.connected = true;
  std::vector<Snapshot> lived;
  std::string history = firmware::history_header(network) + "\n";
  for (int n = 0; n < 900; ++n) {
    const std::int64_t now_ns = 5'000'000'000LL + 1'000'000'000LL * n;
    frame.signals[0] = {n % 300 < 250 ? 9000.0 : 0.0, now_ns};
    frame.signals[1] = {0.5, now_ns};
    frame.signals[2] = frame.signals[3] = {293.15 + 0.01 * noise_K(random), now_ns};
    frame.signals[firmware::first_flow_signal] = {0.07 + 0.02 * share(random), now_ns};
    if (n > 20 && share(random) < 0.4)
      frame.signals[current] = {share(random) < 0.1 ? 2e5 : 20.0 * share(random), now_ns};
    for (std::size_t k = 0; k < network.key_points.size(); ++k) {
      const double rise_K = 12.0 * (1.0 - std::exp(-n / 300.0));
      frame.sensors[k] = {293.15 + rise_K + noise_K(random), now_ns};
    }
    lived.push_back(cycle.step(frame, {}, now_ns, 0));
    history += firmware::history_row(lived.back()) + "\n";
  }
  ASSERT_TRUE(std::isnan(lived[10].signals[current]));
  ASSERT_FALSE(std::isnan(lived[100].signals[current]));

  const tests::TemporaryFolder folder;
  const Log log = read_log(folder.write("twin.csv", history), network, 60.0);
  EXPECT_TRUE(log.has_signal[current]);
  EXPECT_FALSE(log.has_signal[current + 1]) << "no power was told";
  std::size_t n = 0;
  replay(network, plan, log, [&](const ReplayedCycle& replayed) {
    ASSERT_EQ(bits_of(replayed.snapshot), bits_of(lived[n])) << "cycle " << n;
    ++n;
  });
  EXPECT_EQ(n, lived.size());
}

TEST(ReplayMotorSignals, a_plain_log_heats_the_winding_by_its_current_and_cools_by_its_flow) {
  const rom::Network network = laws_network();
  const tests::TemporaryFolder folder;
  const auto winding_K = [&](const std::string& columns, const std::string& values) {
    std::ostringstream text;
    text << "time_s,speed_rpm,load" << columns << "\n";
    for (int s = 0; s <= 3600; s += 10) text << s << ",0,1" << values << "\n";
    const Log log = read_log(folder.write("day.csv", text.str()), network, 60.0);
    ReplayOptions options;
    options.correction = "none";
    options.start_degC = 20.0;
    double last_K = 0.0;
    replay(network, plan_replay(network, log, options), log,
           [&](const ReplayedCycle& cycle) { last_K = cycle.snapshot.predicted_K[1]; });
    return last_K - 293.15;
  };
  const double rated_K = winding_K("", "");
  EXPECT_NEAR(winding_K(",current_A", ",16"), rated_K, 1e-9) << "rated current at load 1";
  EXPECT_LT(winding_K(",current_A", ",8"), 0.26 * rated_K) << "a quarter of the heat, and less for the colder copper";
  EXPECT_GT(winding_K(",flow.jacket_kg_per_s", ",0.002"), rated_K + 1.0);
}

TEST(ReplayMotorSignals, a_plain_log_must_have_a_number_in_each_row) {
  const rom::Network network = laws_network();
  const tests::TemporaryFolder folder;
  const std::string path = folder.write("day.csv", "time_s,speed_rpm,load,current_A\n0,0,1,5\n10,0,1,\n");
  try {
    read_log(path, network, 60.0);
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_EQ(error.what(), path + ":3: current_A: must not be empty");
  }
}

}  // namespace motor_signals_test
}  // namespace spindle_twin::host_tools
