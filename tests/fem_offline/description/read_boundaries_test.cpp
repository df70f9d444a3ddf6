// Prescribed temperatures, radiation, fluxes, initial temperatures and expectations, read from text.
#include <gtest/gtest.h>

#include "fem_offline/description/face_conditions.hpp"
#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace description_read_boundaries_test {

const std::string held_outside = R"([[prescribed_temperature]]
name = "outside"
surrounding = "room"
regions = [[40, 50, 0, 40]]
)";

const std::string film_outside = R"([[film]]
name = "outside"
coefficient_W_per_m2K = 12
surrounding = "pocket"
regions = [[40, 50, 0, 40]]
only_parts = ["sleeve"]
)";

std::string with_radiation(const std::string& emissivity) {
  return sample_text +
         "[[radiation]]\nname = \"glow\"\nsurrounding = \"room\"\nregions = [[40, 50, 0, 40]]\nemissivity = " +
         emissivity + "\nmean_temperature_degC = 26.85\n";
}

std::string with_expectation(const std::string& lines) {
  return sample_text + "[verification]\nproves = \"reading\"\ntemperature_span_K = 10\n[[expect]]\n" + lines +
         "source = \"nowhere\"\n";
}

TEST(PrescribedTemperature, is_a_film_of_1e7_conductivities_per_element) {
  const Spindle all = parse_spindle(sample_with(film_outside, held_outside), "s.toml");
  ASSERT_EQ(all.films.size(), 3u);
  EXPECT_EQ(all.films[2].condition, &face_condition("prescribed_temperature"));
  EXPECT_DOUBLE_EQ(all.films[2].coefficient_W_per_m2K, 1e7 * 48.0 / 0.003);
  const Spindle sleeve =
      parse_spindle(sample_with(film_outside, held_outside + "only_parts = [\"sleeve\"]\n"), "s.toml");
  EXPECT_DOUBLE_EQ(sleeve.films[2].coefficient_W_per_m2K, 1e7 * 25.0 / 0.003);
}

TEST(PrescribedTemperature, takes_no_coefficient_of_its_own) {
  const std::string text = sample_with(film_outside, held_outside + "coefficient_W_per_m2K = 5\n");
  EXPECT_NE(message_of(text).find("prescribed_temperature.outside.coefficient_W_per_m2K"), std::string::npos)
      << message_of(text);
}

TEST(Radiation, coefficient_is_4_eps_sigma_T3) {
  const Spindle spindle = parse_spindle(with_radiation("0.5"), "s.toml");
  EXPECT_EQ(spindle.films[3].condition, &face_condition("radiation"));
  EXPECT_NEAR(spindle.films[3].coefficient_W_per_m2K, 4.0 * 0.5 * 5.670374419e-8 * 2.7e7, 1e-12);
}

TEST(Radiation, may_share_a_face_with_a_film_but_two_films_may_not) {
  EXPECT_EQ(message_of(with_radiation("0.5")), "no InputError");
  const std::string second = sample_text +
                             "[[film]]\nname = \"second\"\ncoefficient_W_per_m2K = 1\nsurrounding = \"room\"\n"
                             "regions = [[40, 50, 0, 40]]\n";
  EXPECT_NE(message_of(second).find("is hit by two laws"), std::string::npos) << message_of(second);
}

TEST(Radiation, emissivity_above_1_is_refused) {
  EXPECT_NE(message_of(with_radiation("1.1")).find("radiation.glow.emissivity"), std::string::npos)
      << message_of(with_radiation("1.1"));
}

TEST(Flux, acts_on_faces_only) {
  const std::string text = sample_with("density_W_per_m3 = 1e5", "flux_W_per_m2 = 1e5");
  EXPECT_NE(message_of(text).find("a flux acts on faces"), std::string::npos) << message_of(text);
}

TEST(Flux, beside_a_heat_is_refused) {
  const std::string text = sample_with("heat_W = 10", "heat_W = 10\nflux_W_per_m2 = 3");
  EXPECT_NE(message_of(text).find("either heat_W or density_W_per_m3 or flux_W_per_m2"), std::string::npos)
      << message_of(text);
}

TEST(Part, initial_temperature_arrives_in_kelvin_and_is_optional) {
  const Spindle spindle =
      parse_spindle(sample_with("name = \"shaft\"\n", "name = \"shaft\"\ninitial_degC = 80\n"), "s");
  EXPECT_DOUBLE_EQ(*spindle.parts[0].initial_K, 353.15);
  EXPECT_FALSE(spindle.parts[1].initial_K.has_value());
}

TEST(Expectation, is_read_with_its_default_tolerance) {
  const Spindle spindle = parse_spindle(
      with_expectation("quantity = \"temperature_degC\"\nof = \"bore\"\ntime_s = 3\ntarget = 5\n"), "dir/s.toml");
  ASSERT_TRUE(spindle.verification.has_value());
  const Expectation& expected = spindle.verification->expectations.at(0);
  EXPECT_EQ(*expected.time_s, 3.0);
  EXPECT_EQ(expected.tolerance, 1e-4);
}

TEST(Expectation, of_something_unknown_is_refused_with_its_line) {
  const std::string text = with_expectation("quantity = \"heat_W\"\nof = \"bore\"\ntarget = 5\n");
  EXPECT_NE(message_of(text).find("there is no \"bore\" with a heat_W"), std::string::npos) << message_of(text);
}

}  // namespace description_read_boundaries_test
}  // namespace spindle_twin::fem_offline
