#include "firmware/keep/keeper.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "firmware/keep/history.hpp"
#include "tests/firmware/support/logged.hpp"
#include "tests/firmware/support/machine.hpp"
#include "tests/support/temporary_folder.hpp"

/// How old a checkpoint may be, and what a keeper writes and says.
namespace spindle_twin::firmware {
namespace keep_keeper_test {

const std::string sha256(64, 'a');
constexpr double saved_unix_s = 1.7e9;

Checkpoint checkpoint_of(const rom::Network& network) {
  Cycle cycle(network, open_loop(), runtime);
  for (int n = 0; n < 600; ++n) cycle.step({}, {}, at_s(n), 0);
  Checkpoint checkpoint;
  checkpoint.network_sha256 = sha256;
  checkpoint.saved_unix_s = saved_unix_s;
  checkpoint.saved = {"this", 5000.0};
  cycle.remember(checkpoint.remembered);
  return checkpoint;
}

struct Start {
  double unix_s;
  BootTime boot;
  double clock_rate = 1.0;
};

KeepPlan of_an_hour() {
  KeepPlan plan;
  plan.checkpoint_path = "x.checkpoint";
  plan.max_age_s = 3600.0;
  return plan;
}

Resumed resumed_at(const Checkpoint& checkpoint, const Start& start, Cycle& cycle) {
  return resume_from_checkpoint(of_an_hour(), checkpoint, {sha256, start.clock_rate, start.unix_s, start.boot}, cycle);
}

TEST(ResumeFromCheckpoint, of_no_age_and_of_the_most_allowed_it_is_used_and_beyond_it_is_not) {
  const rom::Network network = tests::small_network();
  const Checkpoint checkpoint = checkpoint_of(network);
  struct Case {
    double age_s;
    bool used;
  };
  for (const Case& of : {Case{0.0, true}, Case{3600.0, true}, Case{-0.5, false}, Case{3600.5, false}}) {
    for (const Start& start : {Start{saved_unix_s + of.age_s, {"other", 1.0}}, Start{9e9, {"this", 5000.0 + of.age_s}},
                               Start{saved_unix_s + of.age_s, {"", 5000.0}}}) {
      Cycle cycle(network, open_loop(), runtime);
      EXPECT_EQ(resumed_at(checkpoint, start, cycle), of.used ? Resumed::temperatures : Resumed::nothing)
          << of.age_s << " in boot " << start.boot.boot;
    }
  }
  Checkpoint of_before = checkpoint;
  of_before.saved = {};
  Cycle cycle(network, open_loop(), runtime);
  EXPECT_EQ(resumed_at(of_before, {saved_unix_s + 10.0, {}}, cycle), Resumed::temperatures)
      << "without a boot's name the clock on the wall counts";
}

TEST(ResumeFromCheckpoint, the_pause_is_as_long_as_the_model_would_have_gone_on_in_it) {
  const rom::Network network = tests::small_network();
  const Checkpoint checkpoint = checkpoint_of(network);
  const auto nodes_after = [&](double age_s, double clock_rate) {
    Cycle cycle(network, open_loop(), runtime);
    resumed_at(checkpoint, {saved_unix_s + age_s, {"other", 1.0}, clock_rate}, cycle);
    Remembered now;
    cycle.remember(now);
    return now.nodes_K;
  };
  EXPECT_EQ(nodes_after(20.0, 30.0), nodes_after(600.0, 1.0));
  EXPECT_NE(nodes_after(20.0, 1.0), nodes_after(600.0, 1.0));
}

TEST(ResumeFromCheckpoint, the_log_says_what_became_of_it) {
  const rom::Network network = tests::small_network();
  const Checkpoint checkpoint = checkpoint_of(network);
  const auto said = [&](const Start& start, const std::string& of) {
    const Logged log;
    Cycle cycle(network, open_loop(), runtime);
    resume_from_checkpoint(of_an_hour(), checkpoint, {of, 1.0, start.unix_s, start.boot}, cycle);
    return log.text();
  };
  EXPECT_EQ(said({saved_unix_s + 42.0, {}}, sha256),
            "info checkpoint x.checkpoint: goes on from 42 s ago, temperatures and tare only\n");
  EXPECT_EQ(said({saved_unix_s + 5400.0, {}}, sha256),
            "warning checkpoint x.checkpoint: not used, it is 1.5 h old, checkpoint.max_age_h is 1.0; a cold start\n");
  EXPECT_EQ(said({saved_unix_s - 1.0, {}}, sha256),
            "warning checkpoint x.checkpoint: not used, it was written later than the clock says now; a cold start\n");
  EXPECT_EQ(said({saved_unix_s, {}}, std::string(64, 'b')),
            "warning checkpoint x.checkpoint: not used, it is of another network; a cold start\n");
}

TEST(ResumeFromCheckpoint, one_of_another_size_or_beyond_what_a_spindle_can_have_is_named_as_such) {
  const rom::Network network = tests::small_network();
  const auto said_of = [&](const Checkpoint& checkpoint) {
    const Logged log;
    Cycle cycle(network, open_loop(), runtime);
    resumed_at(checkpoint, {saved_unix_s + 1.0, {}}, cycle);
    return log.text();
  };
  Checkpoint other = checkpoint_of(network);
  other.remembered.nodes_K.pop_back();
  EXPECT_EQ(said_of(other), "warning checkpoint x.checkpoint: not used, its sizes do not fit; a cold start\n");
  other = checkpoint_of(network);
  other.remembered.nodes_K[0] = 1e4;
  EXPECT_EQ(said_of(other),
            "warning checkpoint x.checkpoint: not used, it has temperatures or tares that no spindle has; "
            "a cold start\n");
}

struct Keeping {
  explicit Keeping(const CyclePlan& plan) : cycle(network, plan, runtime) {
    keep.checkpoint_path = folder.file("twin.checkpoint");
  }
  void step(int cycles) {
    for (int i = 0; i < cycles; ++i) cycle.step({}, {}, at_s(n++), 0);
  }
  tests::TemporaryFolder folder;
  rom::Network network = tests::small_network();
  Cycle cycle;
  KeepPlan keep;
  Troubles troubles;
  int n = 0;
};

TEST(Keeper, writes_nothing_before_there_is_a_prediction) {
  CyclePlan plan = with_sensors();
  plan.start_temperature_K.reset();
  Keeping of(plan);
  Keeper keeper(of.keep, sha256, 1.0, of.cycle, nullptr, &of.troubles);
  of.step(2);
  keeper.keep_last(of.cycle);
  EXPECT_EQ(of.folder.files(), 0);
}

TEST(Keeper, a_checkpoint_names_the_network_that_ran_when_it_was_asked_for) {
  Keeping of(open_loop());
  of.step(3);
  Keeper keeper(of.keep, sha256, 1.0, of.cycle, nullptr, &of.troubles);
  keeper.keep_last(of.cycle);
  EXPECT_EQ(read_checkpoint(of.keep.checkpoint_path)->network_sha256, sha256) << "nobody said, so that of the start";
  of.cycle.identify(std::string(64, 'b'));
  keeper.keep_last(of.cycle);
  const auto kept = read_checkpoint(of.keep.checkpoint_path);
  EXPECT_EQ(kept->network_sha256, std::string(64, 'b'));
  EXPECT_EQ(kept->order_revision, 0U);
  EXPECT_EQ(kept->remembered.model_time_s, 3.0);
  EXPECT_EQ(kept->saved.boot, boot_now().boot);
}

TEST(Keeper, a_checkpoint_says_how_many_orders_were_on_the_disk) {
  Keeping of(open_loop());
  of.step(3);
  OrderDesk desk;
  OrderKeeper orders(of.folder.file("twin.orders"), sha256, desk, of.troubles);
  StandingOrders stands;
  stands.revision = 5;
  orders.begin_with(stands);
  Keeper keeper(of.keep, sha256, 1.0, of.cycle, &orders, &of.troubles);
  keeper.keep_last(of.cycle);
  EXPECT_EQ(read_checkpoint(of.keep.checkpoint_path)->order_revision, 5U);
}

TEST(Keeper, what_cannot_be_written_is_a_fault_until_it_can) {
  Keeping of(estimated());
  of.step(3);
  const Logged log;
  of.keep.checkpoint_path = of.folder.file("away/twin.checkpoint");
  of.keep.parameters_path = of.folder.file("parameters.csv");
  Keeper keeper(of.keep, sha256, 1.0, of.cycle, nullptr, &of.troubles);
  keeper.keep_last(of.cycle);
  EXPECT_EQ(of.troubles.faults(), bits(Fault::checkpoint_lost));
  EXPECT_NE(log.text().find("error "), std::string::npos);
  std::filesystem::create_directory(of.folder.file("away"));
  keeper.keep_last(of.cycle);
  EXPECT_EQ(of.troubles.faults(), 0);
  EXPECT_TRUE(std::filesystem::exists(of.keep.checkpoint_path));
  EXPECT_TRUE(std::filesystem::exists(of.keep.parameters_path));
}

TEST(Keeper, at_the_end_it_says_once_more_what_the_sensors_determine) {
  Keeping of(estimated());
  of.step(30);
  Keeper keeper(of.keep, sha256, 1.0, of.cycle, nullptr, &of.troubles);
  for (int times = 0; times < 2; ++times) {
    const Logged log;
    keeper.keep_last(of.cycle);
    EXPECT_EQ(log.text().find("info after 30 s the sensors"), 0U) << log.text();
  }
}

TEST(Keeper, a_table_of_parameters_is_of_an_estimator_only) {
  Keeping of(open_loop());
  of.step(3);
  const Logged log;
  of.keep.parameters_path = of.folder.file("parameters.csv");
  of.keep.checkpoint_path.clear();
  Keeper keeper(of.keep, sha256, 1.0, of.cycle, nullptr, &of.troubles);
  keeper.keep_last(of.cycle);
  EXPECT_EQ(of.folder.files(), 0);
  EXPECT_EQ(log.text(), "") << "there is nothing to determine";
}

TEST(LookForCheckpoint, one_that_cannot_be_used_is_kept_under_a_number) {
  const tests::TemporaryFolder folder;
  KeepPlan plan;
  plan.checkpoint_path = folder.file("twin.checkpoint");
  std::ofstream(plan.checkpoint_path) << "restored by hand, and not readable";
  EXPECT_FALSE(look_for_checkpoint(plan).has_value());
  ASSERT_EQ(earlier_histories(plan.checkpoint_path), std::vector<std::string>{folder.file("twin.000001.checkpoint")});
  std::string kept;
  std::getline(std::ifstream(folder.file("twin.000001.checkpoint")) >> std::ws, kept);
  EXPECT_EQ(kept, "restored by hand, and not readable");
  EXPECT_FALSE(look_for_checkpoint(plan).has_value());
  EXPECT_EQ(earlier_histories(plan.checkpoint_path).size(), 1U) << "there is none now";
}

}  // namespace keep_keeper_test
}  // namespace spindle_twin::firmware
