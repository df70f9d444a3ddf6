#include "firmware/keep/orders_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "firmware/keep/order_keeper.hpp"
#include "firmware/keep/state_files.hpp"
#include "rom/read/input_error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_orders_file_test {

const std::string network(64, 'a');
const std::string other_network(64, 'b');

StandingOrders ordered() {
  StandingOrders orders;
  orders.revision = 7;
  orders.correction = SwitchOrder::off;
  orders.tare_m = 12.5e-6;
  orders.sensor_tares = 3;
  orders.sensor_tare_K[2] = -0.125;
  orders.sensor_tare_deviation_K[2] = 0.015;
  orders.acknowledgements = 2;
  return orders;
}

bool is_damaged(const std::vector<std::uint8_t>& bytes) {
  try {
    decode_orders(bytes, "x");
    return false;
  } catch (const rom::InputError&) {
    return true;
  }
}

TEST(OrdersFile, comes_back_as_it_was_and_no_damaged_bit_is_taken_for_an_order) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.orders");
  EXPECT_FALSE(read_orders(path).has_value());
  write_orders({network, 1.7e9, ordered()}, path);
  const auto kept = read_orders(path);
  ASSERT_TRUE(kept.has_value());
  EXPECT_EQ(kept->network_sha256, network);
  EXPECT_EQ(kept->orders.revision, 7U);
  EXPECT_EQ(kept->orders.correction, SwitchOrder::off);
  EXPECT_EQ(kept->orders.tare_m, 12.5e-6);
  EXPECT_EQ(kept->orders.sensor_tares, 3U);
  EXPECT_EQ(kept->orders.sensor_tare_K, ordered().sensor_tare_K);
  EXPECT_EQ(kept->orders.sensor_tare_deviation_K, ordered().sensor_tare_deviation_K);
  EXPECT_EQ(kept->orders.acknowledgements, 2U);
  EXPECT_FALSE(kept->orders.lost);
  const std::vector<std::uint8_t> good = encode_orders({network, 1.7e9, ordered()});
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::vector<std::uint8_t> bad = good;
    bad[at] ^= static_cast<std::uint8_t>(1U << (at % 8));
    EXPECT_TRUE(is_damaged(bad)) << at;
    bad = good;
    bad.resize(at);
    EXPECT_TRUE(is_damaged(bad)) << at;
  }
}

TEST(OrdersFile, a_tare_that_no_order_can_set_is_malformed_whatever_its_hash) {
  StandingOrders orders = ordered();
  orders.tare_m = 0.34;
  EXPECT_TRUE(is_damaged(encode_orders({network, 1.7e9, orders})));
  orders = ordered();
  orders.sensor_tare_K[0] = 1e6;
  EXPECT_TRUE(is_damaged(encode_orders({network, 1.7e9, orders})));
}

TEST(RecallOrders, holds_whatever_the_age_of_the_checkpoint_and_a_loss_is_told) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.orders");
  EXPECT_FALSE(recall_orders(path, network, std::nullopt).lost) << "nothing was ordered yet";
  Checkpoint checkpoint;
  checkpoint.network_sha256 = network;
  checkpoint.remembered.tare_m = 4e-6;
  EXPECT_EQ(recall_orders(path, network, checkpoint).tare_m, 4e-6) << "of a program without an orders' file";
  EXPECT_FALSE(recall_orders(path, network, checkpoint).lost);

  checkpoint.order_revision = 7;
  EXPECT_TRUE(recall_orders(path, network, checkpoint).lost) << "the file was there";
  EXPECT_EQ(recall_orders(path, network, checkpoint).tare_m, 4e-6);

  write_orders({network, 1.0, ordered()}, path);
  for (const auto& beside : {std::optional<Checkpoint>(), std::optional(checkpoint)}) {
    const StandingOrders orders = recall_orders(path, network, beside);
    EXPECT_EQ(orders.tare_m, 12.5e-6);
    EXPECT_EQ(orders.correction, SwitchOrder::off);
    EXPECT_FALSE(orders.lost);
  }
  checkpoint.order_revision = 8;
  EXPECT_TRUE(recall_orders(path, network, checkpoint).lost) << "an older file was put back";

  const StandingOrders other = recall_orders(path, other_network, std::nullopt);
  EXPECT_TRUE(other.lost) << "the tare is of another network's nose";
  EXPECT_EQ(other.tare_m, 0.0);
  EXPECT_EQ(other.correction, SwitchOrder::off) << "the switch is not";

  std::ofstream(path, std::ios::app) << "x";
  EXPECT_TRUE(recall_orders(path, network, std::nullopt).lost);
}

