#include <gtest/gtest.h>

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/input_error.hpp"
#include "tests/rom/by_hand_texts.hpp"

namespace spindle_twin::rom::tests {
namespace friction_test {

/// One warm node in a room, with a heat of this kind.
std::string one_node(const std::string& of_heat) {
  return in_a_room("one", R"([[node]]
name = "body"
part = "body"
capacity_J_per_K = 200.0
[[film]]
name = "air"
surrounding = "room"
node = "body"
area_mm2 = 500000.0
coefficient_W_per_m2K = 10.0
[[key_point]]
name = "body"
node = "body"
[[heat]]
name = "loss"
node = "body"
)" + of_heat);
}

bool is_friction(const std::string& of_heat) {
  return parse_by_hand(one_node(of_heat), "one.toml").boundaries.sources[0].friction;
}

const std::string by_speed = "heat_W = 30.0\nspeed_law = { speed_terms = [[1.0, 1.0]] }\n";
const std::string by_load = "heat_W = 30.0\nspeed_law = { speed_terms = [[0.5, 1.0]], load_squared = 0.5 }\n";

TEST(Friction, is_what_a_description_says_and_else_a_heat_that_knows_speed_but_not_load) {
  EXPECT_TRUE(is_friction(by_speed));
  EXPECT_FALSE(is_friction(by_load));
  EXPECT_FALSE(is_friction("heat_W = 30.0\n"));
  EXPECT_FALSE(is_friction(by_speed + "friction = false\n")) << "windage knows speed only, and is no friction";
  EXPECT_TRUE(is_friction(by_load + "friction = true\n"));
}

TEST(Friction, is_kept_by_a_network_file_and_adds_no_byte_where_the_law_says_the_same) {
  const std::string texts[] = {by_speed, by_load, by_speed + "friction = false\n", by_load + "friction = true\n"};
  std::vector<std::size_t> sizes;
  for (const std::string& text : texts) {
    const Network network = parse_by_hand(one_node(text), "one.toml");
    const auto bytes = encode_network(network);
    sizes.push_back(bytes.size());
    EXPECT_EQ(decode_network(bytes, "one.rom").boundaries.sources[0].friction, network.boundaries.sources[0].friction)
        << text;
  }
  EXPECT_EQ(sizes[2] - sizes[0], 2U) << "a file of before says nothing, and must stay what it is";
  EXPECT_EQ(sizes[3] - sizes[1], 2U);
}

TEST(Friction, cannot_be_said_of_a_physical_law) {
  const std::string law = "law = { kind = \"motor_efficiency\", efficiency = 0.9, rated_power_W = 100.0 }\n";
  EXPECT_FALSE(is_friction(law));
  try {
    is_friction(law + "friction = true\n");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "one.toml:26: heat.loss.friction: cannot stand beside law, which gives the value");
  }
}

}  // namespace friction_test
}  // namespace spindle_twin::rom::tests
