#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include "rom/units.hpp"
#include "tests/correction/estimator/plant_and_twin.hpp"
#include "tests/firmware/support/small_network.hpp"

/// However wrong and however sure of itself the filter is, an hour of readings brings it back to its sensors.
namespace spindle_twin::correction::test {
namespace estimator_lock_out_test {

constexpr double settling_s = 1200.0;  // that a filter has learnt before it is made wrong, where it has
constexpr double judged_s = 120.0;     // at the end of the hour
constexpr double wanted_K = 0.2;
constexpr double allowed_K = 3.0;
constexpr double deviations_off = 6.0;
constexpr double share_of_deviation = 0.1;  // a hundredth of the variance
constexpr double state_off_K = 30.0;

/// Whether the estimator itself says that readings do not fit what it expects of them.
bool says_inconsistent(const EstimatorCorrection& estimator) { return estimator.consistency().in_doubt(); }

struct Wrong {
  std::vector<Eigen::Index> parameters;  ///< of θ
  std::vector<double> signs;             ///< of each
  Eigen::VectorXd state_K;               ///< added to the twin's nodes; empty: nothing
  double from_s = 0.0;                   ///< when it is made wrong
};

/// Seven nodes: three plates, the air; a sensor on each plate.
rom::Network three_plates(std::uint64_t seed) {
  rom::Network network = rom::tests::make_synthetic_network({3, 2, 1, true}, seed);
  network.boundaries.sources[0].law = {0.0, {{0.5, 1.0}, {0.5, 1.6}}, 0.0, false};
  network.boundaries.sources[0].friction = true;
  network.certificate = {};
  return network;
}

/// A hidden machine within the priors, and a twin that follows it.
class Trial {
 public:
  Trial(const rom::Network& network, std::uint64_t seed) : pair_(network, {}) {
    pair_.cycle_s = 5.0;
    pair_.noise_K = 0.02;
    pair_.random.seed(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    for (Eigen::Index i = 0; i < pair_.truth.size(); ++i) {
      const Parameter& parameter = parameters()[static_cast<std::size_t>(i)];
      // Of a certified network nothing is left to explain: such heats are shut there.
      if (parameter.kind == ParameterKind::disturbance && !network.hand_written) continue;
      pair_.truth[i] = parameter.mean + parameter.deviation * std::clamp(normal(pair_.random), -1.5, 1.5);
    }
  }

  const std::vector<Parameter>& parameters() const { return pair_.estimator.parameters().list(); }

  void make_wrong(const Wrong& wrong) {
    pair_.run_until(wrong.from_s);
    if (pair_.time_s == 0.0) pair_.estimator.reset(0.0, pair_.twin.stepper.temperatures_K(), pair_.operating);
    if (wrong.state_K.size() > 0) {
      pair_.twin.stepper.set_temperatures(pair_.twin.stepper.temperatures_K() + wrong.state_K);
      if (pair_.time_s == 0.0) pair_.estimator.reset(0.0, pair_.twin.stepper.temperatures_K(), pair_.operating);
    }
    if (wrong.parameters.empty()) return;
    EstimatorState state;
    pair_.estimator.save(state);
    // As SquareRootFilter has it: mean (θ first), and a root W in units of the prior deviations.
    const auto n = static_cast<Eigen::Index>(state.mean.size());
    ASSERT_EQ(state.root.size(), state.mean.size() * state.mean.size());
    Eigen::Map<Eigen::MatrixXd> root(state.root.data(), n, n);
    for (std::size_t i = 0; i < wrong.parameters.size(); ++i) {
      const Eigen::Index p = wrong.parameters[i];
      const Parameter& parameter = parameters()[static_cast<std::size_t>(p)];
      state.mean[static_cast<std::size_t>(p)] = parameter.mean + wrong.signs[i] * deviations_off * parameter.deviation;
      root.row(p) *= share_of_deviation / root.row(p).norm();
    }
    ASSERT_TRUE(pair_.estimator.restore(state));
  }

  /// Largest error at a sensor in the last minutes of an hour with a step of speed and load and one back.
  double error_after_an_hour_K() {
    const double end_s = pair_.time_s + rom::seconds_per_hour;
    const rom::OperatingState nominal = pair_.operating;
    const double slow_from_s = end_s - 2400.0, slow_until_s = end_s - 1200.0;
    double worst_K = 0.0;
    while (pair_.time_s < end_s - 1e-9) {
      const bool slow = pair_.time_s >= slow_from_s && pair_.time_s < slow_until_s;
      pair_.operating.speed_rpm = slow ? 0.6 * nominal.speed_rpm : nominal.speed_rpm;
      pair_.operating.load = slow ? 0.5 * nominal.load : nominal.load;
      pair_.cycle();
      note_rejections();
      const double error_K = pair_.sensor_error_K();
      if (pair_.time_s > end_s - judged_s) worst_K = std::isfinite(error_K) ? std::max(worst_K, error_K) : INFINITY;
      if (::testing::Test::HasFatalFailure()) return INFINITY;
    }
    return worst_K;
  }

  /// Cycles in which most sensors had been rejected for two minutes and the flag was not up.
  int unsaid() const { return unsaid_; }

 private:
  void note_rejections() {
    const auto sensors = static_cast<Eigen::Index>(pair_.estimator.sensors().size());
    constexpr int two_minutes = 12;  // updates
    int rejected = 0;
    for (Eigen::Index s = 0; s < sensors; ++s) {
      if (pair_.estimator.record(s).rejected_in_a_row >= two_minutes) ++rejected;
    }
    if (2 * rejected > sensors && !says_inconsistent(pair_.estimator)) ++unsaid_;
  }

  Pair pair_;
  int unsaid_ = 0;
};

std::string describe(const std::vector<Parameter>& parameters, const Wrong& wrong) {
  std::ostringstream text;
  text << "wrong from " << wrong.from_s << " s on:";
  for (std::size_t i = 0; i < wrong.parameters.size(); ++i) {
    text << (wrong.signs[i] > 0.0 ? " +" : " -") << parameters[static_cast<std::size_t>(wrong.parameters[i])].name;
  }
  if (wrong.state_K.size() > 0) text << " nodes by " << wrong.state_K.transpose() << " K";
  return text.str();
}

/// How many cases of a law came as near as is wanted.
struct Tally {
  int cases = 0;
  int wanted = 0;
  /// The aim is all of them. Those that miss it are off by a few tenths of a kelvin.
  void expect_share(double least) const {
    ::testing::Test::RecordProperty("within_0.2_K", wanted);
    std::printf("%d of %d within %g K\n", wanted, cases, wanted_K);
    EXPECT_GE(wanted, least * cases);
  }
};

void expect_back(const rom::Network& network, std::uint64_t seed, const Wrong& wrong, Tally& tally) {
  Trial trial(network, seed);
  SCOPED_TRACE("network " + network.spindle + ", seed " + std::to_string(seed) + ", " +
               describe(trial.parameters(), wrong));
  trial.make_wrong(wrong);
  if (::testing::Test::HasFatalFailure()) return;
  const double error_K = trial.error_after_an_hour_K();
  EXPECT_LE(error_K, allowed_K);
  ++tally.cases;
  if (error_K <= wanted_K) ++tally.wanted;
  EXPECT_EQ(trial.unsaid(), 0) << "most sensors rejected for minutes and nothing said of it";
}

/// 0, so that every run of the tests is the same; with --gtest_random_seed=7 other seeds.
std::uint64_t first_seed() {
  if (GTEST_FLAG_GET(random_seed) == 0) return 0;
  return 1000 * static_cast<std::uint64_t>(::testing::UnitTest::GetInstance()->random_seed());
}

double toss(std::mt19937_64& random) { return std::bernoulli_distribution(0.5)(random) ? 1.0 : -1.0; }

Eigen::VectorXd state_off(std::mt19937_64& random, Eigen::Index nodes) {
  Eigen::VectorXd off_K(nodes);
  for (double& node_K : off_K) node_K = state_off_K * toss(random);
  return off_K;
}

/// Every case of the law starts from an untouched filter and again from one that has learnt for twenty minutes.
constexpr std::array<double, 2> moments_s{0.0, settling_s};

TEST(LockOut, a_filter_that_nobody_made_wrong_comes_back_to_its_sensors_within_an_hour) {
  Tally tally;
  for (std::uint64_t seed = first_seed() + 1; seed <= first_seed() + 12; ++seed) {
    expect_back(seed % 2 == 0 ? spindle_twin::tests::small_network() : three_plates(seed), seed, {}, tally);
  }
  tally.expect_share(0.9);
}

TEST(LockOut, a_confidently_wrong_filter_comes_back_to_its_sensors_within_an_hour_from_any_one_parameter) {
  Tally tally;
  const std::uint64_t seed = first_seed() + 1;
  for (const rom::Network& network : {spindle_twin::tests::small_network(), three_plates(seed)}) {
    const ParameterModel parameters(network, {});
    for (Eigen::Index p = 0; p < parameters.count(); ++p) {
      for (const double sign : {1.0, -1.0}) {
        for (const double from_s : moments_s) expect_back(network, seed, {{p}, {sign}, {}, from_s}, tally);
      }
    }
  }
  tally.expect_share(0.95);
}

TEST(LockOut, a_confidently_wrong_filter_comes_back_to_its_sensors_within_an_hour_from_all_parameters) {
  Tally tally;
  for (std::uint64_t seed = first_seed() + 1; seed <= first_seed() + 12; ++seed) {
    std::mt19937_64 random(seed);
    const rom::Network network = seed % 2 == 0 ? spindle_twin::tests::small_network() : three_plates(seed);
    Wrong wrong;
    const Eigen::Index count = ParameterModel(network, {}).count();
    for (Eigen::Index p = 0; p < count; ++p) {
      wrong.parameters.push_back(p);
      wrong.signs.push_back(toss(random));
    }
    for (const double from_s : moments_s) {
      wrong.from_s = from_s;
      expect_back(network, seed, wrong, tally);
    }
  }
  tally.expect_share(0.6);
}

TEST(LockOut, a_confidently_wrong_filter_comes_back_to_its_sensors_within_an_hour_from_wrong_temperatures) {
  Tally tally;
  for (std::uint64_t seed = first_seed() + 1; seed <= first_seed() + 12; ++seed) {
    std::mt19937_64 random(seed);
    const rom::Network network = seed % 2 == 0 ? spindle_twin::tests::small_network() : three_plates(seed);
    const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
    for (const double from_s : moments_s) expect_back(network, seed, {{}, {}, state_off(random, nodes), from_s}, tally);
  }
  tally.expect_share(0.9);
}

TEST(LockOut,
     a_confidently_wrong_filter_comes_back_to_its_sensors_within_an_hour_from_wrong_parameters_and_temperatures) {
  Tally tally;
  for (std::uint64_t seed = first_seed() + 1; seed <= first_seed() + 12; ++seed) {
    std::mt19937_64 random(seed);
    const rom::Network network = seed % 2 == 0 ? spindle_twin::tests::small_network() : three_plates(seed);
    const Eigen::Index count = ParameterModel(network, {}).count();
    Wrong wrong;
    wrong.state_K = state_off(random, static_cast<Eigen::Index>(network.nodes.size()));
    for (Eigen::Index p = 0; p < count; ++p) {
      if (!std::bernoulli_distribution(0.3)(random)) continue;
      wrong.parameters.push_back(p);
      wrong.signs.push_back(toss(random));
    }
    for (const double from_s : moments_s) {
      wrong.from_s = from_s;
      expect_back(network, seed, wrong, tally);
    }
  }
  tally.expect_share(0.65);
}

}  // namespace estimator_lock_out_test
}  // namespace spindle_twin::correction::test
