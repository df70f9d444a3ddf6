#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "firmware/serve/modbus_server.hpp"
#include "tests/firmware/support/serving.hpp"

namespace spindle_twin::firmware {
namespace serve_several_units_test {

using namespace serving;

/// What one spindle gives and takes.
struct Spindle {
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk orders;

  SpindlePorts ports(std::size_t unit) { return {Units().set(unit), snapshots, signals, orders}; }
  void show_nose(double nose_m) {
    Snapshot snapshot;
    snapshot.nose_m = nose_m;
    snapshots.write(snapshot);
  }
};

class SeveralUnits : public testing::Test {
 protected:
  SeveralUnits() : server_(Serving::plan(), clock_, {left_.ports(1), right_.ports(7)}) {
    thread_ = std::thread([this] { server_.run(); });
  }
  ~SeveralUnits() override {
    server_.stop();
    thread_.join();
  }

  MonotonicClock clock_;
  Spindle left_, right_;
  ModbusServer server_;
  std::thread thread_;
};

const Bytes read_nose{4, 0, 15, 0, 1};
const Bytes gateway_target_failed{0x84, 11};

TEST_F(SeveralUnits, each_answers_with_its_own_registers) {
  left_.show_nose(1e-6);
  right_.show_nose(-2e-6);
  Client client(server_.port());
  EXPECT_EQ(payload(client.ask(read_nose, 1)), (Bytes{0, 10}));
  EXPECT_EQ(payload(client.ask(read_nose, 7)), (Bytes{0xFF, 0xEC}));
  EXPECT_EQ(payload(client.ask(read_nose, 1)), (Bytes{0, 10}));
}

TEST_F(SeveralUnits, what_is_nobodys_is_refused_and_what_means_any_unit_too) {
  Client client(server_.port());
  for (const std::uint8_t unit : Bytes{0, 2, 247, 255}) {
    const Bytes answer = client.ask(read_nose, unit);
    EXPECT_EQ(Bytes(answer.begin() + mbap_bytes, answer.end()), gateway_target_failed) << int{unit};
  }
}

TEST_F(SeveralUnits, an_order_reaches_its_own_spindle_only) {
  Client client(server_.port());
  const int address = entry_of(Register::command_tare).address;
  const Bytes tare{6, static_cast<std::uint8_t>(address >> 8), static_cast<std::uint8_t>(address & 0xFF), 0, 1};
  ASSERT_EQ(client.ask(tare, 7).size(), 12U);
  PlcCommand to_left, to_right;
  // The answer is sent first.
  for (int k = 0; k < 500 && to_right.tare_orders == 0; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    right_.orders.hand_out(to_right);
  }
  left_.orders.hand_out(to_left);
  EXPECT_EQ(to_left.tare_orders, 0U);
  EXPECT_EQ(to_right.tare_orders, 1U);
}

TEST_F(SeveralUnits, a_signal_is_told_to_its_own_spindle_only) {
  Client client(server_.port());
  const int address = entry_of(Register::command_speed).address;
  const auto high = static_cast<std::uint8_t>(address >> 8), low = static_cast<std::uint8_t>(address & 0xFF);
  ASSERT_EQ(client.ask({6, high, low, 0x0B, 0xB8}, 1).size(), 12U);
  PlcSignals told;
  bool is_told = false;
  for (int k = 0; k < 500 && !is_told; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    is_told = left_.signals.read(told);
  }
  EXPECT_TRUE(is_told);
  EXPECT_FALSE(right_.signals.read(told));
}

}  // namespace serve_several_units_test
}  // namespace spindle_twin::firmware
