#include "firmware/acquire/modbus_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "firmware/serve/modbus_server.hpp"

namespace spindle_twin::firmware {
namespace {

Channel channel(RegisterTable table, int address, RegisterType type, std::size_t index) {
  return {Channel::Kind::sensor, index, {table, static_cast<std::uint16_t>(address), type, 1.0, 0.0}};
}

TEST(Decode, every_type_with_scale_and_offset) {
  const std::array<std::uint16_t, 2> words{0xC148, 0x0000};
  const std::array<std::uint16_t, 2> swapped{0x0000, 0xC148};
  EXPECT_DOUBLE_EQ(decode({RegisterTable::input, 0, RegisterType::float32, 2.0, 1.0}, words), -24.0);
  EXPECT_DOUBLE_EQ(decode({RegisterTable::input, 0, RegisterType::float32_cdab, 1.0, 0.0}, swapped), -12.5);
  EXPECT_DOUBLE_EQ(decode({RegisterTable::input, 0, RegisterType::int16, 0.01, 0.0}, words), -160.56);
  EXPECT_DOUBLE_EQ(decode({RegisterTable::input, 0, RegisterType::uint16, 1.0, 0.0}, words), 49480.0);
  EXPECT_DOUBLE_EQ(decode({RegisterTable::input, 0, RegisterType::offset16, 1.0, 0.0}, words), 16712.0);
  EXPECT_DOUBLE_EQ(decode({RegisterTable::input, 0, RegisterType::uint32, 1.0, 0.0}, words), 3242721280.0);
  EXPECT_DOUBLE_EQ(decode({RegisterTable::input, 0, RegisterType::int32, 1.0, 0.0}, words), -1052246016.0);
}

TEST(ReadPlan, neighbours_are_read_together_and_gaps_are_never_asked_for) {
  const std::vector<Channel> channels{channel(RegisterTable::input, 12, RegisterType::float32, 0),
                                      channel(RegisterTable::input, 10, RegisterType::float32, 1),
                                      channel(RegisterTable::input, 15, RegisterType::int16, 2),
                                      channel(RegisterTable::holding, 14, RegisterType::int16, 3)};
  const auto requests = plan_requests(channels);
  ASSERT_EQ(requests.size(), 3U);
  EXPECT_EQ(requests[0].address, 10);
  EXPECT_EQ(requests[0].count, 4);
  EXPECT_EQ(requests[0].channels, (std::vector<std::size_t>{1, 0}));
  EXPECT_EQ(requests[1].address, 15);
  EXPECT_EQ(requests[2].table, RegisterTable::holding);
}

TEST(ReadPlan, no_request_is_longer_than_modbus_allows) {
  std::vector<Channel> channels;
  for (int i = 0; i < 100; ++i) channels.push_back(channel(RegisterTable::input, 2 * i, RegisterType::float32, 0));
  for (const ReadRequest& request : plan_requests(channels)) {
    EXPECT_LE(request.count, 125);
    EXPECT_EQ(request.count, 2 * request.channels.size());
  }
}

TEST(BackOff, doubles_up_to_five_seconds) {
  EXPECT_DOUBLE_EQ(back_off_s(0), 0.1);
  EXPECT_DOUBLE_EQ(back_off_s(1), 0.2);
  EXPECT_DOUBLE_EQ(back_off_s(5), 3.2);
  EXPECT_DOUBLE_EQ(back_off_s(6), 5.0);
  EXPECT_DOUBLE_EQ(back_off_s(1000000), 5.0);
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

  explicit Device(int port) : server(plan(port), clock, snapshots, signals, orders), thread([this] { server.run(); }) {}
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
  DevicePlan plan;
  plan.port = device->server.port();
  plan.poll_s = 0.02;
  plan.timeout_s = 0.2;
  plan.channels = {channel(RegisterTable::input, 2, RegisterType::float32, 0),
                   channel(RegisterTable::holding, 1, RegisterType::int16, 1),
                   channel(RegisterTable::input, 60000, RegisterType::int16, 2)};
  MonotonicClock clock;
  Latest<DeviceFrame> frames;
  ModbusDevice acquisition(plan, clock, frames);
  std::atomic<bool> stop{false};
  std::thread thread([&] { acquisition.run(stop); });

  DeviceFrame frame;
  EXPECT_TRUE(wait_for(frames, frame, [](const DeviceFrame& f) { return f.connected; }));
  EXPECT_EQ(frame.sensors[0].value, -12.5);
  EXPECT_EQ(frame.sensors[1].value, -125.0);
  EXPECT_EQ(frame.sensors[2].time_ns, 0) << "a register that the device refuses must stay unread";
  device.reset();
  EXPECT_TRUE(wait_for(frames, frame, [](const DeviceFrame& f) { return !f.connected; }));
  EXPECT_EQ(frame.sensors[0].value, -12.5) << "the last reading stays";
  device = std::make_unique<Device>(plan.port);
  EXPECT_TRUE(wait_for(frames, frame, [](const DeviceFrame& f) { return f.connected; }));
  stop.store(true);
  thread.join();
}

}  // namespace
}  // namespace spindle_twin::firmware
