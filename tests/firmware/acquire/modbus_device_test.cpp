#include "firmware/acquire/modbus_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "firmware/acquire/device_thread.hpp"
#include "firmware/serve/modbus_server.hpp"

namespace spindle_twin::firmware {
namespace acquire_modbus_device_test {

RegisterSource source(RegisterTable table, int address, RegisterType type) {
  return {table, static_cast<std::uint16_t>(address), type};
}

TEST(Decode, every_type) {
  const std::array<std::uint16_t, 2> words{0xC148, 0x0000};
  const std::array<std::uint16_t, 2> swapped{0x0000, 0xC148};
  EXPECT_DOUBLE_EQ(decode(source(RegisterTable::input, 0, RegisterType::float32), words), -12.5);
  EXPECT_DOUBLE_EQ(decode(source(RegisterTable::input, 0, RegisterType::float32_cdab), swapped), -12.5);
  EXPECT_DOUBLE_EQ(decode(source(RegisterTable::input, 0, RegisterType::int16), words), -16056.0);
  EXPECT_DOUBLE_EQ(decode(source(RegisterTable::input, 0, RegisterType::uint16), words), 49480.0);
  EXPECT_DOUBLE_EQ(decode(source(RegisterTable::input, 0, RegisterType::offset16), words), 16712.0);
  EXPECT_DOUBLE_EQ(decode(source(RegisterTable::input, 0, RegisterType::uint32), words), 3242721280.0);
  EXPECT_DOUBLE_EQ(decode(source(RegisterTable::input, 0, RegisterType::int32), words), -1052246016.0);
}

TEST(ReadPlan, neighbours_are_read_together_and_gaps_are_never_asked_for) {
  const auto requests = plan_requests(
      {source(RegisterTable::input, 12, RegisterType::float32), source(RegisterTable::input, 10, RegisterType::float32),
       source(RegisterTable::input, 15, RegisterType::int16), source(RegisterTable::holding, 14, RegisterType::int16)});
  ASSERT_EQ(requests.size(), 3U);
  EXPECT_EQ(requests[0].address, 10);
  EXPECT_EQ(requests[0].count, 4);
  EXPECT_EQ(requests[0].channels, (std::vector<std::size_t>{1, 0}));
  EXPECT_EQ(requests[1].address, 15);
  EXPECT_EQ(requests[2].table, RegisterTable::holding);
}

TEST(ReadPlan, no_request_is_longer_than_modbus_allows) {
  std::vector<RegisterSource> channels;
  for (int i = 0; i < 100; ++i) channels.push_back(source(RegisterTable::input, 2 * i, RegisterType::float32));
  for (const ReadRequest& request : plan_requests(channels)) {
    EXPECT_LE(request.count, 125);
    EXPECT_EQ(request.count, 2 * request.channels.size());
  }
}

TEST(BackOff, doubles_up_to_the_devices_most) {
  DevicePlan plan;
  EXPECT_DOUBLE_EQ(back_off_s(plan, 0), 0.1);
  EXPECT_DOUBLE_EQ(back_off_s(plan, 1), 0.2);
  EXPECT_DOUBLE_EQ(back_off_s(plan, 5), 3.2);
  EXPECT_DOUBLE_EQ(back_off_s(plan, 6), 5.0);
  EXPECT_DOUBLE_EQ(back_off_s(plan, 1000000), 5.0);
  plan.retry_s = 1.0;
  plan.retry_most_s = 60.0;
  EXPECT_DOUBLE_EQ(back_off_s(plan, 3), 8.0);
  EXPECT_DOUBLE_EQ(back_off_s(plan, 6), 60.0);
}

TEST(CheckAnswer, only_what_answers_the_question_in_every_field_is_taken) {
  const ReadQuestion question{0x1234, 7, RegisterTable::input, 10, 2};
  EXPECT_EQ(encode(question), (std::array<std::uint8_t, 12>{0x12, 0x34, 0, 0, 0, 6, 7, 4, 0, 10, 0, 2}));
  const std::vector<std::uint8_t> good{0x12, 0x34, 0, 0, 0, 7, 7, 4, 4, 1, 2, 3, 4};
  EXPECT_EQ(check_answer(question, good).is, Answer::values);
  EXPECT_EQ(word_of(good, 1), 0x0304);
  for (std::size_t bytes = 0; bytes < good.size(); ++bytes) {
    EXPECT_EQ(check_answer(question, std::span(good).first(bytes)).is, Answer::not_whole) << bytes;
  }
  for (std::size_t at = 0; at < 9; ++at) {  // transaction, protocol, length, unit, function, byte count
    std::vector<std::uint8_t> bad = good;
    bad[at] ^= 1;
    EXPECT_EQ(check_answer(question, bad).is, Answer::wrong) << at;
  }
  std::vector<std::uint8_t> longer = good;
  longer.push_back(0);
  EXPECT_EQ(check_answer(question, longer).is, Answer::wrong);
  const std::vector<std::uint8_t> refusal{0x12, 0x34, 0, 0, 0, 3, 7, 0x84, 2};
  EXPECT_EQ(check_answer(question, refusal).is, Answer::refused);
  EXPECT_EQ(check_answer(question, refusal).exception, 2);
  EXPECT_EQ(check_answer(question, std::vector<std::uint8_t>{0x12, 0x34, 0, 0, 0, 4, 7, 0x84, 2, 0}).is, Answer::wrong);
}

/// The daemon's own server, which knows some answers, stands for the device.
struct Device {
  MonotonicClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;
  ModbusServer server;
  std::thread thread;

