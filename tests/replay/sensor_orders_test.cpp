#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "firmware/keep/history.hpp"
#include "host_tools/replay/replay.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/replay/bits.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::host_tools {
namespace sensor_orders_test {

using firmware::SensorFault;
using firmware::SensorOrder;
using firmware::SensorState;
using firmware::Snapshot;

/// At rest first, then driven; the PLC gives orders for its sensors, and somebody exchanges two plugs and puts them
/// back.
struct OrderedLife {
  explicit OrderedLife(const rom::Network& network) : machine(network, 0.0) {
    plan = firmware::estimated();
    for (std::size_t s = 0; s < 4; ++s) plan.signals[s].source = firmware::SignalSource::device;
    plan.tare.rest_s = 900.0;
    plan.start_temperature_K.reset();
    for (firmware::SensorPlan& sensor : plan.sensors) sensor.offset_deviation_K = 0.2;
    firmware::Cycle cycle(network, plan, firmware::runtime);
    history = firmware::history_header(network) + "\n";
    for (int n = 0; n < 6000; ++n) step(cycle, n);
  }

  void step(firmware::Cycle& cycle, int n) {
    constexpr std::array<double, 3> offset_K = {0.15, -0.2, 0.05};
    const bool driven = n >= 1200;
    const std::int64_t now_ns = firmware::at_s(n);
    machine.operating.speed_rpm = driven ? 6000.0 : 0.0;
    machine.factors.heat.setConstant(driven ? 0.7 : 0.0);
    firmware::DeviceFrame frame = machine.frame(now_ns);
    for (std::size_t k = 0; k < 3; ++k) frame.sensors[k].value += offset_K[k] + noise_K(random);
    if (n >= 2400 && n < 3600) std::swap(frame.sensors[0], frame.sensors[2]);
    frame.signals[0] = {driven ? 6000.0 : 0.0, now_ns};
    frame.signals[1] = {driven ? 1.0 : 0.0, now_ns};
    frame.signals[2] = frame.signals[3] = {firmware::start_K, now_ns};
    const auto give = [&](SensorOrder order) {
      ++command.sensor_orders;
      command.sensor_order = order;
    };
    if (n == 600) give(SensorOrder::tare);  // too early, refused
    if (n == 1100) give(SensorOrder::tare);
    if (n == 1110) give(SensorOrder::clear_tare);
    if (n == 1111) give(SensorOrder::tare);
    if (n == 3700) give(SensorOrder::acknowledge);
    if (n == 4800) give(SensorOrder::clear_tare);
    if (n == 5000) give(SensorOrder::tare);  // not at rest, refused
    snapshots.push_back(cycle.step(frame, command, now_ns, 0));
    history += firmware::history_row(snapshots.back()) + "\n";
    machine.advance(1.0);
  }

  firmware::Machine machine;
  firmware::CyclePlan plan;
  firmware::PlcCommand command;
  std::vector<Snapshot> snapshots;
  std::string history;
  std::mt19937_64 random{4};
  std::normal_distribution<double> noise_K{0.0, 0.03};
};

TEST(ReplaySensorOrders, a_tare_that_was_taken_and_sensors_that_were_exchanged_come_back_to_the_bit) {
  const rom::Network network = tests::small_network();
  const OrderedLife life(network);
  const auto at = [&](int n) -> const Snapshot& { return life.snapshots[static_cast<std::size_t>(n)]; };
  ASSERT_EQ(at(601).sensor_tare_count, 0) << "refused";
  ASSERT_EQ(at(1101).sensor_tare_count, 1) << "taken";
  ASSERT_EQ(at(1110).sensor_tare_K[0], 0.0);
  ASSERT_NEAR(at(1200).sensor_tare_K[0], 0.15, 0.02) << "taken again";
  ASSERT_EQ(at(3599).sensor_health[0].fault, SensorFault::swapped);
  ASSERT_EQ(at(3599).sensor_health[0].partner, 2);
  ASSERT_EQ(at(4700).sensor_health[0].state, SensorState::good) << "acknowledged, and back after its probation";
  ASSERT_EQ(at(4800).sensor_tare_K[0], 0.0);
  ASSERT_EQ(life.snapshots.back().sensor_orders, 7U);

  const tests::TemporaryFolder folder;
  const Log log = read_log(folder.write("twin.csv", life.history), network, 60.0);
  std::size_t n = 0;
  replay(network, life.plan, log, [&](const ReplayedCycle& cycle) {
    ASSERT_EQ(bits_of(cycle.snapshot), bits_of(life.snapshots[n])) << "cycle " << n;
    ++n;
  });
  EXPECT_EQ(n, life.snapshots.size());
}

}  // namespace sensor_orders_test
}  // namespace spindle_twin::host_tools
