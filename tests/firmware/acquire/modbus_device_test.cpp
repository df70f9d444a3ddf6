#include "firmware/acquire/modbus_device.hpp"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/acquire/device_thread.hpp"
#include "firmware/serve/listen.hpp"
#include "firmware/serve/modbus_server.hpp"
#include "tests/firmware/support/logged.hpp"

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

TEST(ReadPlan, a_request_is_filled_to_the_last_register_that_modbus_allows_and_channels_may_share_some) {
  std::vector<RegisterSource> channels;
  for (int i = 0; i < 126; ++i) channels.push_back(source(RegisterTable::input, i, RegisterType::uint16));
  const auto requests = plan_requests(channels);
  ASSERT_EQ(requests.size(), 2U);
  EXPECT_EQ(requests[0].count, 125);
  EXPECT_EQ(requests[1].address, 125);
  EXPECT_EQ(requests[1].count, 1);
  const auto shared = plan_requests({source(RegisterTable::input, 20, RegisterType::float32),
                                     source(RegisterTable::input, 20, RegisterType::uint16),
                                     source(RegisterTable::input, 23, RegisterType::uint16)});
  ASSERT_EQ(shared.size(), 2U);
  EXPECT_EQ(shared[0].count, 2) << "of the longer one";
  EXPECT_EQ(shared[0].channels, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(shared[1].address, 23);
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
  EXPECT_EQ(check_answer(question, std::vector<std::uint8_t>{0x12, 0x34, 0, 0, 0, 3, 7, 0x84, 2, 0}).is, Answer::wrong);
  for (std::size_t bytes = 0; bytes < refusal.size(); ++bytes) {
    EXPECT_EQ(check_answer(question, std::span(refusal).first(bytes)).is, Answer::not_whole) << bytes;
  }
  for (std::size_t at = 0; at < 8; ++at) {
    std::vector<std::uint8_t> bad = refusal;
    bad[at] ^= 1;
    EXPECT_EQ(check_answer(question, bad).is, Answer::wrong) << at;
  }
  EXPECT_EQ(check_answer(question, good).bytes, good.size());
  EXPECT_EQ(check_answer(question, refusal).bytes, refusal.size());
  EXPECT_EQ(check_answer(question, good).exception, 0);
}

TEST(CheckAnswer, holding_registers_are_asked_for_by_function_3_and_answered_by_it) {
  const ReadQuestion question{1, 255, RegisterTable::holding, 0xABCD, 125};
  const auto asked = encode(question);
  EXPECT_EQ(asked, (std::array<std::uint8_t, 12>{0, 1, 0, 0, 0, 6, 255, 3, 0xAB, 0xCD, 0, 125}));
  std::vector<std::uint8_t> answer{0, 1, 0, 0, 0, 253, 255, 3, 250};
  answer.resize(longest_answer - 1);
  EXPECT_EQ(check_answer(question, answer).is, Answer::values);
  answer[7] = 4;
  EXPECT_EQ(check_answer(question, answer).is, Answer::wrong);
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

/// A device that says to each question what a test wants, in pieces. One connection at a time.
class Gateway {
 public:
  using Bytes = std::vector<std::uint8_t>;
  /// Of the question's frame. No piece: it closes the connection.
  using Script = std::function<std::vector<Bytes>(const Bytes& question)>;
  explicit Gateway(Script script) : script_(std::move(script)), thread_([this] { run(); }) {}
  ~Gateway() {
    ::shutdown(listener_.get(), SHUT_RDWR);
    thread_.join();
  }
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;
  int port() const { return port_of(listener_.get()); }

 private:
  static bool is_readable(int socket) {
    pollfd readable{socket, POLLIN, 0};
    return poll(&readable, 1, -1) == 1;
  }
  void run() {
    while (is_readable(listener_.get())) {
      const Descriptor client(::accept(listener_.get(), nullptr, nullptr));
      if (client.get() < 0) return;
      make_quick(client.get());
      Bytes question(12);
      while (recv(client.get(), question.data(), question.size(), MSG_WAITALL) == 12) {
        const std::vector<Bytes> pieces = script_(question);
        for (const Bytes& piece : pieces) {
          (void)!::send(client.get(), piece.data(), piece.size(), MSG_NOSIGNAL);
          std::this_thread::yield();
        }
        if (pieces.empty()) break;
      }
    }
  }

  Descriptor listener_{listen_on("127.0.0.1", 0)};
  Script script_;
  std::thread thread_;
};

struct AskedOf {
  Step step;
  DeviceFrame frame;
};
/// What becomes of two registers of `table` at 10 and one at 500, in so many steps.
AskedOf ask_gateway(const Gateway& gateway, int steps = 1, double timeout_s = 5.0,
                    RegisterTable table = RegisterTable::input) {
  ModbusPlan plan;
  plan.port = gateway.port();
  plan.unit = 7;
  plan.timeout_s = timeout_s;
  plan.sources = {source(table, 10, RegisterType::float32), source(table, 500, RegisterType::int16)};
  MonotonicClock clock;
  ModbusDevice driver(plan, clock);
  DeviceReadings readings("device", 0,
                          {{Channel::Kind::sensor, 0, "a", {}, {}}, {Channel::Kind::sensor, 1, "b", {}, {}}}, 0.0);
  AskedOf asked;
  for (int n = 0; n < steps; ++n) asked.step = driver.step(readings);
  asked.frame = readings.frame();
  return asked;
}
/// -12.5 of two registers, -3 of one.
Gateway::Bytes right_answer(const Gateway::Bytes& question) {
  Gateway::Bytes answer(question.begin(), question.begin() + 8);
  answer[5] = static_cast<std::uint8_t>(3 + 2 * question[11]);
  answer.push_back(static_cast<std::uint8_t>(2 * question[11]));
  for (const int byte : question[11] == 2 ? std::vector<int>{0xC1, 0x48, 0, 0} : std::vector<int>{0xFF, 0xFD}) {
    answer.push_back(static_cast<std::uint8_t>(byte));
  }
  return answer;
}

TEST(ModbusDevice, asks_its_unit_for_each_run_of_registers_and_takes_answers_in_pieces) {
  for (const RegisterTable table : {RegisterTable::input, RegisterTable::holding}) {
    std::vector<Gateway::Bytes> questions;
    const auto function = static_cast<std::uint8_t>(table == RegisterTable::input ? 4 : 3);
    {
      const Gateway gateway([&](const Gateway::Bytes& question) {
        questions.push_back(question);
        std::vector<Gateway::Bytes> pieces;
        for (const std::uint8_t byte : right_answer(question)) pieces.push_back({byte});
        return pieces;
      });
      const AskedOf asked = ask_gateway(gateway, 2, 5.0, table);
      EXPECT_EQ(asked.step.is, Step::Is::fresh) << asked.step.reason;
      EXPECT_EQ(asked.frame.sensors[0].value, -12.5);
      EXPECT_EQ(asked.frame.sensors[1].value, -3.0);
      EXPECT_EQ(asked.frame.devices[0].accepted, 4U);
      EXPECT_EQ(asked.frame.devices[0].refused, 0U);
    }
    ASSERT_EQ(questions.size(), 4U);
    EXPECT_EQ(questions[0], (Gateway::Bytes{0, 1, 0, 0, 0, 6, 7, function, 0, 10, 0, 2}));
    EXPECT_EQ(questions[1], (Gateway::Bytes{0, 2, 0, 0, 0, 6, 7, function, 0x01, 0xF4, 0, 1}));
    EXPECT_EQ(questions[2][1], 3) << "the same connection, another transaction";
  }
}

TEST(ModbusDevice, a_loss_says_why_and_is_counted_once) {
  const auto expect = [](const Gateway::Script& script, const std::string& reason) {
    const Gateway gateway(script);
    const AskedOf asked = ask_gateway(gateway, 1, reason == "no answer in time" ? 0.05 : 5.0);
    EXPECT_EQ(asked.step.is, Step::Is::lost);
    EXPECT_EQ(asked.step.reason, reason);
    EXPECT_EQ(asked.frame.devices[0].refused, 1U);
    EXPECT_EQ(asked.frame.devices[0].accepted, 0U);
    EXPECT_EQ(asked.frame.sensors[0].time_ns, 0);
  };
  using Pieces = std::vector<Gateway::Bytes>;
  expect([](const Gateway::Bytes&) { return Pieces{}; }, "it closed the connection");
  expect([](const Gateway::Bytes&) { return Pieces(1); }, "no answer in time");
  expect(
      [](const Gateway::Bytes& question) {
        Gateway::Bytes half = right_answer(question);
        half.pop_back();
        return Pieces{half};
      },
      "no answer in time");
  expect(
      [](const Gateway::Bytes& question) {
        Gateway::Bytes other = right_answer(question);
        ++other[6];
        return Pieces{other};
      },
      "its answer is of another request, unit, protocol or length");
}

TEST(ModbusDevice, registers_that_are_refused_are_said_and_so_is_when_they_are_given_again) {
  const Logged log;
  int asked_for_500 = 0;
  const Gateway gateway([&](const Gateway::Bytes& question) -> std::vector<Gateway::Bytes> {
    const bool refuses = question[9] == 0xF4 && asked_for_500++ < 2;
    if (!refuses) return {right_answer(question)};
    return {{question[0], question[1], 0, 0, 0, 3, 7, 0x84, 2}};
  });
  const AskedOf asked = ask_gateway(gateway, 3);
  EXPECT_EQ(asked.frame.devices[0].refused, 2U);
  EXPECT_EQ(asked.frame.devices[0].accepted, 4U);
  EXPECT_EQ(asked.frame.sensors[1].value, -3.0);
  const std::string device = "device 127.0.0.1:" + std::to_string(gateway.port());
  EXPECT_EQ(log.text(), "warning " + device + " refuses registers 500 to 500 with exception 2\ninfo " + device +
                            " gives registers 500 to 500 again\n");
}

TEST(ModbusDevice, a_port_that_nobody_listens_on_is_a_loss_with_its_reason) {
  ModbusPlan plan;
  {
    const Descriptor listener(listen_on("127.0.0.1", 0));
    plan.port = port_of(listener.get());
  }
  MonotonicClock clock;
  ModbusDevice driver(plan, clock);
  DeviceReadings readings("device", 0, {}, 0.0);
  const Step step = driver.step(readings);
  EXPECT_EQ(step.is, Step::Is::lost);
  EXPECT_EQ(step.reason, "Connection refused");
}

}  // namespace acquire_modbus_device_test
}  // namespace spindle_twin::firmware
