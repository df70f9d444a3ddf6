#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "rom/by_hand/read_by_hand.hpp"
#include "tests/firmware/support/daemon_plan.hpp"
#include "tests/firmware/support/machine.hpp"

/// A hand-written network that begins on a spindle that has long been running: its model relaxes from a uniform start
/// that was none of the spindle's, while healthy sensors stand.
namespace spindle_twin::firmware {
namespace cycle_warm_start_by_hand_test {

struct Seen {
  int failed = 0;         ///< cycles with a sensor that is not believed
  double off_K = 0.0;     ///< furthest prediction from its own place, from a quarter of an hour on
  double offset_K = 0.0;  ///< largest at the end
};

/// The shipped example with sensors at winding, rear bearing and front housing.
rom::Network with_more_places() {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle.toml");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const std::string node : {"rear_bearing", "housing_front"}) {
    text += "\n[[key_point]]\nname = \"at_" + node + "\"\nnode = \"" + node + "\"\n";
  }
  return rom::parse_by_hand(text, "motor_spindle.toml");
}

/// An hour at steady state, sensors read each interval_s with noise.
Seen begun_warm(double heat, int interval_s, std::uint64_t seed) {
  const rom::Network network = with_more_places();
  DaemonLines lines;
  for (std::size_t k = 1; k < 4; ++k) lines.sensors.push_back(network.key_points[k].name);
  const CyclePlan plan = daemon_plan(network, lines);
  Cycle cycle(network, plan, runtime);
  Machine machine(network, heat);
  machine.advance(6.0 * 3600.0);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_K(0.0, lines.noise_K);
  Seen seen;
  DeviceFrame frame;
  for (int n = 0; n < 3600; ++n) {
    if (n % interval_s == 0) {
      frame = machine.frame(at_s(n));
      for (std::size_t k = 1; k < 4; ++k) frame.sensors[k].value += noise_K(random);
    }
    const auto& operating = machine.operating;
    frame.signals[0] = {operating.speed_rpm, at_s(n)};
    frame.signals[1] = {operating.load, at_s(n)};
    for (std::size_t e = 0; e < network.boundaries.environments.size(); ++e) {
      const bool coolant = network.boundaries.environments[e].kind == rom::EnvironmentKind::coolant;
      frame.signals[coolant ? 2 : 3] = {operating.environment_K[static_cast<Eigen::Index>(e)], at_s(n)};
    }
    const Snapshot& now = cycle.step(frame, {}, at_s(n), 0);
    seen.failed += now.sensors_failed > 0 ? 1 : 0;
    machine.advance(1.0);
    seen.offset_K = 0.0;
    for (std::size_t k = 1; k < 4; ++k) {
      const double truth_K = machine.model.outputs.key_points_K[static_cast<Eigen::Index>(k)];
      if (n > 900) seen.off_K = std::max(seen.off_K, std::abs(now.predicted_K[k] - truth_K));
      seen.offset_K = std::max(seen.offset_K, std::abs(now.sensor_update[k].offset));
    }
  }
  return seen;
}

TEST(WarmStartByHand, no_healthy_sensor_fails_and_none_is_taken_to_be_off) {
  for (const double heat : {1.0, 1.3}) {
    for (const int interval_s : {1, 10}) {
      for (const std::uint64_t seed : {1U, 2U}) {
        const Seen seen = begun_warm(heat, interval_s, seed);
        EXPECT_EQ(seen.failed, 0) << heat << ", each " << interval_s << " s, seed " << seed;
        EXPECT_LT(seen.off_K, 1.0) << heat << ", each " << interval_s << " s, seed " << seed;
        EXPECT_LT(seen.offset_K, 0.5) << heat << ", each " << interval_s << " s, seed " << seed;
      }
    }
  }
}

}  // namespace cycle_warm_start_by_hand_test
}  // namespace spindle_twin::firmware
