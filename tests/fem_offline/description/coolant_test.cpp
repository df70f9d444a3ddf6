#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "fem_offline/description/spindle.hpp"

namespace spindle_twin::fem_offline {
namespace description_coolant_test {

std::string jacket_text() {
  std::ifstream file(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/jacket_circuit.toml");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The message that the text with `from` replaced by `to` is refused with.
std::string refusal(const std::string& from, const std::string& to) {
  std::string text = jacket_text();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  try {
    parse_spindle(text, "s.toml");
  } catch (const rom::InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CoolantDescription, segments_are_films_in_the_order_of_the_flow) {
  const Spindle s = parse_spindle(jacket_text(), "s.toml");
  ASSERT_EQ(s.circuits.size(), 1u);
  const CoolantCircuit& circuit = s.circuits[0];
  EXPECT_EQ(circuit.name, "helix");
  EXPECT_EQ(s.surroundings[circuit.inlet].name, "coolant");
  EXPECT_EQ(circuit.flow_kg_per_s, 0.02);
  EXPECT_EQ(circuit.heat_capacity_J_per_kgK, 4180.0);
  ASSERT_EQ(circuit.segments.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const Film& film = s.films[circuit.segments[i]];
    EXPECT_EQ(film.name, "groove_" + std::to_string(i + 1));
    EXPECT_EQ(film.coefficient_W_per_m2K, 1500.0);
    EXPECT_EQ(film.surrounding, circuit.inlet);
    EXPECT_DOUBLE_EQ(film.regions.front().z0_m, 0.012 + 0.030 * static_cast<double>(i));
  }
}

TEST(CoolantDescription, backward_and_standing_flow_are_allowed) {
  EXPECT_EQ(refusal("flow_kg_per_s = 0.02", "flow_kg_per_s = -0.02"), "accepted");
  EXPECT_EQ(refusal("flow_kg_per_s = 0.02", "flow_kg_per_s = 0"), "accepted");
}

TEST(CoolantDescription, bad_circuits_are_refused_by_name_and_line) {
  const auto says = [](const std::string& message, const std::string& field) {
    EXPECT_EQ(message.rfind("s.toml:", 0), 0u) << message;
    EXPECT_NE(message.find(field), std::string::npos) << message;
  };
  says(refusal("inlet = \"coolant\"", "inlet = \"ambient\""), "inlet");
  says(refusal("inlet = \"coolant\"", "inlet = \"brine\""), "inlet");
  says(refusal("flow_kg_per_s = 0.02", "flow_kg_per_s = inf"), "flow_kg_per_s");
  says(refusal("heat_capacity_J_per_kgK = 4180", "heat_capacity_J_per_kgK = 0"), "heat_capacity_J_per_kgK");
  says(refusal("coefficient_W_per_m2K = 1500\n", ""), "coefficient_W_per_m2K");
  says(refusal("groove_2", "groove_1"), "groove_1");
  says(refusal("groove_2", "outer"), "outer");
}

}  // namespace description_coolant_test
}  // namespace spindle_twin::fem_offline
