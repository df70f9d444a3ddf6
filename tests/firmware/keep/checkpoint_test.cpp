#include "firmware/keep/checkpoint.hpp"

#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include "firmware/keep/history.hpp"
#include "firmware/keep/keeper.hpp"
#include "firmware/keep/parameters.hpp"
#include "rom/file/whole_file.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/sha256.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_checkpoint_test {

constexpr double saved_unix_s = 1.7e9;
const std::string sha256(64, 'a');

/// A twin that ran for half an hour and was tared, and what it remembers.
struct Ran {
  explicit Ran(const rom::Network& network, const CyclePlan& plan = estimated())
      : cycle(network, plan, runtime), machine(network, 0.5) {
    for (; n < 1800; ++n) {
      if (n == 900) ++command.tare_orders;
      last = cycle.step(machine.frame(at_s(n)), command, at_s(n), 0);
      machine.advance(1.0);
    }
    cycle.remember(checkpoint.remembered);
    checkpoint.network_sha256 = sha256;
    checkpoint.saved_unix_s = saved_unix_s;
  }

  Cycle cycle;
  Machine machine;
  PlcCommand command;
  Snapshot last;
  Checkpoint checkpoint;
  int n = 0;
};

struct InFolder {
  InFolder() { plan.checkpoint_path = folder.file("machine.checkpoint"); }
  tests::TemporaryFolder folder;
  KeepPlan plan;
};

/// Field 5 of the payload, 14 signals of 8 bytes: a program of before wrote the first 10.
TEST(Checkpoint, one_of_before_measured_heats_has_all_but_their_signals) {
  const rom::Network network = tests::small_network();
  Ran ran(network);
  ran.checkpoint.remembered.signals[first_heat_signal] = 5.0;
  const std::vector<std::uint8_t> now = encode_checkpoint(ran.checkpoint);
  std::string payload(std::find(now.begin(), now.end(), std::uint8_t{'\n'}) + 1, now.end());
  const std::size_t at = payload.find("\x2a\x70");
  ASSERT_NE(at, std::string::npos);
  payload.erase(at + 2 + 8 * first_heat_signal, 8 * slots::heats);
  payload[at + 1] = static_cast<char>(8 * first_heat_signal);
  const std::string file = "spindle-twin checkpoint 1 " + rom::sha256_hex(payload) + "\n" + payload;
  const Checkpoint back = decode_checkpoint({file.begin(), file.end()}, "x");
  const Remembered& kept = back.remembered;
  EXPECT_EQ(kept.nodes_K, ran.checkpoint.remembered.nodes_K);
  EXPECT_EQ(kept.signals[0], ran.checkpoint.remembered.signals[0]);
  EXPECT_TRUE(std::isnan(kept.signals[first_heat_signal]));
}

TEST(Checkpoint, comes_back_bit_for_bit) {
  const rom::Network network = tests::small_network();
  const Ran ran(network);
  const Checkpoint back = decode_checkpoint(encode_checkpoint(ran.checkpoint), "x");
  const Remembered& a = ran.checkpoint.remembered;
  const Remembered& b = back.remembered;
  EXPECT_EQ(back.network_sha256, sha256);
  EXPECT_EQ(back.saved_unix_s, saved_unix_s);
  EXPECT_EQ(b.model_time_s, a.model_time_s);
  EXPECT_EQ(b.tare_m, a.tare_m);
  EXPECT_EQ(std::memcmp(b.signals.data(), a.signals.data(), sizeof a.signals), 0) << "what is not told is no number";
  EXPECT_EQ(b.nodes_K, a.nodes_K);
  EXPECT_EQ(b.uncorrected_K, a.uncorrected_K);
  EXPECT_EQ(b.layout, a.layout);
  EXPECT_EQ(b.estimator.mean, a.estimator.mean);
  EXPECT_EQ(b.estimator.root, a.estimator.root);
  EXPECT_EQ(b.estimator.sensitivities, a.estimator.sensitivities);
  EXPECT_EQ(b.estimator.lagged, a.estimator.lagged);
  EXPECT_EQ(b.estimator.channels, a.estimator.channels);
  EXPECT_EQ(b.estimator.start, a.estimator.start);
  EXPECT_EQ(b.sensor_health, a.sensor_health);
  EXPECT_EQ(b.estimator.scale, a.estimator.scale);
  EXPECT_GT(a.estimator.determined, 0.0);
  EXPECT_EQ(b.estimator.determined, a.estimator.determined);
  EXPECT_EQ(b.spindle, "small");
  EXPECT_EQ(b.unknowns, a.unknowns);
  EXPECT_EQ(b.estimator.nominal, a.estimator.nominal);
}

