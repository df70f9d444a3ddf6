#include <gtest/gtest.h>

#include <cstdint>

#include "firmware/serve/command_registers.hpp"
#include "tests/firmware/support/serving.hpp"

namespace spindle_twin::firmware {
namespace serve_modbus_answers_test {

using namespace serving;

TEST(ModbusServer, known_answers_stand_on_input_and_holding_registers) {
  Serving serving;
  Client client(serving.server.port());
  EXPECT_EQ(payload(client.ask(read_known)), known_words);
  EXPECT_EQ(payload(client.ask({3, 0, 0, 0, 6})), known_words);
}

TEST(ModbusServer, what_is_not_served_is_an_exception_and_the_connection_goes_on) {
  Serving serving;
  Client client(serving.server.port());
  EXPECT_EQ(exception_of(client.ask({7})), 1);
  EXPECT_EQ(exception_of(client.ask({17})), 1);
  EXPECT_EQ(exception_of(client.ask({1, 0, 0, 0, 1})), 1);
  EXPECT_EQ(exception_of(client.ask({4, 0, 0, 0, 126})), 3);
  EXPECT_EQ(exception_of(client.ask({4, 0xFF, 0, 0, 1})), 2);
  EXPECT_EQ(exception_of(client.ask(read_known, 42)), 11);
  EXPECT_EQ(exception_of(client.ask(write_single(Register::nose_int16, 5))), 2);
  EXPECT_EQ(client.ask({43, 14, 1, 0})[7], 43);
  EXPECT_EQ(payload(client.ask(read_known, 255)), known_words);
}

TEST(ModbusServer, the_command_block_is_no_input_register) {
  Serving serving;
  Client client(serving.server.port());
  const WriteRange commands = writable_registers();
  const auto read = [&](std::uint8_t function, int address) {
    return client.ask(
        {function, static_cast<std::uint8_t>(address >> 8), static_cast<std::uint8_t>(address & 255), 0, 1});
  };
  for (const int address : {commands.address, commands.address + commands.count - 1}) {
    EXPECT_EQ(exception_of(read(4, address)), 2) << address;
    EXPECT_EQ(read(3, address).size(), 11U) << address;
  }
  EXPECT_EQ(read(4, commands.address - 1).size(), 11U);
  EXPECT_EQ(read(4, commands.address + commands.count).size(), 11U);
}

TEST(ModbusServer, a_function_with_the_bit_of_exceptions_is_answered_by_an_exception_too) {
  Serving serving;
  Client client(serving.server.port());
  for (const int function : {0x80, 0x84, 0x90, 0xFF}) {
    const Bytes reply = client.ask({static_cast<std::uint8_t>(function), 0, 0, 0, 1});
    ASSERT_EQ(reply.size(), 9U) << function;
    EXPECT_EQ(reply[7], function);
    EXPECT_EQ(reply[8], 1);
  }
}

}  // namespace serve_modbus_answers_test
}  // namespace spindle_twin::firmware
