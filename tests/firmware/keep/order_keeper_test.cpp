#include "firmware/keep/order_keeper.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "tests/firmware/support/logged.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::firmware {
namespace keep_order_keeper_test {

const std::string ours(64, 'a'), of_before(64, 'b'), of_others(64, 'c');

StandingOrders tared() {
  StandingOrders orders;
  orders.revision = 3;
  orders.correction = orders.compensation = SwitchOrder::off;
  orders.tare_m = 2e-6;
  orders.sensor_tares = 1;
  orders.sensor_tare_K[1] = 0.25;
  orders.sensor_tare_deviation_K[1] = 0.02;
  return orders;
}

Checkpoint that_knows(std::uint32_t revision, const std::string& network = ours) {
  Checkpoint checkpoint;
  checkpoint.network_sha256 = network;
  checkpoint.order_revision = revision;
  checkpoint.remembered.tare_m = 4e-6;
  checkpoint.remembered.sensor_tare = {2, {0.5, 0.6}, {0.05, 0.06}};
  return checkpoint;
}

struct InFile {
  explicit InFile(const StandingOrders& orders, const std::string& network = ours) {
    write_orders({network, 1.0, orders}, path);
  }
  StandingOrders recalled(const std::optional<Checkpoint>& checkpoint, const std::string& before = {}) const {
    return recall_orders(path, ours, checkpoint, before);
  }
  tests::TemporaryFolder folder;
  std::string path = folder.file("twin.orders");
};

TEST(RecallOrders, as_many_as_the_checkpoint_knew_of_or_more_are_all_and_one_less_is_a_loss) {
  const InFile file(tared());
  for (const std::uint32_t known : {0U, 2U, 3U}) {
    const StandingOrders orders = file.recalled(that_knows(known));
    EXPECT_FALSE(orders.lost) << known;
    EXPECT_EQ(orders.tare_m, 2e-6);
    EXPECT_EQ(orders.revision, 3U);
  }
  const StandingOrders orders = file.recalled(that_knows(4));
  EXPECT_TRUE(orders.lost);
  EXPECT_EQ(orders.revision, 4U) << "the next order is the fifth";
  EXPECT_EQ(orders.tare_m, 4e-6) << "the checkpoint's tares stand in";
  EXPECT_EQ(orders.sensor_tares, 2U);
  EXPECT_EQ(orders.sensor_tare_K[1], 0.6);
  EXPECT_EQ(orders.sensor_tare_deviation_K[1], 0.06);
  EXPECT_EQ(orders.correction, SwitchOrder::off) << "the switch as it was told last";
  EXPECT_EQ(orders.compensation, SwitchOrder::off) << "and so is the other";
}

TEST(RecallOrders, a_file_that_is_missing_is_a_loss_from_the_first_order_on) {
  const tests::TemporaryFolder folder;
  for (const std::uint32_t known : {0U, 1U}) {
    const StandingOrders orders = recall_orders(folder.file("twin.orders"), ours, that_knows(known));
    EXPECT_EQ(orders.lost, known > 0);
    EXPECT_EQ(orders.tare_m, 4e-6);
    EXPECT_EQ(orders.revision, known);
  }
  const StandingOrders of_another = recall_orders(folder.file("twin.orders"), ours, that_knows(1, of_others));
  EXPECT_EQ(of_another.tare_m, 0.0) << "a tare of another network's nose stands in for nothing";
}

TEST(RecallOrders, of_another_network_the_switches_hold_and_its_tares_are_lost_where_there_are_any) {
  StandingOrders only_switched = tared();
  only_switched.tare_m = 0.0;
  only_switched.sensor_tare_K.fill(0.0);
  StandingOrders only_sensors = tared();
  only_sensors.tare_m = 0.0;
  StandingOrders only_nose = tared();
  only_nose.sensor_tare_K.fill(0.0);
  for (const StandingOrders& of : {tared(), only_switched, only_sensors, only_nose}) {
    const StandingOrders orders = InFile(of, of_others).recalled(std::nullopt);
    EXPECT_EQ(orders.lost, of.tare_m != 0.0 || of.sensor_tare_K[1] != 0.0);
    EXPECT_EQ(orders.tare_m, 0.0);
    EXPECT_EQ(orders.sensor_tares, 0U);
    EXPECT_EQ(orders.sensor_tare_K[1], 0.0);
    EXPECT_EQ(orders.sensor_tare_deviation_K[1], 0.0);
    EXPECT_EQ(orders.correction, SwitchOrder::off);
    EXPECT_EQ(orders.compensation, SwitchOrder::off);
    EXPECT_EQ(orders.revision, 3U);
  }
}

TEST(RecallOrders, of_the_network_before_an_exchange_all_hold) {
  const InFile file(tared(), of_before);
  const StandingOrders orders = file.recalled(std::nullopt, of_before);
  EXPECT_FALSE(orders.lost);
  EXPECT_EQ(orders.tare_m, 2e-6);
  EXPECT_TRUE(file.recalled(std::nullopt, of_others).lost) << "it took the place of another one";
  EXPECT_FALSE(std::filesystem::exists(file.path)) << "it is kept under a number, not written over";
  EXPECT_TRUE(InFile(tared(), of_before).recalled(std::nullopt).lost);
  EXPECT_FALSE(InFile(tared()).recalled(std::nullopt, of_before).lost) << "they are of this one already";
}

TEST(RecallOrders, a_loss_that_nobody_acknowledged_stays_one) {
  StandingOrders orders = tared();
  orders.lost = true;
  EXPECT_TRUE(InFile(orders).recalled(that_knows(3)).lost);
}

TEST(RecallOrders, without_a_path_nothing_holds) {
  EXPECT_EQ(recall_orders("", ours, that_knows(3)).tare_m, 0.0);
  EXPECT_FALSE(recall_orders("", ours, that_knows(3)).lost);
}

TEST(RecallOrders, the_log_says_what_is_in_use) {
  const InFile file(tared());
  const Logged log;
  file.recalled(std::nullopt);
  EXPECT_EQ(log.text(),
            "info orders " + file.path + ": tare 2.00 um, 1 tares of the sensors, correction off, compensation off\n");
  StandingOrders on = tared();
  on.correction = SwitchOrder::on;
  const InFile other(on);
  const Logged again;
  other.recalled(std::nullopt);
  EXPECT_NE(again.text().find("correction on,"), std::string::npos) << again.text();
}

TEST(RecallOrders, a_checkpoint_whose_tares_have_no_deviations_has_none_of_sensors) {
  Checkpoint checkpoint = that_knows(0);
  checkpoint.remembered.sensor_tare.deviation_K.pop_back();
  const tests::TemporaryFolder folder;
  const StandingOrders orders = recall_orders(folder.file("twin.orders"), ours, checkpoint);
  EXPECT_EQ(orders.tare_m, 4e-6);
  EXPECT_EQ(orders.sensor_tare_K[0], 0.0);
}

TEST(OrderKeeper, begins_with_a_file_where_there_is_anything_to_say_and_with_none_otherwise) {
  StandingOrders of_revision, of_loss, of_nose, of_sensor;
  of_revision.revision = 1;
  of_loss.lost = true;
  of_nose.tare_m = -1e-6;
  of_sensor.sensor_tare_K[slots::key_points - 1] = 0.1;
  const auto writes = [](const StandingOrders& recalled) {
    const tests::TemporaryFolder folder;
    OrderDesk desk;
    Troubles troubles;
    OrderKeeper keeper(folder.file("twin.orders"), ours, desk, troubles);
    keeper.begin_with(recalled);
    EXPECT_EQ(keeper.revision(), recalled.revision);
    EXPECT_EQ(troubles.faults(), 0);
    return std::filesystem::exists(folder.file("twin.orders"));
  };
  EXPECT_FALSE(writes({}));
  for (const StandingOrders& each : {of_revision, of_loss, of_nose, of_sensor}) EXPECT_TRUE(writes(each));
}

TEST(OrderKeeper, what_was_left_when_it_is_stopped_is_still_written_under_the_network_that_it_names) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("twin.orders");
  const std::atomic<bool> stop{true};
  for (const bool named : {false, true}) {
    OrderDesk desk;
    Troubles troubles;
    OrderKeeper keeper(path, ours, desk, troubles);
    StandingOrders orders = tared();
    if (named) of_others.copy(orders.network_sha256.data(), orders.network_sha256.size());
    desk.standing().write(orders);
    keeper.run(stop);
    EXPECT_EQ(keeper.revision(), 3U);
    EXPECT_EQ(read_orders(path)->network_sha256, named ? of_others : ours);
  }
}