TEST(Checkpoint, no_damaged_bit_and_no_cut_is_taken_for_a_checkpoint) {
  const rom::Network network = tests::small_network();
  const std::vector<std::uint8_t> good = encode_checkpoint(Ran(network).checkpoint);
  for (std::size_t at = 0; at < good.size(); at += 7) {
    std::vector<std::uint8_t> bad = good;
    bad[at] ^= static_cast<std::uint8_t>(1U << (at % 8));
    EXPECT_THROW(decode_checkpoint(bad, "x"), rom::InputError) << at;
    bad = good;
    bad.resize(at);
    EXPECT_THROW(decode_checkpoint(bad, "x"), rom::InputError) << at;
  }
}

TEST(Resume, without_a_gap_the_twin_goes_on_as_if_it_had_never_stopped) {
  const rom::Network network = tests::small_network();
  CyclePlan plan = estimated();
  plan.estimator->second_pass = 0.0;  // what was recorded for it is not in the checkpoint
  Ran ran(network, plan);
  Cycle again(network, plan, runtime);
  ASSERT_EQ(again.resume(ran.checkpoint.remembered, 0.0), Resumed::temperatures_and_estimator);
  Snapshot resumed;
  for (int n = ran.n; n < ran.n + 600; ++n) {
    const DeviceFrame frame = ran.machine.frame(at_s(n));
    ran.last = ran.cycle.step(frame, ran.command, at_s(n), 0);
    resumed = again.step(frame, {}, at_s(n), 0);
    ran.machine.advance(1.0);
    ASSERT_NEAR(resumed.predicted_K[0], ran.last.predicted_K[0], 0.005);
    ASSERT_NEAR(resumed.nose_m, ran.last.nose_m, 2e-8);
  }
  EXPECT_EQ(resumed.tare_m, ran.last.tare_m);
  EXPECT_NEAR(resumed.predicted_deviation_K[0], ran.last.predicted_deviation_K[0],
              0.02 * ran.last.predicted_deviation_K[0]);
  EXPECT_NEAR(resumed.heat_factor[0], ran.last.heat_factor[0], 0.01);
}

TEST(Resume, a_long_pause_is_given_up_when_the_daemon_is_to_end) {
  const rom::Network network = tests::small_network();
  const Ran ran(network);
  Cycle again(network, estimated(), runtime);
  std::atomic<bool> stop{true};
  EXPECT_EQ(again.resume(ran.checkpoint.remembered, 36000.0, &stop), Resumed::given_up);
}

TEST(Resume, the_model_cools_through_the_gap_as_the_machine_did) {
  const rom::Network network = tests::small_network();
  Ran ran(network);
  const double warm_K = ran.last.predicted_K[0];
  for (const double gap_s : {30.0, 1200.0, 36000.0}) {
    Machine machine(network, 0.0);
    machine.model.stepper->set_temperatures(ran.machine.model.stepper->temperatures_K());
    machine.advance(gap_s);
    Cycle again(network, estimated(), runtime);
    ASSERT_EQ(again.resume(ran.checkpoint.remembered, gap_s), Resumed::temperatures_and_estimator);
    const Snapshot first = again.step(machine.frame(at_s(0)), {}, at_s(0), 0);
    const double truth_K = machine.model.outputs.key_points_K[0];
    EXPECT_NEAR(first.predicted_K[0], truth_K, 0.05) << gap_s;
    EXPECT_LT(std::abs(first.predicted_K[0] - truth_K), 2.0 * first.predicted_deviation_K[0] + 0.03) << gap_s;
    if (gap_s > 1000.0) {
      EXPECT_LT(first.predicted_K[0], warm_K - 0.5);
    }
  }
}

