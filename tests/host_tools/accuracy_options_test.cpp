#include "host_tools/commands/offline/accuracy_options.hpp"

#include <gtest/gtest.h>

#include <CLI/Error.hpp>

namespace spindle_twin::host_tools {
namespace accuracy_options_test {

TEST(Tolerance, reads_two_or_three_numbers_with_their_units) {
  const fem_offline::Tolerance three = parse_tolerance("0.05K,0.03um,0.4K");
  EXPECT_EQ(three.key_points_K, 0.05);
  EXPECT_EQ(three.deformations_um, 0.03);
  EXPECT_EQ(three.part_max_K, 0.4);
  EXPECT_DOUBLE_EQ(parse_tolerance("0.05K,0.03um").part_max_K, 0.3);
}

TEST(Tolerance, refuses_everything_else) {
  for (const char* text : {"", "0.05K", "0.05,0.03", "0.05um,0.03K", "0.05K,0.03um,", "0.05K,0.03um,0.1K,1K", "-1K,1um",
                           "0K,1um", "nanK,1um", "infK,1um", "0.05 K,0.03um", "1e999K,1um"}) {
    EXPECT_THROW(parse_tolerance(text), CLI::ValidationError) << text;
  }
}

TEST(NamedBox, reaches_beyond_the_speed_of_the_description) {
  EXPECT_EQ(named_box("whole", 6000.0).speed_high_rpm, 24000.0);
  EXPECT_GT(named_box("whole", 40000.0).speed_high_rpm, 40000.0);
  EXPECT_EQ(named_box("small", 6000.0).contact_high, 3.0);
  EXPECT_EQ(named_box("whole", 6000.0).film_low, 0.2);
}

}  // namespace accuracy_options_test
}  // namespace spindle_twin::host_tools
