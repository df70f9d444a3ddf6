#include "firmware/watch/service_manager.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>
#include <vector>

#include "firmware/serve/descriptor.hpp"
#include "tests/support/temporary_folder.hpp"

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

TEST_F(ServiceManagerTest, one_spindle_that_waits_is_said_of_all_and_keeps_nobody_from_being_ready) {
  for (const bool first_waits : {true, false}) {
    Pulse first, second;
    told_.clear();
    ServiceManager manager({&first, &second}, 1.0, 0.0, [this](const std::string& state) { told_.push_back(state); });
    (first_waits ? first : second).waits = true;
    (first_waits ? second : first).predicts = true;
    ++first.cycles, ++second.cycles;
    manager.look();
    ASSERT_EQ(told_.size(), 1U);
    EXPECT_EQ(told_[0], "READY=1\nSTATUS=no good reading to start from, see the registers");
  }
}

/// As systemd starts a program: with a socket, and where it wants one a watchdog.
class ServiceManagerOfProcess : public ServiceManagerTest {
 protected:
  ServiceManagerOfProcess() : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un here{};
    here.sun_family = AF_UNIX;
    const std::string path = folder_.file("notify");
    path.copy(static_cast<char*>(here.sun_path), sizeof here.sun_path - 1);
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&here), sizeof here), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~ServiceManagerOfProcess() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  /// All that was said, one text behind the other.
  std::string heard() {
    std::string text;
    std::array<char, 1000> part{};
    for (ssize_t got = 0; (got = recv(socket_.get(), part.data(), part.size(), 0)) > 0;) {
      text.append(part.data(), static_cast<std::size_t>(got)) += '|';
    }
    return text;
  }

  tests::TemporaryFolder folder_;
  Descriptor socket_;
};

TEST_F(ServiceManagerOfProcess, hears_what_the_watchdog_asks_for_in_seconds_each_time_anew) {
  ::setenv("WATCHDOG_USEC", "200000", 1);
  for (int n = 0; n < 2; ++n) {
    const ServiceManager slow({&pulse_}, 1.0);
    EXPECT_DOUBLE_EQ(slow.look_s(), 0.05);
    EXPECT_EQ(heard(), "WATCHDOG_USEC=3000000|") << "three cycles";
  }
  ServiceManager quick({&pulse_}, 0.01);
  cycle(true);
  quick.look();
  EXPECT_EQ(heard(), "READY=1\nSTATUS=predicts|WATCHDOG=1|");
}

TEST_F(ServiceManagerOfProcess, without_a_watchdog_none_is_fed) {
  ServiceManager manager({&pulse_}, 0.01);
  cycle(true);
  manager.look();
  cycle(true);
  manager.look();
  EXPECT_EQ(heard(), "READY=1\nSTATUS=predicts|");
}

}  // namespace watch_service_manager_test
}  // namespace spindle_twin::firmware