/// A twin that was away while the machine did something, from the first cycle after it on.
struct Returned {
  Returned(const rom::Network& network, const Ran& ran, double gap_s, double from_s, double to_s)
      : machine(network, 0.0), cycle(network, estimated(), runtime) {
    machine.model.stepper->set_temperatures(ran.machine.model.stepper->temperatures_K());
    for (double time_s = 0.0; time_s < gap_s; time_s += 10.0) {
      machine.factors.heat.setConstant(time_s >= from_s && time_s < to_s ? 0.5 : 0.0);
      machine.advance(10.0);
    }
    machine.factors.heat.setConstant(0.5);
    resumed = cycle.resume(ran.checkpoint.remembered, gap_s);
    Remembered now;
    cycle.remember(now);
    missed_K = machine.model.outputs.key_points_K[0] - now.nodes_K[2];
  }

  void step() {
    DeviceFrame frame = machine.frame(at_s(n));
    for (std::size_t k = 0; k < 3; ++k) frame.sensors[k].value += 0.03 * normal(random);
    last = cycle.step(frame, {}, at_s(n++), 0);
    machine.advance(1.0);
  }
  double error_K(std::size_t k) const {
    return last.predicted_K[k] - machine.model.outputs.key_points_K[static_cast<Eigen::Index>(k)];
  }
  double nose_error_m() const { return last.deformation_raw_m[0] - machine.model.outputs.deformations_m[0]; }

  Machine machine;
  Cycle cycle;
  Resumed resumed;
  double missed_K = 0.0;  ///< what the first key point is warmer than the twin takes it for
  Snapshot last;
  std::mt19937_64 random{3};
  std::normal_distribution<double> normal{0.0, 1.0};
  int n = 0;
};

TEST(Resume, a_machine_that_ran_unseen_is_found_within_the_first_update_and_the_nose_is_within_its_sigma) {
  const rom::Network network = tests::small_network();
  const Ran ran(network);
  constexpr double gap_s = 1800.0;
  struct Unseen {
    double from_s, to_s;
  };
  for (const Unseen& unseen : {Unseen{0.0, gap_s}, {gap_s - 300.0, gap_s}, {0.0, 900.0}, {600.0, 1600.0}, {0.0, 0.0}}) {
    SCOPED_TRACE("ran from " + std::to_string(unseen.from_s) + " to " + std::to_string(unseen.to_s) + " s of the gap");
    Returned run(network, ran, gap_s, unseen.from_s, unseen.to_s);
    ASSERT_EQ(run.resumed, Resumed::temperatures_and_estimator);
    double worst_ratio = 0.0, largest_K = 0.0;
    std::string sigma_um;
    int rejections = 0, failed = 0, outside = 0;
    for (int n = 0; n < 3600; ++n) {
      run.step();
      for (std::size_t k = 0; k < 3; ++k) {
        if ((run.last.sensor_update[k].flags & bits(Update::rejected)) != 0) ++rejections;
        largest_K = std::max(largest_K, n >= 20 ? std::abs(run.error_K(k)) : 0.0);
      }
      failed = std::max(failed, static_cast<int>(run.last.sensors_failed));
      if (n == 0 || n == 60 || n == 600) sigma_um += fmt::format(" {:.2f}", 1e6 * run.last.deformation_deviation_m[0]);
      const double ratio = std::abs(run.nose_error_m()) / run.last.deformation_deviation_m[0];
      if (ratio > 2.0) ++outside;
      worst_ratio = std::max(worst_ratio, ratio);
    }
    EXPECT_LT(largest_K, 0.1) << "at a key point, from 20 s on";
    EXPECT_EQ(rejections, 0);
    EXPECT_EQ(failed, 0);
    EXPECT_EQ(outside, 0) << "cycles in which the nose is outside two of its deviations; worst " << worst_ratio;
    fmt::print(
        "ran {:4} to {:4} s of the gap: the sleeve was {:.2f} K warmer than the twin took it for; from 20 s on a "
        "key point is {:.3f} K off, the nose {:.2f} sigma; sigma at 0, 60, 600 s:{} um\n",
        unseen.from_s, unseen.to_s, run.missed_K, largest_K, worst_ratio, sigma_um);
  }
}

