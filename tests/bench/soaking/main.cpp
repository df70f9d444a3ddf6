#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <vector>

#include "firmware/serve/fill_image.hpp"
#include "firmware/serve/pack.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/exact_stepper.hpp"
#include "tests/bench/command_line/command_line.hpp"
#include "tests/firmware/support/daemon_plan.hpp"
#include "tests/firmware/support/random_machine.hpp"
#include "tests/rom/heap_calls.hpp"
#include "tests/rom/metered_stepper.hpp"

/// Weeks of the daemon's cycle on a clock of its own: another machine than the network, a random drive cycle, and each
/// day other troubles of sensors and signals.
namespace spindle_twin::firmware {
namespace {

constexpr double day_s = 86400.0;
constexpr double hour_s = 3600.0;
constexpr double morning_s = 6.0 * hour_s;  // somebody acknowledges failed sensors
constexpr long most_growth_kB = 1024;
constexpr double most_heat_lost = 1e-9;       // of what is put in; in each step of what is put in nominally
constexpr double most_by_kept_matrix = 1e-8;  // where Newton's matrix may be of conductances of before
constexpr double most_by_quadrature = 1e-5;   // which sees CVODE's own error

struct Options {
  double days = 30.0;
  std::uint64_t seed = 1;
  std::string network;  ///< empty: a random one, written by hand
  bool is_short = false;
  bool fresh_matrix = false;
};

struct Score {
  long cycles = 0;
  long missed = 0;       ///< numbers that the sequence left out
  long heap_calls = 0;   ///< of cycles behind the first hour
  long not_a_value = 0;  ///< registers with an infinite number
  long unfit = 0;        ///< cycles whose prediction is no finite number
  long running = 0;
  double longest_s = 0.0;
  long resident_after_hour_kB = 0;
  long resident_kB = 0;
  rom::tests::HeatBalance heat;  ///< of all models of the cycle together, between corrections; no steps: not asked
};

long resident_kB() {
  std::ifstream file("/proc/self/statm");
  long size = 0, resident = 0;
  file >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE) / 1024;
}

/// Registers that say an infinite number; what is not present is none.
long infinite_registers(const RegisterImage& image) {
  long count = 0;
  for (std::size_t which = 0; which < register_entries.size(); ++which) {
    for (int slot = 0; slot < register_entries[which].slots; ++slot) {
      count += std::isinf(get(image, static_cast<Register>(which), slot)) ? 1 : 0;
    }
  }
  return count;
}

/// What the machine does, a day after the other; the same seed gives the same days.
class Days {
 public:
  Days(const rom::Network& network, std::uint64_t seed) : network_(network), random_(seed) {}

  const LogStep& at(double time_s) {
    if (time_s >= end_s_) {
      begin_s_ = end_s_;
      end_s_ += day_s;
      log_ = random_log(network_, day_s, random_);
    }
    return at_time(log_, time_s - begin_s_);
  }