TEST(OrderKeeper, tells_the_desk_when_orders_are_on_the_disk_and_that_they_are_not) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("away/twin.orders");  // there is no such folder yet
  OrderDesk desk;
  Troubles troubles;
  OrderKeeper keeper(path, network, desk, troubles);
  keeper.begin_with({});
  std::atomic<bool> stop{false};
  std::thread keeping([&] { keeper.run(stop); });
  const auto wait_for = [](const auto& wanted) {
    for (int i = 0; i < 1000 && !wanted(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return wanted();
  };
  desk.standing().write(ordered());
  EXPECT_TRUE(wait_for([&] { return (troubles.faults() & bits(Fault::orders_not_kept)) != 0; }));
  EXPECT_EQ(keeper.revision(), 0U);
  std::filesystem::create_directory(folder.file("away"));
  EXPECT_TRUE(wait_for([&] { return keeper.revision() == 7; })) << "it is tried again";
  EXPECT_EQ(troubles.faults(), 0);
  EXPECT_EQ(read_orders(path)->orders.tare_m, 12.5e-6);
  stop.store(true);
  keeping.join();
}

TEST(OrderKeeper, a_loss_is_on_the_disk_before_anything_runs) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.orders");
  std::ofstream(path) << "nonsense";
  OrderDesk desk;
  Troubles troubles;
  OrderKeeper keeper(path, network, desk, troubles);
  keeper.begin_with(recall_orders(path, network, std::nullopt));
  EXPECT_TRUE(recall_orders(path, network, std::nullopt).lost) << "nobody has acknowledged it";
}

TEST(StateFiles, a_second_writer_is_refused_by_the_file_and_not_by_the_configuration) {
  const tests::TemporaryFolder folder;
  const std::string history = folder.file("history.csv");
  const StateLock first({history, folder.file("one.orders")});
  EXPECT_NO_THROW(const StateLock beside({folder.file("other.csv")}));
  try {
    const StateLock second({folder.file("two.orders"), history});
    FAIL() << "no error";
  } catch (const rom::InputError& error) {
    EXPECT_EQ(std::string(error.what()), history + ": another spindle-twind already writes this file");
  }
  EXPECT_NO_THROW(const StateLock two({folder.file("two.orders")})) << "what was locked on the way is free again";
}

TEST(StateFiles, only_what_a_killed_writer_left_is_removed) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.checkpoint");
  const std::string of_chance = path + ".unfinished-aB3dE6";
  const std::string small_letters = path + ".unfinished-xzbwtu";
  for (const std::string& name : {of_chance, small_letters}) std::ofstream(name) << "x";
  for (const char* name : {".orders", ".lock", ".backup", ".aB3dE6", ".unfinished-aB3dE", ".unfinished-aB3d-6",
                           ".unfinished-aB3dE67", ".orders.unfinished-aB3dE6"}) {
    std::ofstream(path + name) << "x";
  }
  std::ofstream(path) << "x";
  EXPECT_EQ(remove_left_overs(path), 2);
  EXPECT_TRUE(std::filesystem::exists(path));
  EXPECT_TRUE(std::filesystem::exists(path + ".orders"));
  EXPECT_TRUE(std::filesystem::exists(path + ".backup"));
  EXPECT_TRUE(std::filesystem::exists(path + ".orders.unfinished-aB3dE6"));
  EXPECT_FALSE(std::filesystem::exists(of_chance));
  EXPECT_FALSE(std::filesystem::exists(small_letters)) << "one of 200 that mkstemp makes";
}

TEST(StateFiles, a_pipe_in_the_place_of_a_file_is_refused_and_does_not_hang) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.checkpoint");
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_THROW(read_checkpoint(path), rom::InputError);
  EXPECT_THROW(read_orders(path), rom::InputError);
}

}  // namespace keep_orders_file_test
}  // namespace spindle_twin::firmware