TEST(OrderKeeper, where_nothing_was_ordered_a_stop_leaves_no_file) {
  const tests::TemporaryFolder folder;
  OrderDesk desk;
  Troubles troubles;
  OrderKeeper keeper(folder.file("twin.orders"), ours, desk, troubles);
  keeper.begin_with({});
  const std::atomic<bool> stop{true};
  keeper.run(stop);
  EXPECT_EQ(folder.files(), 0);
}

TEST(OrderKeeper, what_could_not_be_written_at_the_start_is_tried_again_at_the_stop_at_the_latest) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.file("away/twin.orders");
  const Logged log;
  OrderDesk desk;
  Troubles troubles;
  OrderKeeper keeper(path, ours, desk, troubles);
  keeper.begin_with(tared());
  EXPECT_EQ(troubles.faults(), bits(Fault::orders_not_kept));
  EXPECT_EQ(keeper.revision(), 0U);
  std::filesystem::create_directory(folder.file("away"));
  const std::atomic<bool> stop{true};
  keeper.run(stop);
  EXPECT_EQ(troubles.faults(), 0);
  EXPECT_EQ(keeper.revision(), 3U);
  EXPECT_EQ(read_orders(path)->orders.tare_m, 2e-6);
}

}  // namespace keep_order_keeper_test
}  // namespace spindle_twin::firmware
