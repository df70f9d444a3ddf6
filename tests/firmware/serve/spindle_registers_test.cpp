#include "firmware/serve/spindle_registers.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <utility>

#include "tests/firmware/support/serving.hpp"
#include "tests/firmware/support/standing_clock.hpp"

namespace spindle_twin::firmware {
namespace serve_spindle_registers_test {

using namespace serving;

TEST(SpindleRegisters, an_order_to_one_switch_hides_none_to_the_other_and_one_that_is_repeated_is_none) {
  constexpr Register correction = Register::command_correction, compensation = Register::command_compensation;
  for (const auto& [first, second] : {std::pair{correction, compensation}, std::pair{compensation, correction}}) {
    Serving serving;
    Client client(serving.server.port());
    for (int repeated = 0; repeated < 3; ++repeated) {  // a PLC may write all registers each second
      client.ask(write_single(first, 0));
      client.ask(write_single(second, 0));
      client.ask(write_single(Register::command_speed, 5));  // answered when the orders before have been given
      EXPECT_TRUE(serving.orders.has_room_for(OrderDesk::room - 2)) << repeated;
      EXPECT_FALSE(serving.orders.has_room_for(OrderDesk::room - 1)) << repeated;
    }
  }
}

/// Without a server.
struct Registers {
  explicit Registers(const StandingOrders& standing = {}) {
    desk.begin_with(standing);
    registers.emplace(SpindlePorts{units_of_one_spindle(), snapshots, signals, desk}, clock);
  }
  std::uint16_t holds(Register which) { return registers->renew()->tab_registers[entry_of(which).address]; }

  StandingClock clock;
  Latest<Snapshot> snapshots;
  Latest<PlcSignals> signals;
  OrderDesk desk;
  std::optional<SpindleRegisters> registers;
};

TEST(SpindleRegisters, switches_read_back_what_was_ordered_before_a_restart_and_that_again_is_no_order) {
  for (const auto& [order, code] : {std::pair{SwitchOrder::on, std::uint16_t{1}},
                                    {SwitchOrder::off, std::uint16_t{0}},
                                    {SwitchOrder::as_configured, not_present_code}}) {
    StandingOrders standing;
    standing.correction = order;
    standing.compensation = SwitchOrder::on;
    Registers spindle(standing);
    EXPECT_EQ(spindle.holds(Register::command_correction), code);
    EXPECT_EQ(spindle.holds(Register::command_compensation), 1);
    spindle.registers->take(writable_registers());
    EXPECT_TRUE(spindle.desk.has_room_for(OrderDesk::room)) << "a PLC may write all registers each second";
  }
}

TEST(SpindleRegisters, input_registers_end_with_the_last_block_that_is_no_command_block) {
  int end = 0;
  for (const RegisterBlock& block : register_blocks) {
    if (!block.command && block.address + block.length > end) end = block.address + block.length;
  }
  Registers spindle;
  EXPECT_EQ(spindle.registers->renew()->nb_input_registers, end);
}

TEST(SpindleRegisters, who_tells_a_signal_and_asks_three_times_is_watched_from_then_on) {
  Registers spindle;
  Talk talk;
  PlcSignals told;
  spindle.registers->note_request(talk, {});
  EXPECT_FALSE(spindle.signals.read(told)) << "it has told nothing";
  for (const unsigned tells : {1U, 0U}) {
    spindle.registers->note_request(talk, tells);
    spindle.signals.read(told);
    EXPECT_EQ(told.alive_ns[0], 0);
  }
  for (int n = 0; n < 3; ++n) {
    spindle.clock.pass(7);
    spindle.registers->note_request(talk, {});
    ASSERT_TRUE(spindle.signals.read(told));
    EXPECT_EQ(told.alive_ns[0], spindle.clock.now_ns());
    EXPECT_EQ(told.alive_ns[1], 0) << "nobody told it";
  }
}

TEST(SpindleRegisters, each_signal_lives_with_who_told_it_last_whoever_else_talks) {
  Registers spindle;
  Talk plc, panel;
  PlcSignals told;
  for (int n = 0; n < 3; ++n) spindle.registers->note_request(plc, 0b0011U);
  const std::int64_t plc_ns = spindle.clock.now_ns();
  spindle.clock.pass(5);
  spindle.registers->note_request(panel, 0b1000U);
  for (int n = 0; n < 5; ++n) spindle.registers->note_request(panel, {});
  spindle.signals.read(told);
  EXPECT_EQ(told.alive_ns[0], plc_ns) << "the panel polls on, the PLC is silent";
  EXPECT_EQ(told.alive_ns[1], plc_ns);
  EXPECT_EQ(told.alive_ns[3], plc_ns + 5);
  spindle.clock.pass(5);
  spindle.registers->note_request(panel, 0b0001U);
  spindle.registers->note_request(plc, {});
  spindle.signals.read(told);
  EXPECT_EQ(told.alive_ns[0], plc_ns + 10) << "now the panel's";
  EXPECT_EQ(told.alive_ns[1], plc_ns + 10) << "still the PLC's, which is back";
  spindle.clock.pass(5);
  spindle.registers->note_request(plc, {});
  spindle.signals.read(told);
  EXPECT_EQ(told.alive_ns[0], plc_ns + 10) << "no longer the PLC's";
}

}  // namespace serve_spindle_registers_test
}  // namespace spindle_twin::firmware
