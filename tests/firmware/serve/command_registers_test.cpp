#include "firmware/serve/command_registers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "firmware/serve/pack.hpp"

namespace spindle_twin::firmware {
namespace serve_command_registers_test {

RegisterImage cleared() {
  RegisterImage image{};
  image.fill(0x5555);
  clear_commands(image);
  return image;
}

const Register orders[] = {Register::command_correction,  Register::command_displacement_take,
                           Register::command_sensors,     Register::command_tare,
                           Register::command_acknowledge, Register::command_compensation};

bool is_order(int address) {
  for (const Register which : orders) {
    if (entry_of(which).address == address) return true;
  }
  return false;
}

TEST(CommandRegisters, a_command_block_with_nothing_written_tells_and_orders_nothing) {
  RegisterImage image = cleared();
  const WriteRange all = writable_registers();
  for (int at = all.address; at < all.address + all.count; ++at) {
    EXPECT_NE(image.at(static_cast<std::size_t>(at)), 0x5555) << at;
  }
  EXPECT_EQ(image.at(static_cast<std::size_t>(all.address - 1)), 0x5555);
  EXPECT_EQ(image.at(static_cast<std::size_t>(all.address + all.count)), 0x5555);
  EXPECT_TRUE(take_orders(all, {}, image).empty());
  PlcSignals told;
  EXPECT_TRUE(take_signals(all, 5, image, told).all()) << "they were written";
  for (std::size_t s = 0; s < signal_count; ++s) {
    EXPECT_TRUE(std::isnan(told.values[s].value)) << s;
    EXPECT_EQ(told.values[s].time_ns, 5) << s;
  }
}

TEST(CommandRegisters, a_write_brings_orders_exactly_where_it_touches_one) {
  const WriteRange all = writable_registers();
  for (int at = all.address; at < all.address + all.count; ++at) {
    EXPECT_EQ(may_order({at, 1}), is_order(at)) << at;
    EXPECT_EQ(may_order({at, 2}), is_order(at) || is_order(at + 1)) << at;
    EXPECT_FALSE(may_order({at, 0})) << at;
  }
}

TEST(CommandRegisters, each_order_is_taken_by_the_write_that_touches_it_with_its_code_and_number) {
  const OrderKind kinds[] = {OrderKind::correction, OrderKind::length,      OrderKind::sensors,
                             OrderKind::tare,       OrderKind::acknowledge, OrderKind::compensation};
  for (std::size_t n = 0; n < most_orders; ++n) {
    RegisterImage image = cleared();
    const int at = entry_of(orders[n]).address;
    put(image, orders[n], 1.0);
    EXPECT_TRUE(take_orders({at - 1, 1}, {}, image).empty());
    EXPECT_TRUE(take_orders({at + 1, 1}, {}, image).empty());
    const std::vector<Order> taken = take_orders({at, 1}, {}, image);
    ASSERT_EQ(taken.size(), 1U) << n;
    EXPECT_EQ(taken[0].kind, kinds[n]);
    EXPECT_EQ(taken[0].code, 1);
    EXPECT_EQ(taken[0].id, 0) << "it was given none";
    const bool is_switch = kinds[n] == OrderKind::correction || kinds[n] == OrderKind::compensation;
    EXPECT_EQ(get(image, orders[n]), is_switch ? 1.0 : 0.0);
  }
}

TEST(CommandRegisters, one_write_may_bring_all_orders_and_they_have_its_number) {
  RegisterImage image = cleared();
  for (const Register which : orders) put(image, which, 1.0);
  put(image, Register::command_order_id, 65534.0);
  const std::vector<Order> taken = take_orders(writable_registers(), {}, image);
  ASSERT_EQ(taken.size(), most_orders);
  for (const Order& each : taken) EXPECT_EQ(each.id, 65534);
}

TEST(CommandRegisters, a_signal_is_told_in_its_unit_by_the_write_that_touches_it) {
  struct Told {
    Register from;
    std::size_t to;
    double written, value;
    int slot = 0;
  };
  const auto of = [](Signal signal) { return static_cast<std::size_t>(signal); };
  std::vector<Told> all{{Register::command_speed, of(Signal::speed), 6000.0, 6000.0},
                        {Register::command_load, of(Signal::load), 55.5, 0.555},
                        {Register::command_coolant, of(Signal::coolant), 20.5, 293.65},
                        {Register::command_ambient, of(Signal::ambient), -1.5, 271.65},
                        {Register::command_current, of(Signal::current), 12.5, 12.5},
                        {Register::command_power, of(Signal::power), -4.25, -4250.0}};
  for (int slot = 0; slot < static_cast<int>(slots::circuits); ++slot) {
    all.push_back({Register::command_flow, first_flow_signal + static_cast<std::size_t>(slot), -82.5, -0.0825, slot});
  }
  for (int slot = 0; slot < static_cast<int>(slots::heats); ++slot) {
    all.push_back({Register::command_heat, first_heat_signal + static_cast<std::size_t>(slot), 410.5, 410.5, slot});
  }
  EXPECT_EQ(all.size(), signal_count);
  for (const Told& each : all) {
    RegisterImage image = cleared();
    put(image, each.from, each.written, each.slot);
    const int words = words_of(entry_of(each.from).type), at = entry_of(each.from).address + each.slot * words;
    for (int word = at; word < at + words; ++word) {
      PlcSignals told;
      EXPECT_TRUE(take_signals({word, 1}, 77, image, told).any());
      for (std::size_t s = 0; s < signal_count; ++s) {
        EXPECT_EQ(told.values[s].time_ns, s == each.to ? 77 : 0) << s;
      }
      EXPECT_NEAR(told.values[each.to].value, each.value, 1e-9 * std::abs(each.value)) << each.to;
    }
  }
}

}  // namespace serve_command_registers_test
}  // namespace spindle_twin::firmware