TEST(Resume, other_sensors_keep_the_temperatures_and_what_is_known_of_the_machine_and_another_size_nothing) {
  const rom::Network network = tests::small_network();
  const Ran ran(network);
  CyclePlan fewer = estimated();
  fewer.sensors[1].configured = false;
  Cycle other(network, fewer, runtime);
  EXPECT_EQ(other.resume(ran.checkpoint.remembered, 10.0), Resumed::temperatures);
  EXPECT_LT(ran.last.heat_factor[0], 0.7);
  EXPECT_NEAR(other.step({}, {}, at_s(0), 0).heat_factor[0], ran.last.heat_factor[0], 0.1);

  Cycle open(network, open_loop(), runtime);
  EXPECT_EQ(open.resume(ran.checkpoint.remembered, 10.0), Resumed::temperatures);

  Remembered wrong = ran.checkpoint.remembered;
  wrong.nodes_K.pop_back();
  EXPECT_EQ(other.resume(wrong, 10.0), Resumed::nothing);
  wrong = ran.checkpoint.remembered;
  wrong.nodes_K[0] = not_a_value;
  EXPECT_EQ(other.resume(wrong, 10.0), Resumed::nothing);
  EXPECT_EQ(other.resume(ran.checkpoint.remembered, not_a_value), Resumed::nothing);
  wrong = ran.checkpoint.remembered;
  wrong.nodes_K[0] = 1e6;
  EXPECT_EQ(other.resume(wrong, 10.0), Resumed::implausible) << "whatever its hash";
  wrong = ran.checkpoint.remembered;
  wrong.tare_m = 0.339;
  EXPECT_EQ(other.resume(wrong, 10.0), Resumed::implausible);
}

TEST(Keeper, a_checkpoint_is_used_only_where_it_fits) {
  const rom::Network network = tests::small_network();
  const Ran ran(network);
  const InFolder folder;
  const auto resumed = [&](const std::string& hash, double now_s) {
    Cycle cycle(network, estimated(), runtime);
    return resume_from_checkpoint(folder.plan, look_for_checkpoint(folder.plan), {hash, 1.0, now_s}, cycle);
  };
  EXPECT_EQ(resumed(sha256, saved_unix_s), Resumed::nothing) << "there is none yet";
  write_checkpoint(ran.checkpoint, folder.plan.checkpoint_path);
  EXPECT_EQ(resumed(sha256, saved_unix_s + 60.0), Resumed::temperatures_and_estimator);
  EXPECT_EQ(resumed(sha256, saved_unix_s - 1.0), Resumed::nothing) << "from the future";
  EXPECT_EQ(resumed(sha256, saved_unix_s + folder.plan.max_age_s + 1.0), Resumed::nothing) << "too old";
  EXPECT_EQ(earlier_histories(folder.plan.checkpoint_path).size(), 0U) << "age is no reason to keep it";
  EXPECT_EQ(resumed(std::string(64, 'b'), saved_unix_s + 60.0), Resumed::nothing) << "another network";
  write_checkpoint(ran.checkpoint, folder.plan.checkpoint_path);
  std::ofstream(folder.plan.checkpoint_path, std::ios::app) << "x";
  EXPECT_EQ(resumed(sha256, saved_unix_s + 60.0), Resumed::nothing) << "damaged";
}

TEST(Keeper, what_could_not_be_written_is_tried_again_in_a_second_and_else_after_the_interval) {
  using namespace std::chrono_literals;
  const std::chrono::steady_clock::time_point due{1000s};
  EXPECT_EQ(next_checkpoint(due, due + 3s, 300s, true), due + 300s);
  EXPECT_EQ(next_checkpoint(due, due + 3s, 300s, false), due + 4s) << "not after five minutes without a checkpoint";
  EXPECT_EQ(next_checkpoint(due, due + 10ms, 500ms, false), due + 500ms);
  EXPECT_EQ(next_checkpoint(due, due + 3600s, 300s, true), due + 3900s) << "one behind a long stop, not twelve";
  EXPECT_EQ(next_checkpoint(due, due + 3600s, 300s, false), due + 3601s);
}

TEST(Keeper, within_a_boot_the_age_of_a_checkpoint_is_not_the_clock_on_the_walls) {
  const rom::Network network = tests::small_network();
  Ran ran(network);
  const InFolder folder;
  ran.checkpoint.saved = {"one", 5000.0};
  write_checkpoint(ran.checkpoint, folder.plan.checkpoint_path);
  const auto nose_m = [&](double now_s, const BootTime& now) {
    Cycle cycle(network, estimated(), runtime);
    const Resumed resumed =
        resume_from_checkpoint(folder.plan, look_for_checkpoint(folder.plan), {sha256, 1.0, now_s, now}, cycle);
    return resumed == Resumed::nothing ? not_a_value : cycle.step({}, {}, at_s(0), 0).deformation_m[0];
  };
  const double wanted_m = nose_m(saved_unix_s + 60.0, {"one", 5060.0});
  EXPECT_EQ(nose_m(saved_unix_s - 9e8, {"one", 5060.0}), wanted_m) << "the clock was set back";
  EXPECT_EQ(nose_m(saved_unix_s + 9e8, {"one", 5060.0}), wanted_m) << "the clock was set forward";
  EXPECT_EQ(nose_m(saved_unix_s + 60.0, {"other", 9.0}), wanted_m)
      << "after a boot there is only the clock on the wall";
  EXPECT_TRUE(std::isnan(nose_m(saved_unix_s - 1.0, {"other", 9.0})));
  EXPECT_TRUE(std::isnan(nose_m(saved_unix_s - 1.0, {})));
}