 private:
  const rom::Network& network_;
  Random random_;
  double begin_s_ = 0.0, end_s_ = 0.0;
  std::vector<LogStep> log_;
};

/// One to three troubles each day, of the same sensors with the same offsets.
TroubledDevice troubled_for(double days, const std::vector<std::size_t>& sensors, Random& random) {
  std::vector<TroubleEvent> events;
  for (double begin_s = 0.0; begin_s < days * day_s; begin_s += day_s) {
    for (TroubleEvent event : random_troubles(sensors, day_s, random)) {
      event.from_s += begin_s;
      event.until_s += begin_s;
      events.push_back(event);
    }
  }
  return {sensors, events, random()};
}

DaemonLines lines_of(const rom::Network& network, const std::vector<std::size_t>& sensors) {
  DaemonLines lines;
  for (const std::size_t k : sensors) lines.sensors.push_back(network.key_points[k].name);
  lines.offset_K = 0.1;
  return lines;
}

/// The daemon's own; where the network has neither laws nor circuits with meters of its heats.
std::unique_ptr<rom::FallbackStepper> make_stepper(const rom::Network& network, rom::tests::HeatBalance& balance,
                                                   const rom::CvodeSettings& settings) {
  if (!rom::tests::takes_meters(network)) return rom::make_runtime_stepper(network, settings);
  return std::make_unique<rom::FallbackStepper>(
      std::make_unique<rom::tests::MeteredStepper>(network, balance, settings),
      std::make_unique<rom::ExactStepper>(std::make_shared<const rom::NetworkOperator>(network)));
}

Score soak(const Options& options) {
  Random random(options.seed);
  const rom::Network network = options.network.empty() ? random_network(random) : rom::read_network(options.network);
  RandomMachine machine(made_other(network, 0.2, random));
  std::vector<std::size_t> sensors;
  for (std::size_t k = 0; k < std::min<std::size_t>(network.key_points.size(), 6); ++k) sensors.push_back(k);
  Days days(network, random());
  TroubledDevice device = troubled_for(options.days, sensors, random);
  machine.start(days.at(0.0).ambient_K);
  Score score;
  rom::CvodeSettings settings;
  if (options.fresh_matrix) settings.tolerated_share = 0.0;
  Cycle cycle(network, daemon_plan(network, lines_of(network, sensors)),
              [&](const rom::Network& of) { return make_stepper(of, score.heat, settings); });
  auto image = std::make_unique<RegisterImage>();
  std::printf("seed %lu: %zu nodes, %zu sensors, %.1f days of 1 s\n", static_cast<unsigned long>(options.seed),
              network.nodes.size(), sensors.size(), options.days);

  PlcCommand command;
  std::uint64_t sequence = 0;
  for (double time_s = 0.0; time_s < options.days * day_s; time_s += 1.0) {
    const LogStep& step = days.at(time_s);
    const auto now_ns = static_cast<std::int64_t>(1e9 * (1.0 + time_s));
    const DeviceFrame& frame = device.read(machine.nodes_K(), step, time_s, now_ns);
    if (std::fmod(time_s, day_s) == morning_s) {
      command.sensor_order = SensorOrder::acknowledge;
      ++command.sensor_orders;
    }
    const long heap_before = rom::tests::heap_calls();
    const auto begin = std::chrono::steady_clock::now();
    const Snapshot& snapshot = cycle.step(frame, command, now_ns, 0);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    if (time_s > hour_s) score.heap_calls += rom::tests::heap_calls() - heap_before;
    score.longest_s = std::max(score.longest_s, took.count());
    machine.advance(1.0, step);
    fill_image(snapshot, now_ns, *image);

    ++score.cycles;
    if (sequence != 0) score.missed += static_cast<long>(snapshot.sequence - sequence) - 1;
    sequence = snapshot.sequence;
    score.not_a_value += infinite_registers(*image);
    score.running += snapshot.state == State::running ? 1 : 0;
    if (snapshot.state == State::running || snapshot.state == State::degraded) {
      for (std::size_t k = 0; k < snapshot.key_points; ++k) {
        if (!std::isfinite(snapshot.predicted_K[k])) ++score.unfit;
      }
    }
    if (time_s == hour_s) score.resident_after_hour_kB = resident_kB();
  }
  score.resident_kB = resident_kB();
  return score;
}

/// Whether the heat balance closes.
bool report_heat(const rom::tests::HeatBalance& heat, bool fresh_matrix) {
  if (heat.steps == 0) {
    std::printf("heat balance: not asked, the network has physical laws or coolant circuits\n");
    return true;
  }
  std::printf("heat: %.6g MJ put in, %.6g MJ given away, %.6g MJ stored in %ld steps\n", 1e-6 * heat.put_in_J,
              1e-6 * heat.given_away_J, 1e-6 * heat.stored_J, heat.steps);
  std::printf("  missing: %.1e of it, in the worst step %.1e J, %.1e of the nominal heats; by quadrature %.1e\n",
              heat.share(), heat.worst_J, heat.worst_share, heat.share_by_quadrature());
  const double limit = fresh_matrix ? most_heat_lost : most_by_kept_matrix;
  return heat.share() <= limit && (!fresh_matrix || heat.worst_share <= limit) &&
         heat.share_by_quadrature() <= most_by_quadrature;
}

int report(const Score& score, const Options& options) {
  std::printf("%ld cycles, %ld missed, %.1f %% running, longest %.1f ms\n", score.cycles, score.missed,
              100.0 * static_cast<double>(score.running) / static_cast<double>(score.cycles), 1e3 * score.longest_s);
  std::printf("heap calls in cycles after the first hour: %ld\n", score.heap_calls);
  std::printf("registers with an infinite number: %ld; predictions that are no number: %ld\n", score.not_a_value,
              score.unfit);
  std::printf("resident memory after an hour and at the end: %ld and %ld kB\n", score.resident_after_hour_kB,
              score.resident_kB);
  const bool closes = report_heat(score.heat, options.fresh_matrix);
  const bool is_good = closes && score.missed == 0 && score.heap_calls == 0 && score.not_a_value == 0 &&
                       score.unfit == 0 && score.resident_kB - score.resident_after_hour_kB <= most_growth_kB &&
                       score.running > 0;
  std::printf("%s\n", is_good ? "all limits kept" : "MISSED");
  return is_good ? 0 : 1;
}

}  // namespace
}  // namespace spindle_twin::firmware

int main(int argc, char** argv) {
  using namespace spindle_twin::firmware;
  using spindle_twin::bench::Allowed;
  using spindle_twin::bench::CommandLine;
  Options options;
  CommandLine line("Weeks of the daemon's cycle on a clock of its own, with troubles each day");
  line.add("--days", options.days, "simulated", Allowed{0.1, 3650.0});
  line.add("--seed", options.seed, "of machine, drive cycle and troubles");
  line.add("--network", options.network, "network file; else a random hand-written one");
  line.add_flag("--fresh-matrix", options.fresh_matrix,
                "Newton's matrix is always of the present conductances: heat is conserved in each step");
  line.add_flag("--short", options.is_short, "two days, for CI");
  if (const auto code = line.parse(argc, argv)) return *code;
  if (options.is_short) options.days = 2.0;
  return report(soak(options), options);
}
