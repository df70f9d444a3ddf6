#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <variant>

#include "rom/by_hand/read_by_hand.hpp"
#include "rom/units.hpp"
#include "tests/rom/by_hand_texts.hpp"
#include "tests/support/texts.hpp"

/// Tables `law` of a hand-written network: what they may name, also the first of each list, and where their numbers
/// end.
namespace spindle_twin::rom::tests {
namespace law_edges_by_hand_test {

using spindle_twin::tests::refusal_of;
using spindle_twin::tests::with;

const std::string bearing =
    "{ kind = \"bearing_friction\", inner_ring = \"first\", outer_ring = \"second\", inner_ring_degC = 48.0, "
    "outer_ring_degC = 42.0, pitch_diameter_mm = 60.0, viscous_factor = 3.4, static_rating_N = 21000.0, "
    "contact_angle_deg = 15.0, balls = 18, ball_diameter_mm = 7.9, preload_N = 150.0, spring_N_per_m = 1.0e6, "
    "viscosities = [[40.0, 32.0], [100.0, 5.4]] }";

std::string network_of(const std::string& heat_law) {
  return in_a_room("laws", R"([[node]]
name = "a"
part = "first"
capacity_J_per_K = 100.0
[[node]]
name = "b"
part = "second"
capacity_J_per_K = 200.0
[[contact]]
name = "seat"
between = ["a", "b"]
area_mm2 = 300.0
conductance_W_per_m2K = 900.0
[[film]]
name = "to_room"
surrounding = "room"
node = "b"
area_mm2 = 50000.0
coefficient_W_per_m2K = 20.0
[[heat]]
name = "heat"
node = "a"
law = )" + heat_law + "\n");
}

std::string copper_in(const std::string& words) {
  return "{ kind = \"copper_loss\", " + words + "resistance_20_ohm = 0.22, rated_current_A = 16.0 }";
}

std::string said_of(const std::string& text) {
  return refusal_of([&] { parse_by_hand(text, "net.toml"); });
}

BoundLaw heat_law_of(const std::string& text) { return *parse_by_hand(text, "net.toml").boundaries.sources[0].physics; }

TEST(LawEdgesByHand, a_temperature_is_that_of_a_part_or_a_surrounding_also_of_the_first) {
  for (const auto& [name, place] : {std::pair{"first", 0}, {"second", 1}}) {
    const BoundLaw law =
        heat_law_of(network_of(copper_in("winding = \"" + std::string(name) + "\", winding_degC = 70.0, ")));
    EXPECT_EQ(law.first.part, place);
    EXPECT_EQ(law.first.environment, -1);
    EXPECT_EQ(law.first.nominal_K, 70.0 + zero_degC_K);
    EXPECT_EQ(law.second.part, -1);
  }
  const BoundLaw law = heat_law_of(network_of(copper_in("winding = \"room\", ")));
  EXPECT_EQ(law.first.part, -1);
  EXPECT_EQ(law.first.environment, 0);
}

TEST(LawEdgesByHand, a_temperature_that_names_nothing_or_what_is_not_there_is_refused) {
  EXPECT_NE(said_of(network_of(copper_in("winding_degC = 70.0, "))).find("missing: must name a part or surrounding"),
            std::string::npos);
  EXPECT_NE(said_of(network_of(copper_in("winding = \"third\", winding_degC = 70.0, ")))
                .find("there is no part or surrounding \"third\"; there are: first, second; room"),
            std::string::npos);
  EXPECT_NE(said_of(network_of(copper_in("winding = \"first\", "))).find("winding_degC: this key is required"),
            std::string::npos);
  EXPECT_NE(said_of(network_of(copper_in("winding = \"room\", winding_degC = 70.0, "))).find("unknown key"),
            std::string::npos)
      << "a surrounding has its own temperature";
}

TEST(LawEdgesByHand, a_heat_may_be_small_or_none) {
  const std::string copper = network_of(copper_in("winding = \"first\", winding_degC = 70.0, "));
  EXPECT_EQ(said_of(with(copper, "speed_rpm = 1000.0", "speed_rpm = 1000.0\nload = 0.0")), "accepted");
  EXPECT_EQ(said_of(with(copper, "speed_rpm = 1000.0", "speed_rpm = 1000.0\nload = 0.02")), "accepted")
      << "less than a watt is a heat too";
}

TEST(LawEdgesByHand, an_oil_is_two_points_the_colder_and_thicker_first_above_a_third_of_a_square_millimetre) {
  const auto oil = [](const std::string& points) {
    const std::string said = said_of(network_of(with(bearing, "[[40.0, 32.0], [100.0, 5.4]]", points)));
    const bool taken = said == "accepted";
    EXPECT_EQ(said.find("law.viscosities: ") == std::string::npos, taken) << said;
    return taken;
  };
  EXPECT_TRUE(oil("[[40.0, 32.0], [100.0, 5.4]]"));
  EXPECT_TRUE(oil("[[40.0, 2.0], [100.0, 0.5]]"));
  EXPECT_FALSE(oil("[[40.0, 2.0], [100.0, 0.3]]"));
  EXPECT_FALSE(oil("[[40.0, 1.4e6], [100.0, 5.4]]"));
  EXPECT_FALSE(oil("[[100.0, 32.0], [40.0, 5.4]]")) << "the warmer first";
  EXPECT_FALSE(oil("[[40.0, 32.0], [40.0, 5.4]]")) << "one temperature";
  EXPECT_FALSE(oil("[[40.0, 5.4], [100.0, 32.0]]")) << "thicker when warm";
  EXPECT_FALSE(oil("[[40.0, 5.4], [100.0, 5.4]]"));
  EXPECT_FALSE(oil("[[40.0, 32.0]]"));
  EXPECT_FALSE(oil("[[40.0, 32.0], [70.0, 10.0], [100.0, 5.4]]"));
}

TEST(LawEdgesByHand, radii_and_angle_of_a_bearing_follow_from_its_size_unless_they_are_written) {
  const auto preload_of = [](const std::string& more) {
    const std::string text = network_of(with(bearing, "balls = 18", "balls = 18" + more));
    return std::get<BearingHeatLaw>(heat_law_of(text).law.parameters).preload;
  };
  const double angle_rad = 15.0 * std::numbers::pi / 180.0, offset_m = 0.5 * 7.9e-3 * std::cos(angle_rad);
  const auto followed = preload_of("");
  EXPECT_NEAR(followed.contact_angle_rad, angle_rad, 1e-12);
  EXPECT_NEAR(followed.inner_radius_m, 0.030 - offset_m, 1e-12);
  EXPECT_NEAR(followed.outer_radius_m, 0.030 + offset_m, 1e-12);
  const auto inner = preload_of(", inner_contact_radius_mm = 25.0");
  EXPECT_NEAR(inner.inner_radius_m, 0.025, 1e-12);
  EXPECT_NEAR(inner.outer_radius_m, 0.030 + offset_m, 1e-12);
  const auto outer = preload_of(", outer_contact_radius_mm = 36.0, preload_angle_deg = 20.0");
  EXPECT_NEAR(outer.inner_radius_m, 0.030 - offset_m, 1e-12);
  EXPECT_NEAR(outer.outer_radius_m, 0.036, 1e-12);
  EXPECT_NEAR(outer.contact_angle_rad, 20.0 * std::numbers::pi / 180.0, 1e-12);
}

}  // namespace law_edges_by_hand_test
}  // namespace spindle_twin::rom::tests