TEST(Keeper, asks_the_cycle_thread_and_writes_what_it_gets) {
  const rom::Network network = tests::small_network();
  InFolder folder;
  folder.plan.parameters_path = folder.plan.checkpoint_path + ".csv";
  folder.plan.interval_s = 6.0;
  CyclePlan plan = estimated();
  plan.clock_rate = 100.0;
  Cycle cycle(network, plan, runtime);
  Keeper keeper(folder.plan, sha256, plan.clock_rate, cycle);
  std::atomic<bool> stop{false};
  DeviceInbox frames;
  Latest<PlcSignals> signals;
  Latest<Snapshot> snapshots;
  MonotonicClock clock;
  std::thread cycling([&] {
    run_cycle(cycle, plan, clock, {frames, signals, snapshots, nullptr, nullptr, &keeper.remembered()}, stop);
  });
  std::thread keeping([&] { keeper.run(stop); });
  while (!std::filesystem::exists(folder.plan.checkpoint_path) ||
         !std::filesystem::exists(folder.plan.parameters_path)) {
    std::this_thread::yield();
  }
  stop.store(true);
  cycling.join();
  keeping.join();
  keeper.keep_last(cycle);
  const auto kept = read_checkpoint(folder.plan.checkpoint_path);
  ASSERT_TRUE(kept.has_value());
  Remembered now;
  cycle.remember(now);
  EXPECT_EQ(kept->remembered.nodes_K, now.nodes_K);
  EXPECT_EQ(kept->network_sha256, sha256);
  std::remove(folder.plan.parameters_path.c_str());
}

TEST(Parameters, the_table_and_the_sentence_tell_what_the_sensors_determine) {
  const std::vector<correction::Parameter> parameters = {{.name = "heat rear", .mean = 0.1}, {.name = "contact nut"}};
  const std::vector<correction::ParameterEstimate> estimates = {{-0.7, 0.1, 0.5}, {0.0, 0.59, 0.6}};
  EXPECT_EQ(parameters_csv(parameters, estimates),
            "parameter,value,deviation,prior,prior_deviation,determined\n"
            "heat rear,-0.7,0.1,0.1,0.5,1\ncontact nut,0,0.59,0,0.6,0\n");
  EXPECT_EQ(what_is_determined(parameters, estimates),
            "the sensors determine 1 of 2 parameters (heat rear) and say nothing of the others (contact nut)");
}

TEST(Parameters, the_sentence_names_heats_that_no_source_explains_and_no_others) {
  const auto heat = correction::ParameterKind::disturbance;
  const std::vector<correction::Parameter> parameters = {{.name = "heat rear"},
                                                         {.name = "unexplained heat nose", .kind = heat},
                                                         {.name = "unexplained heat rear", .kind = heat},
                                                         {.name = "unexplained heat jacket", .kind = heat}};
  const auto estimates = [](double nose_W, bool rear_shut) {
    return std::vector<correction::ParameterEstimate>{
        {-0.7, 0.1, 0.5}, {nose_W, 8.0, 5.0}, {9.0, 2.0, 5.0, rear_shut}, {3.0, 2.0, 5.0}};
  };
  EXPECT_EQ(unexplained_heats(parameters, estimates(30.0, true)),
            "the readings ask for heat that no source explains (unexplained heat nose: 30 W +- 8 W)");
  EXPECT_EQ(unexplained_heats(parameters, estimates(12.0, false)),
            "the readings ask for heat that no source explains (unexplained heat rear: 9 W +- 2 W)");
  EXPECT_EQ(unexplained_heats(parameters, estimates(-15.0, true)), "");
}

}  // namespace keep_checkpoint_test
}  // namespace spindle_twin::firmware
