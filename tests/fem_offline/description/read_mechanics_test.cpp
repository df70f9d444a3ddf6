// Supports, outputs, contact pressures, stress probes and imposed temperatures of a description.
#include <gtest/gtest.h>

#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace description_read_mechanics_test {

const std::string support_text = "[[support]]\npart = \"sleeve\"\nface = [20, 40, 100, 100]\n";

/// The sample with more behind it.
Spindle sample_and(const std::string& more) { return parse_spindle(sample_text + more, "s.toml"); }

Support support_from(const std::string& keys) {
  const Spindle spindle = sample_and("[[support]]\npart = \"sleeve\"\n" + keys);
  EXPECT_EQ(spindle.supports.size(), 2U);
  return spindle.supports.back();
}

TEST(Mechanics, supports_hold_spring_or_stay_plane) {
  const Support usual = support_from("face = [20, 40, 0, 0]\n");
  EXPECT_EQ(usual.hold_r, Hold::free);
  EXPECT_EQ(usual.hold_z, Hold::fixed);
  const Support both = support_from("at = [40, 50]\nholds = \"rz\"\n");
  EXPECT_TRUE(both.is_point());
  EXPECT_DOUBLE_EQ(both.face.r0_m, 0.040);
  EXPECT_EQ(both.hold_r, Hold::fixed);
  EXPECT_EQ(both.hold_z, Hold::fixed);
  EXPECT_EQ(support_from("face = [20, 40, 0, 0]\nholds = \"r\"\n").hold_z, Hold::free);
  const Support spring = support_from("face = [20, 40, 0, 0]\nstiffness_r_N_per_m = 2e8\n");
  EXPECT_EQ(spring.hold_r, Hold::spring);
  EXPECT_EQ(spring.hold_z, Hold::free);
  EXPECT_EQ(spring.stiffness_r_N_per_m, 2e8);
  const Support plane = support_from("face = [20, 40, 0, 0]\nstays_plane = true\n");
  EXPECT_EQ(plane.hold_z, Hold::plane);
  EXPECT_EQ(plane.hold_r, Hold::free);
}

TEST(Mechanics, outputs_arrive_and_every_fit_has_its_pressure) {
  const Spindle spindle = sample_and(
      "[[deformation]]\nname = \"shift\"\npart = \"shaft\"\nat = [0, 100]\npositive_along = \"+z\"\nminus = \"nose\"\n"
      "[[stress_probe]]\nname = \"core\"\npart = \"shaft\"\nat = [5, 50]\n"
      "[imposed_temperature]\nrise_K = \"r_mm + z\"\n");
  const DeformationOutput& shift = spindle.deformations.at(1);
  EXPECT_DOUBLE_EQ(shift.at.value().z_m, 0.1);
  EXPECT_EQ(shift.minus.value(), 0U);
  EXPECT_DOUBLE_EQ(spindle.stress_probes.at(0).at.r_m, 0.005);
  EXPECT_EQ(spindle.imposed_temperature.value().rise_K, "r_mm + z");
  EXPECT_GT(spindle.imposed_temperature->where.line, 0);
  ASSERT_EQ(spindle.contact_pressures.size(), 1U);
  EXPECT_EQ(spindle.contact_pressures[0].name, "shaft/sleeve");

  const Spindle named = sample_and("[[contact_pressure]]\nname = \"seat\"\nbetween = [\"sleeve\", \"shaft\"]\n");
  ASSERT_EQ(named.contact_pressures.size(), 1U);
  EXPECT_EQ(named.contact_pressures[0].name, "seat");
  EXPECT_EQ(named.contact_pressures[0].contact, 0U);

  const Spindle bolted = parse_spindle(
      sample_with("interference_fit = { inner_radius_mm = 0, fit_radius_mm = 20, outer_radius_mm = 40, interference_um "
                  "= 6 }",
                  "preload_pressure_Pa = 3e6"),
      "s.toml");
  EXPECT_EQ(bolted.contacts[0].preload_pressure_Pa.value(), 3e6);
  EXPECT_EQ(bolted.contact_pressures.at(0).name, "shaft/sleeve");
}

TEST(BadMechanics, every_slip_is_one_error_that_says_what_is_allowed) {
  const std::string support = "[[support]]\npart = \"sleeve\"\n";
  const std::string output = "[[deformation]]\nname = \"x\"\npart = \"shaft\"\npositive_along = \"+z\"\n";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {support, "needs either a face"},
      {support + "face = [20, 40, 0, 0]\nat = [20, 0]\n", "needs either a face"},
      {support + "face = [20, 40, 0, 0]\nholds = \"all\"\n", "z, r, rz"},
      {support + "face = [20, 40, 0, 0]\nholds = \"z\"\nstays_plane = true\n", "a support either holds, or"},
      {support + "face = [20, 40, 0, 0]\nstiffness_z_N_per_m = 0\n", "stiffness_z_N_per_m"},
      {support + "at = [20, 0]\nstays_plane = true\n", "a point cannot"},
      {support + "at = [30, 50]\n", "the outline of part \"sleeve\" does not pass (r 30, z 50) mm"},
      {output, "needs either a face"},
      {output + "at = [30, 50]\n", "(r 30, z 50) mm lies outside part \"shaft\""},
      {output + "at = [0, 50]\nminus = \"x\"\n", "there is no deformation output \"x\"; there are: nose"},
      {"[[stress_probe]]\nname = \"p\"\npart = \"shaft\"\nat = [30, 50]\n", "lies outside part \"shaft\""},
      {"[[contact_pressure]]\nname = \"p\"\nbetween = [\"shaft\", \"shaft\"]\n", "listed twice"},
      {"[imposed_temperature]\nrise = \"r\"\n", "rise_K"},
  };
  for (const auto& [more, expected] : cases) {
    const std::string message = message_of(sample_text + more);
    EXPECT_NE(message.find(expected), std::string::npos) << more << "\n" << message;
    EXPECT_EQ(message.find("s.toml:"), 0U) << message;
  }
}

TEST(BadMechanics, mechanics_without_a_support_is_refused) {
  const std::string nose = sample_text.substr(sample_text.find("[[deformation]]"));
  const std::string bare = sample_with(support_text, "");
  const std::string without_nose = bare.substr(0, bare.size() - nose.size());
  EXPECT_EQ(message_of(without_nose), "no InputError");
  EXPECT_NE(message_of(bare).find("a deformation output needs a support"), std::string::npos);
  const std::string probe = "[[stress_probe]]\nname = \"p\"\npart = \"shaft\"\nat = [5, 50]\n";
  EXPECT_NE(message_of(without_nose + probe).find("a stress needs a support"), std::string::npos);
  const std::string pressure = "[[contact_pressure]]\nname = \"p\"\nbetween = [\"shaft\", \"sleeve\"]\n";
  EXPECT_NE(message_of(without_nose + pressure).find("a contact pressure needs a support"), std::string::npos);
}

}  // namespace description_read_mechanics_test
}  // namespace spindle_twin::fem_offline
