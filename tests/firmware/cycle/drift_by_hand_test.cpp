#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "rom/by_hand/read_by_hand.hpp"
#include "tests/firmware/support/daemon_plan.hpp"
#include "tests/firmware/support/machine.hpp"

/// A sensor of a hand-written network that drifts: heats that no source explains are open there, and could be laid what
/// it reads.
namespace spindle_twin::firmware {
namespace cycle_drift_by_hand_test {

/// The shipped example with sensors at winding, both bearings and both ends of the housing.
rom::Network with_five_places() {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/rom/by_hand/motor_spindle.toml");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  for (const std::string node : {"front_bearings", "rear_bearing", "housing_front", "housing_rear"}) {
    text += "\n[[key_point]]\nname = \"at_" + node + "\"\nnode = \"" + node + "\"\n";
  }
  return rom::parse_by_hand(text, "motor_spindle.toml");
}

struct Seen {
  int failed_at_s = 0;    ///< 0: never
  int others_failed = 0;  ///< cycles with another sensor that is not believed
  SensorFault fault = SensorFault::none;
  double nose_um = 0.0;          ///< furthest from the truth, from a quarter of an hour on
  double nose_deviations = 0.0;  ///< the same in published deviations
};

/// Two hours at 8000, 12000 and 5000 rpm; from half an hour on `place` reads rate_K_per_h more.
Seen with_drift_at(const std::string& place, double rate_K_per_h, double heat, std::uint64_t seed) {
  const rom::Network network = with_five_places();
  DaemonLines lines;
  std::size_t drifting = 0;
  for (std::size_t k = 1; k < network.key_points.size(); ++k) {
    lines.sensors.push_back(network.key_points[k].name);
    if (network.key_points[k].name == place) drifting = k;
  }
  const CyclePlan plan = daemon_plan(network, lines);
  Cycle cycle(network, plan, runtime);
  Machine machine(network, heat);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise_K(0.0, lines.noise_K);
  Seen seen;
  for (int n = 0; n < 7200; ++n) {
    machine.operating.speed_rpm = n < 2400 ? 8000.0 : n < 4800 ? 12000.0 : 5000.0;
    DeviceFrame frame = machine.frame(at_s(n));
    for (std::size_t k = 1; k < network.key_points.size(); ++k) frame.sensors[k].value += noise_K(random);
    frame.sensors[drifting].value += rate_K_per_h * std::max(0, n - 1800) / 3600.0;
    frame.signals[0] = {machine.operating.speed_rpm, at_s(n)};
    frame.signals[1] = {machine.operating.load, at_s(n)};
    for (std::size_t e = 0; e < network.boundaries.environments.size(); ++e) {
      const bool coolant = network.boundaries.environments[e].kind == rom::EnvironmentKind::coolant;
      frame.signals[coolant ? 2 : 3] = {machine.operating.environment_K[static_cast<Eigen::Index>(e)], at_s(n)};
    }
    const Snapshot& now = cycle.step(frame, {}, at_s(n), 0);
    if (n > 900) {
      const double off_um = 1e6 * std::abs(now.deformation_m[0] - machine.model.outputs.deformations_m[0]);
      seen.nose_um = std::max(seen.nose_um, off_um);
      seen.nose_deviations = std::max(seen.nose_deviations, off_um / (1e6 * now.deformation_deviation_m[0]));
    }
    for (std::size_t k = 1; k < network.key_points.size(); ++k) {
      const bool failed = now.sensor_health[k].state == SensorState::failed;
      if (k != drifting) seen.others_failed += failed ? 1 : 0;
      if (k != drifting || !failed || seen.failed_at_s > 0) continue;
      seen.failed_at_s = n;
      seen.fault = now.sensor_health[k].fault;
    }
    machine.advance(1.0);
  }
  return seen;
}

TEST(DriftByHand, is_found_where_its_neighbours_contradict_and_bends_the_nose_by_less_than_what_it_reads) {
  for (const char* place : {"at_housing_front", "at_housing_rear"}) {
    for (const double heat : {0.8, 1.3}) {
      SCOPED_TRACE(std::string(place) + ", heat " + std::to_string(heat));
      const Seen seen = with_drift_at(place, 10.0, heat, 8);
      EXPECT_GT(seen.failed_at_s, 1800);
      EXPECT_EQ(seen.fault, SensorFault::drift);
      EXPECT_EQ(seen.others_failed, 0);
      EXPECT_LT(seen.failed_at_s, 5400) << "an hour after it began";
      EXPECT_LT(seen.nose_um, 5.0) << "10 K of the housing are 3 um";
      EXPECT_LT(seen.nose_deviations, 3.0);
    }
  }
}

}  // namespace cycle_drift_by_hand_test
}  // namespace spindle_twin::firmware