  explicit Device(int port)
      : server(plan(port), clock, {{units_of_one_spindle(), snapshots, signals, orders}}),
        thread([this] { server.run(); }) {}
  ~Device() {
    server.stop();
    thread.join();
  }
  static ServePlan plan(int port) {
    ServePlan plan;
    plan.port = port;
    plan.allow = {*parse_address_range("127.0.0.1")};
    return plan;
  }
};

template <class Wanted>
bool wait_for(Latest<DeviceFrame>& frames, DeviceFrame& frame, Wanted wanted) {
  for (int i = 0; i < 1000; ++i) {
    if (frames.read(frame) && wanted(frame)) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST(ModbusDevice, reads_reports_a_loss_and_connects_again) {
  auto device = std::make_unique<Device>(0);
  const auto modbus = std::make_shared<ModbusPlan>();
  modbus->port = device->server.port();
  modbus->timeout_s = 0.2;
  modbus->sources = {source(RegisterTable::input, 2, RegisterType::float32),
                     source(RegisterTable::holding, 1, RegisterType::int16),
                     source(RegisterTable::input, 60000, RegisterType::int16)};
  DevicePlan plan;
  plan.poll_s = 0.02;
  plan.driver = modbus;
  for (std::size_t i = 0; i < 3; ++i) plan.channels.push_back({Channel::Kind::sensor, i, "sensor", {}, {}});
  MonotonicClock clock;
  Latest<DeviceFrame> frames;
  DeviceThread acquisition(plan, 2, clock, frames);
  std::atomic<bool> stop{false};
  std::thread thread([&] { acquisition.run(stop); });

  DeviceFrame frame;
  EXPECT_TRUE(wait_for(frames, frame, [](const DeviceFrame& f) { return f.connected; }));
  EXPECT_EQ(frame.sensors[0].value, -12.5);
  EXPECT_EQ(frame.sensors[1].value, -125.0);
  EXPECT_EQ(frame.sensors[2].time_ns, 0) << "a register that the device refuses must stay unread";
  EXPECT_TRUE(frame.devices[2].connected);
  EXPECT_GE(frame.devices[2].accepted, 2U);
  EXPECT_GE(frame.devices[2].refused, 1U);
  device.reset();
  EXPECT_TRUE(wait_for(frames, frame, [](const DeviceFrame& f) { return !f.connected; }));
  EXPECT_EQ(frame.sensors[0].value, -12.5) << "the last reading stays";
  device = std::make_unique<Device>(modbus->port);
  EXPECT_TRUE(wait_for(frames, frame, [](const DeviceFrame& f) { return f.connected; }));
  stop.store(true);
  thread.join();
}

/// Of a process that stands still for half a minute right before it looks at the clock for the n-th time.
struct StoppedClock final : Clock {
  explicit StoppedClock(int stops_before) : left(stops_before) {}
  std::int64_t now_ns() const override {
    if (left-- == 0) stopped_ns = 30 * ns_per_s;
    return MonotonicClock().now_ns() + stopped_ns;
  }
  void sleep_until_ns(std::int64_t) override {}

  mutable int left;
  mutable std::int64_t stopped_ns = 0;
};

TEST(ModbusDevice, an_answer_that_waited_while_the_process_stood_still_is_no_reading_of_now) {
  Device device(0);
  ModbusPlan plan;
  plan.port = device.server.port();
  plan.timeout_s = 0.5;
  plan.sources = {source(RegisterTable::input, 2, RegisterType::float32)};
  int read = 0;
  for (int stops_before = 0; stops_before < 8; ++stops_before) {
    StoppedClock clock(stops_before);
    ModbusDevice driver(plan, clock);
    DeviceReadings readings("device", 0, {{Channel::Kind::sensor, 0, "sensor", {}, {}}}, 0.0);
    const bool stopped_before_it_asked = stops_before == 0;
    const std::int64_t before_ns = MonotonicClock().now_ns();
    if (driver.step(readings).is == Step::Is::lost) continue;
    ++read;
    const std::int64_t said_ns = readings.frame().sensors[0].time_ns;
    EXPECT_TRUE(stopped_before_it_asked || said_ns <= before_ns + ns_per_s / 2) << stops_before;
  }
  EXPECT_GE(read, 2) << "stopped before the question or behind the answer";
}

}  // namespace acquire_modbus_device_test
}  // namespace spindle_twin::firmware
