#include "firmware/keep/parameters.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace spindle_twin::firmware {
namespace keep_parameters_test {

TEST(ParametersSaid, of_all_and_of_none_no_list_is_needed_and_of_some_both_are_in_their_order) {
  const std::vector<correction::Parameter> parameters = {{.name = "a"}, {.name = "b"}, {.name = "c"}, {.name = "d"}};
  const correction::ParameterEstimate known{1.0, 0.1, 1.0}, open{0.0, 0.95, 1.0};
  EXPECT_EQ(what_is_determined(parameters, {open, open, open, open}), "the sensors determine none of 4 parameters");
  EXPECT_EQ(what_is_determined(parameters, {known, known, known, known}), "the sensors determine all 4 parameters");
  EXPECT_EQ(what_is_determined(parameters, {known, open, known, open}),
            "the sensors determine 2 of 4 parameters (a, c) and say nothing of the others (b, d)");
  EXPECT_EQ(what_is_determined(parameters, {open, open, open, known}),
            "the sensors determine 1 of 4 parameters (d) and say nothing of the others (a, b, c)");
}

TEST(ParametersSaid, a_heat_of_exactly_two_deviations_is_none_and_several_are_named_in_their_order) {
  const auto heat = correction::ParameterKind::disturbance;
  const std::vector<correction::Parameter> parameters = {{.name = "one", .kind = heat}, {.name = "two", .kind = heat}};
  EXPECT_EQ(unexplained_heats(parameters, {{16.0, 8.0, 9.0}, {-16.0, 8.0, 9.0}}), "");
  EXPECT_EQ(unexplained_heats(parameters, {{17.0, 8.0, 9.0}, {-17.0, 8.0, 9.0}}),
            "the readings ask for heat that no source explains (one: 17 W +- 8 W, two: -17 W +- 8 W)");
}

}  // namespace keep_parameters_test
}  // namespace spindle_twin::firmware
