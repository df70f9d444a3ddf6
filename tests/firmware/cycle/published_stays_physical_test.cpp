#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <sstream>

#include "tests/firmware/support/daemon_plan.hpp"
#include "tests/firmware/support/random_machine.hpp"

/// Issue 11: whatever happens, what is published stays physical, or says that it may not be.
namespace spindle_twin::firmware {
namespace cycle_published_stays_physical_test {

/// A prediction may lie so much further outside of all readings and surroundings than the uncorrected model does.
constexpr double allowed_K = 30.0;
constexpr double run_s = 3.0 * 3600.0;
constexpr double ns_per_s = 1e9;

/// The span of what is known to be measured: between its ends everything is physical.
struct Span {
  double low_K = INFINITY;
  double high_K = -INFINITY;
  void take(double value_K) {
    if (!std::isfinite(value_K)) return;
    low_K = std::min(low_K, value_K);
    high_K = std::max(high_K, value_K);
  }
  double outside_K(double value_K) const { return std::max({0.0, low_K - value_K, value_K - high_K}); }
};

/// Readings as the device gave them, those out of range aside, and surroundings as they are in use.
Span measured(const rom::Network& network, const Snapshot& snapshot) {
  Span span;
  for (std::size_t k = 0; k < snapshot.key_points; ++k) {
    if (snapshot.sensor_quality[k] != SensorQuality::out_of_range) span.take(snapshot.measured_K[k]);
  }
  for (const rom::Environment& environment : network.boundaries.environments) {
    const Signal which = environment.kind == rom::EnvironmentKind::coolant ? Signal::coolant : Signal::ambient;
    span.take(snapshot.signals[static_cast<std::size_t>(which)]);
  }
  return span;
}

bool all_finite(const Snapshot& snapshot) {
  const auto finite = [](const auto& values, std::size_t count) {
    return std::all_of(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(count),
                       [](double value) { return std::isfinite(value); });
  };
  return finite(snapshot.predicted_K, snapshot.key_points) &&
         finite(snapshot.predicted_deviation_K, snapshot.key_points) &&
         finite(snapshot.part_maximum_K, snapshot.parts) && finite(snapshot.part_maximum_deviation_K, snapshot.parts) &&
         finite(snapshot.deformation_raw_m, snapshot.deformations) &&
         finite(snapshot.deformation_m, snapshot.deformations) &&
         finite(snapshot.deformation_deviation_m, snapshot.deformations) &&
         finite(snapshot.heat_factor, snapshot.sources) && finite(snapshot.conductance_factor, snapshot.conductances);
}

/// That something is wrong, in the state and in a bit that says what.
bool says_so(const Snapshot& snapshot) {
  constexpr auto always = static_cast<std::uint16_t>(bits(Quality::uncertified) | bits(Quality::slewing));
  const bool bit = snapshot.fault != 0 || (snapshot.quality & static_cast<std::uint16_t>(~always)) != 0;
  return bit && (snapshot.state == State::degraded || snapshot.state == State::fault);
}

struct Course {
  int cycles = 0;
  int running = 0;
  int unsaid = 0;        ///< cycles with something unphysical of which nothing was said
  double worst_K = 0.0;  ///< furthest unsaid, beyond what is allowed
  double worst_s = 0.0;
  int not_finite = 0;
  int deformations_off = 0;
};

/// What the rows of a deformation make of nodes between `low_K` and `high_K`.
bool within_rows(const rom::Network& network, std::size_t d, const Eigen::VectorXd& low_K,
                 const Eigen::VectorXd& high_K, double value_m) {
  constexpr double rounding_m = 1e-12;
  const Eigen::ArrayXd row = network.deformations[d].row_m_per_K.array();
  const double reference_K = network.boundaries.reference_temperature_K;
  const Eigen::ArrayXd at_low_m = row * (low_K.array() - reference_K), at_high_m = row * (high_K.array() - reference_K);
  return value_m >= at_low_m.min(at_high_m).sum() - rounding_m && value_m <= at_low_m.max(at_high_m).sum() + rounding_m;
}

void judge_cycle(const rom::Network& network, const Snapshot& snapshot, const Eigen::VectorXd& truth_K,
                 Course& course) {
  if (!all_finite(snapshot)) ++course.not_finite;
  const Span span = measured(network, snapshot);
  Eigen::VectorXd low_K = truth_K, high_K = truth_K;
  double beyond_K = 0.0;
  for (std::size_t k = 0; k < snapshot.key_points; ++k) {
    // What is true is never unphysical, even where nothing is measured and the uncorrected model does not know it.
    const auto node = static_cast<Eigen::Index>(k);
    const double free_K =
        std::max(span.outside_K(snapshot.uncorrected_K[k]), span.outside_K(truth_K[node])) + allowed_K;
    low_K[node] = span.low_K - free_K;
    high_K[node] = span.high_K + free_K;
    beyond_K = std::max(beyond_K, span.outside_K(snapshot.predicted_K[k]) - free_K);
  }
  ++course.cycles;
  course.running += snapshot.state == State::running ? 1 : 0;
  if (says_so(snapshot)) return;
  if (beyond_K > 0.0) {
    ++course.unsaid;
    if (beyond_K > course.worst_K) {
      course.worst_K = beyond_K;
      course.worst_s = snapshot.model_time_s;
    }
  }
  for (std::size_t d = 0; d < snapshot.deformations; ++d) {
    // On its way at the slew limit a published value may still be where it was when it was said to be wrong.
    const bool slewing = (snapshot.quality & bits(Quality::slewing)) != 0;
    const bool raw = within_rows(network, d, low_K, high_K, snapshot.deformation_raw_m[d]);
    if (!raw || (!slewing && !within_rows(network, d, low_K, high_K, snapshot.deformation_m[d])))
      ++course.deformations_off;
  }
}

Course run_seed(std::uint64_t seed, bool troubled) {
  Random random(seed);
  const rom::Network network = random_network(random);
  const double spread = draw(random, 0.1, 0.45);
  RandomMachine machine(made_other(network, spread, random));
  std::vector<std::size_t> sensors;
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    if (k == 0 || toss(random, 0.4)) sensors.push_back(k);
  }
  const std::vector<LogStep> log = random_log(network, run_s, random);
  const std::vector<TroubleEvent> troubles =
      troubled ? random_troubles(sensors, run_s, random) : std::vector<TroubleEvent>{};
  machine.start(log.front().ambient_K);
  const bool warm = toss(random, 0.4);
  if (warm) machine.advance(draw(random, 1800.0, 7200.0), random_log(network, 1.0, random).front());

