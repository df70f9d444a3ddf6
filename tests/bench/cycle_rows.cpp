#include <time.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include "firmware/cycle/cycle.hpp"
#include "rom/units.hpp"
#include "tests/bench/rows.hpp"
#include "tests/firmware/support/daemon_plan.hpp"
#include "tests/firmware/support/random_machine.hpp"

namespace spindle_twin::bench {
namespace {

constexpr int warm_up = 120, cycles = 3600;
constexpr double room_degC = 22.0;

/// The daemon's cycle with its defaults, fed by a machine whose heats are a fifth above what its network says.
class FedCycle {
 public:
  explicit FedCycle(const rom::Network& network)
      : machine_(hotter(network)),
        sensors_(sensors_of(network)),
        device_(sensors_, {}, 1),
        cycle_(network, plan_of(network, sensors_),
               [](const rom::Network& of) { return rom::make_runtime_stepper(of); }) {
    machine_.start(rom::zero_degC_K + room_degC);
  }

  /// Processor seconds of the cycle at this second.
  double step(int second) {
    constexpr double room_K = rom::zero_degC_K + room_degC;
    const Drive drive = drive_at(second);
    const firmware::LogStep step{1.0, drive.speed_rpm, drive.load, room_K, room_K};
    const std::int64_t now_ns = (second + std::int64_t{1}) * std::int64_t{1'000'000'000};
    const firmware::DeviceFrame& frame = device_.read(machine_.nodes_K(), step, second, now_ns);
    const double took_s = thread_seconds(1, [&] { last_ = &cycle_.step(frame, {}, now_ns, 0); });
    machine_.advance(1.0, step);
    return took_s;
  }

  const firmware::Snapshot& last() const { return *last_; }

 private:
  static rom::Network hotter(rom::Network network) {
    for (rom::HeatSource& source : network.boundaries.sources) source.nominal_W *= 1.2;
    return network;
  }
  static std::vector<std::size_t> sensors_of(const rom::Network& network) {
    std::vector<std::size_t> sensors(std::min(network.key_points.size(), firmware::slots::key_points));
    std::iota(sensors.begin(), sensors.end(), std::size_t{0});
    return sensors;
  }
  static firmware::CyclePlan plan_of(const rom::Network& network, const std::vector<std::size_t>& sensors) {
    firmware::DaemonLines lines;
    lines.offset_K = 0.1;
    for (const std::size_t k : sensors) lines.sensors.push_back(network.key_points[k].name);
    return firmware::daemon_plan(network, lines);
  }

  firmware::RandomMachine machine_;
  std::vector<std::size_t> sensors_;
  firmware::TroubledDevice device_;
  firmware::Cycle cycle_;
  const firmware::Snapshot* last_ = nullptr;
};

}  // namespace

void print_cycle_rows(const RowPrinter& printer) {
  const rom::Network network = network_of_200_nodes();
  FedCycle fed(network);
  for (int second = 0; second < warm_up; ++second) fed.step(second);
  const std::uint32_t updates_before = fed.last().updates;
  std::vector<double> took_s;
  took_s.reserve(cycles);
  for (int second = warm_up; second < warm_up + cycles; ++second) took_s.push_back(fed.step(second));
  if (fed.last().state != firmware::State::running || fed.last().updates <= updates_before) {
    throw std::runtime_error("the cycle of the bench does not correct");
  }
  std::sort(took_s.begin(), took_s.end());
  const double mean_s = std::accumulate(took_s.begin(), took_s.end(), 0.0) / cycles;
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  const double product_s = bare_product_seconds(nodes);
  printer.print({.group = "Daemon",
                 .name = "whole cycle, mean of an hour, " + std::to_string(nodes) + " nodes",
                 .ours_s = mean_s,
                 .other_name = "one bare matrix-vector product",
                 .other_s = product_s,
                 .means = "Sense, judge, correct by the estimator, integrate, predict and publish, with the "
                          "uncorrected model beside."});
  printer.print(
      {.group = "Daemon",
       .name = "the same, all cycles but one in a hundred are below",
       .ours_s = took_s[took_s.size() * 99 / 100],
       .other_name = "one bare matrix-vector product",
       .other_s = product_s,
       .means = "Every tenth cycle corrects; where speed and load jump in it too, integration takes short steps.",
       .detail = true});
  printer.print({.group = "Daemon",
                 .name = "the same, all cycles but one in a thousand are below",
                 .ours_s = took_s[took_s.size() * 999 / 1000],
                 .other_name = "median of these cycles",
                 .other_s = took_s[took_s.size() / 2],
                 .means = "How far the slowest cycles are from the usual one.",
                 .detail = true});
}

}  // namespace spindle_twin::bench
