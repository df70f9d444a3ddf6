// What is left of an answer's error, from its changes.
#include "fem_offline/mesh/error_left.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace spindle_twin::fem_offline {
namespace mesh_error_left_test {

TEST(ErrorLeft, is_exact_where_the_error_has_one_order) {
  for (const double order : {0.8, 1.0, 4.0 / 3.0, 2.0, 4.0}) {
    for (const double error : {3.0, -0.02}) {
      const double half = error * std::exp2(-order), quarter = half * std::exp2(-order);
      EXPECT_NEAR(error_left(error - half, half - quarter, 2), error, 1e-12 * std::abs(error)) << order;
    }
  }
}

TEST(ErrorLeft, takes_order_1_where_the_changes_show_none) {
  EXPECT_DOUBLE_EQ(error_left(1.0, 1.2, 2), 1.0 + 2.0 * 1.2);
  EXPECT_DOUBLE_EQ(error_left(-1.0, 1.2, 2), -1.0 + 2.0 * 1.2);
  EXPECT_DOUBLE_EQ(error_left(0.0, 1.0, 2), 2.0);
  EXPECT_DOUBLE_EQ(error_left(1.0), 2.0);
}

TEST(ErrorLeft, is_no_less_than_the_first_change_where_the_second_turns_back) {
  EXPECT_DOUBLE_EQ(error_left(1.0, -0.5, 2), 1.0);
}

TEST(ErrorLeft, holds_the_order_within_what_elements_can_have) {
  EXPECT_DOUBLE_EQ(error_left(1.0, 1e-9, 2), 1.0 + 1e-9 / (1.0 - 1.0 / 16.0));
  EXPECT_DOUBLE_EQ(error_left(1.0, 0.99, 2), 1.0 + 0.99 / (1.0 - std::exp2(-0.7)));
  EXPECT_EQ(error_left(0.0, 0.0, 2), 0.0);
  EXPECT_EQ(error_left(1.0, 0.0, 2), 1.0);
}

}  // namespace mesh_error_left_test
}  // namespace spindle_twin::fem_offline