  DaemonLines lines;
  lines.period_s = draw_int(random, 1, 3);
  for (const std::size_t k : sensors) lines.sensors.push_back(network.key_points[k].name);
  lines.offset_K = 0.1;
  Cycle cycle(network, daemon_plan(network, lines),
              [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  std::ostringstream what;
  what << "seed " << seed << ": " << network.nodes.size() << " nodes, " << sensors.size() << " sensors, "
       << (warm ? "warm" : "cold") << ", every " << lines.period_s << " s, spread " << spread << "; "
       << describe(troubles);
  SCOPED_TRACE(what.str());

  TroubledDevice device(sensors, troubles, random());
  Course course;
  State state = State::starting;
  for (double time_s = 0.0; time_s < run_s; time_s += lines.period_s) {
    const LogStep& step = at_time(log, time_s);
    const auto now_ns = static_cast<std::int64_t>(ns_per_s * (1.0 + time_s));
    const Snapshot& snapshot = cycle.step(device.read(machine.nodes_K(), step, time_s, now_ns), {}, now_ns, 0);
    machine.advance(lines.period_s, step);
    state = snapshot.state;
    if (snapshot.state == State::starting || !(snapshot.model_time_s > 0.0)) continue;
    judge_cycle(network, snapshot, machine.nodes_K(), course);
  }
  EXPECT_TRUE(course.cycles > 0 || state == State::fault) << "it never started and says nothing of it";
  EXPECT_EQ(course.not_finite, 0) << "cycles with something published that is no number";
  EXPECT_EQ(course.unsaid, 0) << "cycles with a prediction beyond the bound of which nothing was said, of "
                              << course.cycles << "; furthest by " << course.worst_K << " K at " << course.worst_s
                              << " s";
  EXPECT_EQ(course.deformations_off, 0);
  return course;
}

/// 0, so that every run of the tests is the same; with --gtest_random_seed=7 other seeds.
std::uint64_t first_seed() {
  if (GTEST_FLAG_GET(random_seed) == 0) return 0;
  return 1000 * static_cast<std::uint64_t>(::testing::UnitTest::GetInstance()->random_seed());
}

TEST(PublishedStaysPhysical, or_says_so_whatever_fails_on_random_hand_written_networks) {
  // Those behind 16 broke the law once. The sanitizers look at memory: a few seeds walk all of the cycle.
  constexpr std::array seeds = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 29, 43, 117, 129, 218, 228, 240};
#ifdef __SANITIZE_ADDRESS__
  constexpr std::size_t count = 3;
#else
  constexpr std::size_t count = seeds.size();
#endif
  Course all;
  for (const std::uint64_t seed : std::span(seeds).first(count)) {
    const Course course = run_seed(first_seed() + seed, true);
    all.cycles += course.cycles;
    all.running += course.running;
  }
  // Who always says that something is wrong has not kept the law.
  EXPECT_GT(all.running, all.cycles / 10);
}

TEST(PublishedStaysPhysical, and_says_nothing_most_of_the_time_where_only_the_network_is_wrong) {
  Course all;
  for (const std::uint64_t seed : {101, 102, 103, 104, 105, 106, 107, 108, 109, 110, 139}) {
    const Course course = run_seed(first_seed() + seed, false);
    all.cycles += course.cycles;
    all.running += course.running;
  }
  EXPECT_GT(all.running, all.cycles / 2);
}

}  // namespace cycle_published_stays_physical_test
}  // namespace spindle_twin::firmware
