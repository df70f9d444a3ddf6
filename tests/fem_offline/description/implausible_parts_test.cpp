// Mistakes of units in materials and joints are found, each with its line.
#include "fem_offline/description/implausible_parts.hpp"

#include <gtest/gtest.h>

#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace description_implausible_parts_test {

/// "line: field: message" of each.
std::vector<std::string> found_in(const std::string& text) {
  const Spindle spindle = parse_spindle(text, "s.toml");
  std::vector<std::string> lines;
  for (const auto& [where, what] : implausible_parts(spindle)) {
    lines.push_back(std::to_string(where.line) + ": " + what.field + ": " + what.message);
  }
  return lines;
}

/// Replaces the one `from` of the sample; gives the only finding.
std::string only(const std::string& from, const std::string& to) {
  const std::vector<std::string> lines = found_in(sample_with(from, to));
  return lines.size() == 1 ? lines[0] : std::to_string(lines.size()) + " findings";
}

TEST(ImplausibleParts, the_sample_is_believed) { EXPECT_TRUE(found_in(sample_text).empty()); }

TEST(ImplausibleParts, a_mistake_of_units_is_named_with_its_line) {
  EXPECT_EQ(only("youngs_modulus_Pa = 150e9", "youngs_modulus_Pa = 150"),
            "19: material stack: youngs_modulus_Pa: 150 is not plausible; believed is 1e+06 to 1.3e+12 Pa, not GPa");
  EXPECT_EQ(only("expansion_per_K = 1.2e-5", "expansion_per_K = 12"),
            "19: material stack: expansion_per_K: 12 is not plausible; believed is 0 to 0.0005 1/K, 1.2e-5 for steel");
  EXPECT_EQ(only("density_kg_per_m3 = 7650", "density_kg_per_m3 = 7.65e-6"),
            "19: material stack: density_kg_per_m3: 7.65e-06 is not plausible; believed is 0.1 to 25000 kg/m3");
  EXPECT_EQ(only("heat_capacity_J_per_kgK = 460", "heat_capacity_J_per_kgK = 0.46"),
            "19: material stack: heat_capacity_J_per_kgK: 0.46 is not plausible; believed is 50 to 6000 J/kgK");
  EXPECT_EQ(
      only("reference_temperature_degC = 20", "reference_temperature_degC = 293.15"),
      "5: operating: reference_temperature_degC: 293.15 is not plausible; believed is -40 to 100 degC, not kelvin");
}

TEST(ImplausibleParts, a_fit_that_would_yield_is_named) {
  EXPECT_EQ(only("interference_um = 6", "interference_um = 5000"),
            "37: shaft-sleeve: interference_um: 5000 is not plausible; believed is 0 to 200 um of radius, beyond which "
            "every metal yields");
}

}  // namespace description_implausible_parts_test
}  // namespace spindle_twin::fem_offline
