#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "fem_offline/description/spindle.hpp"

namespace spindle_twin::fem_offline {
namespace description_laws_test {

/// The jacket with a law for every value that may have one.
std::string jacket_with_laws() {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/jacket_circuit.toml");
  std::ostringstream stream;
  stream << file.rdbuf();
  std::string text = stream.str();
  const auto replace = [&](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  replace("heat_W = 400",
          "law = { kind = \"copper_loss\", winding = \"jacket\", winding_degC = 40.0, resistance_20_ohm = 0.5, "
          "rated_current_A = 16.0 }");
  replace("speed_law = { speed_terms = [[1, 1.2]] }\n", "");
  replace("conductance_W_per_m2K = 2500",
          "law = { kind = \"contact\", conductivity_W_per_mK = 46.0, roughness_um = 1.1, slope = 0.14, young_Pa = "
          "1.16e11, pressure_Pa = 2.0e6 }");
  replace("coefficient_W_per_m2K = 10\n",
          "law = { kind = \"still_cylinder\", radius_mm = 83.0, surface = \"sleeve\", surface_degC = 30.0 }\n");
  replace("speed_law = { constant = 0.5, speed_terms = [[0.5, 0.7]] }\n", "");
  replace("coefficient_W_per_m2K = 1500",
          "law = { kind = \"channel\", hydraulic_diameter_mm = 9.0, perimeter_mm = 52.0, length_mm = 2800.0, wall = "
          "\"sleeve\", wall_degC = 30.0 }");
  return text;
}

TEST(LawDescription, laws_give_their_items_what_they_are_at_the_nominal_temperatures) {
  const Spindle s = parse_spindle(jacket_with_laws(), "s.toml");
  ASSERT_TRUE(s.heats[0].physics && s.contacts[0].physics && s.films[0].physics);
  EXPECT_NEAR(*s.heats[0].heat_W, 3.0 * 256.0 * 0.5 * (1.0 + 0.00393 * 20.0), 1e-9);
  EXPECT_EQ(s.heats[0].physics->first.part, 0);
  EXPECT_GT(s.contacts[0].conductance_W_per_m2K, 1000.0);
  EXPECT_GT(s.films[0].coefficient_W_per_m2K, 2.0);
  EXPECT_LT(s.films[0].coefficient_W_per_m2K, 20.0);
  EXPECT_EQ(s.films[0].physics->first.part, 1);
  EXPECT_EQ(s.films[0].physics->second.environment, 0);
  for (const std::size_t segment : s.circuits[0].segments) {
    const Film& film = s.films[segment];
    ASSERT_TRUE(film.physics);
    EXPECT_EQ(film.physics->circuit, 0);
    EXPECT_EQ(film.physics->second.environment, 1);
    EXPECT_GT(film.coefficient_W_per_m2K, 200.0);
    EXPECT_EQ(film.coefficient_W_per_m2K, s.films[s.circuits[0].segments[0]].coefficient_W_per_m2K);
  }
}

TEST(LawDescription, wrong_laws_are_refused_by_line_and_key) {
  const auto refusal = [](const std::string& from, const std::string& to) -> std::string {
    std::string text = jacket_with_laws();
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    try {
      parse_spindle(text, "s.toml");
    } catch (const rom::InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto expect = [&](const std::string& from, const std::string& to, const std::string& says) {
    const std::string said = refusal(from, to);
    EXPECT_NE(said.find(says), std::string::npos) << to << ": " << said;
  };
  expect("law = { kind = \"copper_loss\"", "heat_W = 3\nlaw = { kind = \"copper_loss\"",
         "heat.stator.heat_W: cannot stand");
  expect("\"copper_loss\"", "\"channel\"", "heat.stator.law.kind");
  expect("\"channel\"", "\"contact\"", "coolant_circuit.helix.law.kind");
  expect("winding = \"jacket\"", "winding = \"stator\"", "there is no part or surrounding \"stator\"");
  expect("pressure_Pa = 2.0e6", "pressure_Pa = 2.0e6, pressure = \"jacket/sleeve\"", "there is no contact pressure");
  expect("name = \"groove_1\",", "name = \"groove_1\", coefficient_W_per_m2K = 3,", "the circuit's law");
  expect("hydraulic_diameter_mm = 9.0", "hydraulic_diameter_mm = -9.0",
         "coolant_circuit.helix.law.hydraulic_diameter_mm");
}

}  // namespace description_laws_test
}  // namespace spindle_twin::fem_offline
