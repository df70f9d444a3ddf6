#include "firmware/acquire/device_thread.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

#include "firmware/cycle/device_inbox.hpp"
#include "tests/firmware/support/logged.hpp"

namespace spindle_twin::firmware {
namespace acquire_device_thread_test {

using Script = std::function<Step(DeviceReadings&)>;

class ScriptedDriver final : public Driver {
 public:
  explicit ScriptedDriver(Script script) : script_(std::move(script)) {}
  Step step(DeviceReadings& readings) override { return script_(readings); }

 private:
  Script script_;
};

struct ScriptedPlan final : DriverPlan {
  explicit ScriptedPlan(Script steps) : script(std::move(steps)) {}
  ChannelSource add_channel(const rom::TomlTable&) override { return {}; }
  std::unique_ptr<Driver> make_driver(Clock&) const override { return std::make_unique<ScriptedDriver>(script); }
  std::string where() const override { return "nowhere"; }
  Script script;
};

/// Time passes only where the thread sleeps.
class SleepClock final : public Clock {
 public:
  std::int64_t now_ns() const override { return time_ns; }
  void sleep_until_ns(std::int64_t until_ns) override {
    longest_ns = std::max(longest_ns, until_ns - time_ns);
    time_ns = until_ns;
  }
  std::int64_t time_ns = 1'000'000'000, longest_ns = 0;
};

class DeviceThreadTest : public testing::Test {
 protected:
  /// The times of the first steps, in ms after the first.
  std::vector<std::int64_t> run(std::size_t steps, const std::function<Step(std::size_t, DeviceReadings&)>& script) {
    std::vector<std::int64_t> at_ms;
    plan_.driver = std::make_shared<ScriptedPlan>([&](DeviceReadings& readings) {
      at_ms.push_back((clock_.time_ns - 1'000'000'000) / 1'000'000);
      if (at_ms.size() == steps) stop_.store(true);
      return script(at_ms.size() - 1, readings);
    });
    DeviceThread(plan_, 1, clock_, inbox_.of(1)).run(stop_);
    return at_ms;
  }

  SleepClock clock_;
  DeviceInbox inbox_;
  DevicePlan plan_;
  std::atomic<bool> stop_{false};
};

TEST_F(DeviceThreadTest, steps_follow_the_period_and_losses_the_back_off_which_a_good_step_ends) {
  plan_.poll_s = 0.5;
  const auto at_ms = run(8, [](std::size_t step, DeviceReadings&) -> Step {
    if (step == 2 || step == 3) return {Step::Is::lost, "gone"};
    if (step == 4) throw std::runtime_error("what a driver throws is a loss too");
    if (step == 6) return {Step::Is::lost, "gone"};
    return {};
  });
  EXPECT_EQ(at_ms, (std::vector<std::int64_t>{0, 500, 1000, 1100, 1300, 1700, 2200, 2300}));
}

TEST_F(DeviceThreadTest, it_looks_for_a_stop_ten_times_a_second_and_sleeps_no_longer_than_the_period) {
  const auto answers = [](std::size_t, DeviceReadings&) -> Step { return {}; };
  plan_.poll_s = 30.0;
  EXPECT_EQ(run(2, answers), (std::vector<std::int64_t>{0, 30'000}));
  EXPECT_EQ(clock_.longest_ns, 100'000'000);
  clock_ = SleepClock();
  stop_ = false;
  plan_.poll_s = 0.03;
  EXPECT_EQ(run(3, answers), (std::vector<std::int64_t>{0, 30, 60}));
}

TEST_F(DeviceThreadTest, a_step_that_takes_too_long_is_followed_at_once_and_none_is_made_up_for) {
  plan_.poll_s = 0.5;
  const auto at_ms = run(5, [this](std::size_t step, DeviceReadings&) -> Step {
    if (step == 1) clock_.time_ns += 1'200'000'000;
    return {};
  });
  EXPECT_EQ(at_ms, (std::vector<std::int64_t>{0, 500, 1700, 2200, 2700}));
}

TEST_F(DeviceThreadTest, a_change_is_said_once_and_so_is_each_new_reason) {
  const Logged log;
  run(8, [](std::size_t step, DeviceReadings&) -> Step {
    if (step < 2 || step > 5) return {};
    return {Step::Is::lost, step < 4 ? "gone" : "broken"};
  });
  EXPECT_EQ(log.text(),
            "info device device at nowhere answers\n"
            "warning device device at nowhere does not answer (gone); trying on\n"
            "warning device device at nowhere does not answer (broken); trying on\n"
            "info device device at nowhere answers\n");
}

/// Each second another reason; the one behind a minute says how many were not said.
TEST_F(DeviceThreadTest, of_a_device_that_comes_and_goes_six_lines_a_minute_are_said) {
  const Logged log;
  plan_.retry_s = plan_.retry_most_s = 1.0;
  run(62, [](std::size_t step, DeviceReadings&) -> Step { return {Step::Is::lost, std::to_string(step)}; });
  const std::string text = log.text();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7) << text;
  EXPECT_NE(text.find("(5); trying on\n"), std::string::npos) << text;
  EXPECT_NE(text.find("(60); trying on (and 54 times that were not logged)\n"), std::string::npos) << text;
}

TEST_F(DeviceThreadTest, a_lost_device_keeps_its_readings_and_says_that_it_is_offline) {
  plan_.channels = {{Channel::Kind::sensor, 3, "outer", {}, {}}};
  plan_.delay_s = 0.2;
  run(3, [&](std::size_t step, DeviceReadings& readings) -> Step {
    if (step == 1) return {Step::Is::lost, "gone"};
    readings.take(0, 7.0, clock_.now_ns());
    return {};
  });
  DeviceFrame frame;
  inbox_.read(frame);
  EXPECT_EQ(frame.sensors[3].value, 7.0);
  EXPECT_EQ(frame.sensors[3].time_ns, 800'000'000) << "as old as the device's delay makes it";
  EXPECT_FALSE(frame.connected);
  EXPECT_TRUE(frame.devices[1].used);
  EXPECT_FALSE(frame.devices[1].connected);
}

TEST(DeviceInbox, each_value_comes_from_its_own_device_and_the_loss_of_one_leaves_the_others) {
  DeviceInbox inbox;
  DeviceFrame first, second, all;
  inbox.read(all);
  EXPECT_FALSE(all.connected) << "nobody has said anything";
  first.sensors[0] = {1.0, 10};
  first.devices[0] = {true, true, 1, 0};
  second.sensors[1] = {2.0, 20};
  second.signals[2] = {3.0, 20};
  second.devices[1] = {true, true, 1, 0};
  inbox.of(0).write(first);
  inbox.of(1).write(second);
  inbox.read(all);
  EXPECT_EQ(all.sensors[0].value, 1.0);
  EXPECT_EQ(all.sensors[1].value, 2.0);
  EXPECT_EQ(all.signals[2].value, 3.0);
  EXPECT_TRUE(all.connected);
  first.devices[0].connected = false;
  second.sensors[1] = {2.5, 30};
  inbox.of(0).write(first);
  inbox.of(1).write(second);
  inbox.read(all);
  EXPECT_FALSE(all.connected);
  EXPECT_TRUE(all.devices[1].connected);
  EXPECT_EQ(all.sensors[0].value, 1.0);
  EXPECT_EQ(all.sensors[0].time_ns, 10);
  EXPECT_EQ(all.sensors[1].value, 2.5);
}

TEST(DeviceReadings, times_rise_and_what_is_more_than_a_second_older_is_none) {
  DeviceReadings readings("node", 0, {{Channel::Kind::sensor, 0, "a", {}, {}}}, 0.0);
  const Reading& sensor = readings.frame().sensors[0];
  constexpr std::int64_t last_ns = 5'000'000'000;
  readings.take(0, 1.0, last_ns);
  EXPECT_EQ(sensor.time_ns, last_ns);
  readings.take(0, 2.0, last_ns - 1'000'000'001);
  EXPECT_EQ(sensor.value, 1.0);
  readings.take(0, 3.0, last_ns - 1'000'000'000);
  EXPECT_EQ(sensor.value, 3.0);
  EXPECT_EQ(sensor.time_ns, last_ns + 1);
  readings.take(0, 4.0, last_ns + 2);
  EXPECT_EQ(sensor.time_ns, last_ns + 2);
}

TEST(DeviceReadings, a_reading_has_a_time_even_at_the_clocks_begin) {
  DeviceReadings readings("node", 0, {{Channel::Kind::sensor, 0, "a", {}, {}}}, 0.5);
  readings.take(0, 1.0, 100);
  EXPECT_EQ(readings.frame().sensors[0].time_ns, 1) << "0 says: never read";
}

TEST(DeviceReadings, each_kind_of_channel_has_its_own_place) {
  DeviceReadings readings("node", 2,
                          {{Channel::Kind::sensor, 1, "a", {}, {}},
                           {Channel::Kind::displacement, 1, "b", {}, {}},
                           {Channel::Kind::signal, 1, "c", {}, {}}},
                          0.0);
  for (std::size_t channel = 0; channel < 3; ++channel) readings.take(channel, 7.0 + static_cast<double>(channel), 5);
  const DeviceFrame& frame = readings.frame();
  EXPECT_EQ(frame.sensors[1].value, 7.0);
  EXPECT_EQ(frame.displacements[1].value, 8.0);
  EXPECT_EQ(frame.signals[1].value, 9.0);
  EXPECT_TRUE(frame.devices[2].used);
  EXPECT_FALSE(frame.devices[0].used);
}

TEST(DeviceReadings, a_fault_of_a_wire_is_said_when_it_comes_and_when_it_goes) {
  const Logged log;
  Channel channel{Channel::Kind::sensor, 0, "inner", {}, {}};
  channel.conversion.kind = ConversionKind::pt100;
  DeviceReadings readings("cabinet", 0, {channel}, 0.0);
  std::int64_t now_ns = 5'000'000'000;
  for (const double ohm : {100.0, 1e6, 1e6, 100.0, 100.0}) readings.take(0, ohm, now_ns += 1'000'000);
  EXPECT_EQ(log.text(),
            "warning device cabinet: inner is open or at failure current\n"
            "info device cabinet: inner is good\n");
}

TEST(DeviceReadings, of_a_wire_that_comes_and_goes_six_lines_a_minute_are_said) {
  const Logged log;
  Channel channel{Channel::Kind::sensor, 0, "inner", {}, {}};
  channel.conversion.kind = ConversionKind::pt100;
  DeviceReadings readings("cabinet", 0, {channel}, 0.0);
  for (int second = 0; second <= 60; ++second) {
    readings.take(0, second % 2 == 0 ? 1e6 : 100.0, (5 + second) * std::int64_t{1'000'000'000});
  }
  const std::string text = log.text();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 7) << text;
  EXPECT_NE(text.find("(and 54 times that were not logged)\n"), std::string::npos) << text;
}

TEST(DeviceReadings, a_broken_wire_shows_at_once_whatever_the_filter_and_a_good_one_begins_anew) {
  Channel channel{Channel::Kind::sensor, 0, "inner", {}, {FilterPlan::Kind::mean, 1.0}};
  channel.conversion.kind = ConversionKind::pt100;
  DeviceReadings readings("cabinet", 0, {channel}, 0.0);
  const Reading& sensor = readings.frame().sensors[0];
  constexpr std::int64_t ms = 1'000'000;
  std::int64_t now_ns = 5'000 * ms;
  for (int i = 0; i < 15; ++i, now_ns += 100 * ms) readings.take(0, 100.0, now_ns);
  EXPECT_DOUBLE_EQ(sensor.value, 0.0);
  readings.take(0, 1e6, now_ns);
  EXPECT_DOUBLE_EQ(sensor.value, 850.0);
  EXPECT_EQ(sensor.time_ns, now_ns);
  for (int i = 0; i < 15; ++i) readings.take(0, 138.5055, now_ns += 100 * ms);
  EXPECT_NEAR(sensor.value, 100.0, 1e-3) << "nothing of the broken wire is in the mean";
}

}  // namespace acquire_device_thread_test
}  // namespace spindle_twin::firmware
