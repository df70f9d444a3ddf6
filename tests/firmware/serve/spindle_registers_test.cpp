#include "firmware/serve/spindle_registers.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "tests/firmware/support/serving.hpp"

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

}  // namespace serve_spindle_registers_test
}  // namespace spindle_twin::firmware
