#include "firmware/watch/service_manager.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace spindle_twin::firmware {
namespace watch_service_manager_test {

class ServiceManagerTest : public testing::Test {
 protected:
  ServiceManager with(double cycle_s, double watchdog_s) {
    return {{&pulse_}, cycle_s, watchdog_s, [this](const std::string& state) { told_.push_back(state); }};
  }
  void cycle(bool predicts) {
    pulse_.predicts = predicts;
    ++pulse_.cycles;
  }
  long count(const std::string& part) const {
    return std::count_if(told_.begin(), told_.end(),
                         [&](const std::string& state) { return state.find(part) != std::string::npos; });
  }

  Pulse pulse_;
  std::vector<std::string> told_;
};

TEST_F(ServiceManagerTest, is_ready_after_the_first_prediction_and_says_so_once) {
  ServiceManager manager = with(1.0, 0.0);
  manager.look();
  EXPECT_TRUE(told_.empty());
  cycle(false);
  manager.look();
  EXPECT_EQ(count("READY=1"), 0);
  EXPECT_EQ(count("EXTEND_TIMEOUT_USEC=31000000"), 1);
  for (int k = 0; k < 3; ++k) {
    cycle(true);
    manager.look();
  }
  EXPECT_EQ(count("READY=1"), 1);
  EXPECT_EQ(count("EXTEND_TIMEOUT_USEC"), 1);
  EXPECT_EQ(count("WATCHDOG"), 0);
}

TEST_F(ServiceManagerTest, is_ready_too_when_no_reading_comes_so_that_the_fault_can_be_read) {
  ServiceManager manager = with(1.0, 0.0);
  pulse_.waits = true;
  cycle(false);
  manager.look();
  EXPECT_EQ(count("READY=1\nSTATUS=no good reading"), 1);
  pulse_.waits = false;
  cycle(true);
  manager.look();
  EXPECT_EQ(count("READY=1"), 1);
  EXPECT_EQ(told_.back(), "STATUS=predicts");
}

TEST_F(ServiceManagerTest, feeds_the_watchdog_with_cycles_only) {
  ServiceManager manager = with(1.0, 8.0);
  EXPECT_LE(manager.look_s(), 2.0);
  for (int k = 0; k < 5; ++k) {
    cycle(true);
    manager.look();
  }
  EXPECT_EQ(count("WATCHDOG=1"), 5);
  for (int k = 0; k < 20; ++k) manager.look();
  EXPECT_EQ(count("WATCHDOG=1"), 5) << "no cycle was made meanwhile";
}

TEST_F(ServiceManagerTest, asks_for_three_cycles_where_the_watchdog_is_faster) {
  const ServiceManager slow = with(60.0, 10.0);
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_EQ(told_[0], "WATCHDOG_USEC=180000000");
  told_.clear();
  const ServiceManager quick = with(1.0, 10.0);
  EXPECT_TRUE(told_.empty());
}

TEST_F(ServiceManagerTest, looks_four_times_a_watchdog_and_ten_times_a_second_at_least) {
  EXPECT_DOUBLE_EQ(with(0.01, 0.2).look_s(), 0.05);
  EXPECT_DOUBLE_EQ(with(0.01, 0.4).look_s(), 0.1);
  EXPECT_DOUBLE_EQ(with(0.01, 8.0).look_s(), 0.1);
  EXPECT_DOUBLE_EQ(with(0.01, 0.0).look_s(), 0.1) << "without a watchdog too";
  EXPECT_TRUE(told_.empty());
}

TEST_F(ServiceManagerTest, a_watchdog_of_just_three_cycles_is_left_as_it_is) {
  const ServiceManager just = with(4.0, 12.0);
  EXPECT_TRUE(told_.empty());
  const ServiceManager none = with(4.0, 0.0);
  EXPECT_TRUE(told_.empty()) << "nobody asks for one";
}

TEST_F(ServiceManagerTest, says_anew_that_it_waits_when_readings_are_lost_again) {
  ServiceManager manager = with(1.0, 8.0);
  cycle(true);
  manager.look();
  pulse_.waits = true;
  cycle(false);
  manager.look();
  EXPECT_EQ(count("STATUS=no good reading"), 1);
  EXPECT_EQ(count("READY=1"), 1);
  EXPECT_EQ(count("WATCHDOG=1"), 2);
}

TEST_F(ServiceManagerTest, one_spindle_that_stands_is_not_covered_up_by_another) {
  Pulse other;
  ServiceManager manager({&pulse_, &other}, 1.0, 20.0, [this](const std::string& state) { told_.push_back(state); });
  cycle(true);
  manager.look();
  EXPECT_TRUE(told_.empty()) << "the other has made no cycle yet";
  ++other.cycles;
  manager.look();
  EXPECT_EQ(count("READY=1"), 0) << "it has no prediction yet";
  EXPECT_EQ(count("EXTEND_TIMEOUT_USEC"), 1);
  other.predicts = true;
  ++other.cycles;
  cycle(true);
  manager.look();
  EXPECT_EQ(count("READY=1\nSTATUS=predicts"), 1);
  EXPECT_EQ(count("WATCHDOG=1"), 1);
  for (int k = 0; k < 5; ++k) {
    cycle(true);
    manager.look();
  }
  EXPECT_EQ(count("WATCHDOG=1"), 1) << "the other stands still";
  ++other.cycles;
  manager.look();
  EXPECT_EQ(count("WATCHDOG=1"), 2);
}

}  // namespace watch_service_manager_test
}  // namespace spindle_twin::firmware
