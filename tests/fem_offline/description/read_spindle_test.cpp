#include <gtest/gtest.h>
#include <sodium.h>

#include <fstream>

#include "tests/fem_offline/description/sample_spindle.hpp"
#include "tests/support/temporary_folder.hpp"

namespace spindle_twin::fem_offline {
namespace description_read_spindle_test {

TEST(Description, every_item_arrives_in_si_with_its_line) {
  const Spindle s = parse_spindle(sample_text, "s.toml");
  EXPECT_EQ(s.name, "sample");
  EXPECT_EQ(s.file, "s.toml");
  ASSERT_EQ(s.materials.size(), 2u);
  EXPECT_EQ(s.materials[0].conductivity_z_W_per_mK, 48.0);
  EXPECT_EQ(s.materials[1].conductivity_r_W_per_mK, 25.0);
  EXPECT_EQ(s.materials[1].conductivity_z_W_per_mK, 4.0);
  EXPECT_EQ(s.materials[1].where.line, 19);
  ASSERT_EQ(s.parts.size(), 2u);
  EXPECT_EQ(s.parts[1].material, 1u);
  ASSERT_EQ(s.parts[1].shapes.front().size(), 4u);
  EXPECT_DOUBLE_EQ(s.parts[1].shapes.front()[2].r_m, 0.040);
  EXPECT_DOUBLE_EQ(s.parts[1].shapes.front()[2].z_m, 0.100);
  ASSERT_EQ(s.contacts.size(), 1u);
  ASSERT_TRUE(s.contacts[0].fit.has_value());
  EXPECT_DOUBLE_EQ(s.contacts[0].fit->interference_m, 6e-6);
  EXPECT_DOUBLE_EQ(s.contacts[0].fit->outer_radius_m, 0.040);
  ASSERT_EQ(s.surroundings.size(), 3u);
  EXPECT_EQ(s.surroundings[2].kind, SurroundingKind::air);
  EXPECT_EQ(s.surroundings[2].capacity_J_per_K, 0.2);
  EXPECT_EQ(s.films[1].surrounding, 1u);
  EXPECT_EQ(s.films[2].only_parts, (std::vector<std::size_t>{1}));
  EXPECT_DOUBLE_EQ(s.operating.surrounding_K[0], 295.15);
  EXPECT_DOUBLE_EQ(s.operating.surrounding_K[1], 291.15);
  EXPECT_DOUBLE_EQ(s.operating.reference_temperature_K, 293.15);
  EXPECT_EQ(s.operating.speed_rpm, 3000.0);
  EXPECT_EQ(s.operating.load, 0.5);
  EXPECT_DOUBLE_EQ(s.mesh.element_size_m, 0.003);
  EXPECT_EQ(s.mesh.degree, 1);
  EXPECT_EQ(s.heats[0].shares[1].weight, 0.5);
  EXPECT_TRUE(s.heats[0].law.zero_at_standstill);
  EXPECT_EQ(*s.heats[1].shares[0].on_contact_with, 1u);
  EXPECT_DOUBLE_EQ(s.heats[1].shares[1].on_face->z1_m, 0.080);
  EXPECT_EQ(s.deformations[0].sign, -1.0);
  EXPECT_EQ(s.deformations[0].direction, Direction::axial);
}

TEST(Description, hash_is_the_sha256_of_the_text) {
  // FIPS 180-2, appendix B.1: SHA-256 of "abc" pins the function; the description's hash must be the same function.
  unsigned char digest[crypto_hash_sha256_BYTES];
  crypto_hash_sha256(digest, reinterpret_cast<const unsigned char*>("abc"), 3);
  char hex[2 * sizeof digest + 1];
  EXPECT_STREQ(sodium_bin2hex(hex, sizeof hex, digest, sizeof digest),
               "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  crypto_hash_sha256(digest, reinterpret_cast<const unsigned char*>(sample_text.data()), sample_text.size());
  EXPECT_EQ(parse_spindle(sample_text, "s.toml").hash, sodium_bin2hex(hex, sizeof hex, digest, sizeof digest));
  EXPECT_NE(parse_spindle(sample_text + "\n", "s.toml").hash, parse_spindle(sample_text, "s.toml").hash);
}

TEST(Description, file_and_text_read_the_same) {
  const tests::TemporaryFolder folder;
  const std::string path = folder.write("s.toml", sample_text);
  const Spindle s = read_spindle(path);
  EXPECT_EQ(s.hash, parse_spindle(sample_text, "s.toml").hash);
  EXPECT_EQ(s.parts[0].where.file, path);
}

TEST(BadDescription, unreadable_file) {
  try {
    read_spindle("/nowhere/s.toml");
    FAIL() << "no error";
  } catch (const rom::InputError& error) {
    EXPECT_STREQ(error.what(), "/nowhere/s.toml: cannot be read as a file");
  }
}

TEST(BadDescription, syntax_error) {
  const std::string message = message_of("name = \"x\"\nspeed = = 3\n");
  EXPECT_EQ(message.substr(0, 27), "s.toml:2: not valid TOML: E") << message;
}

TEST(BadDescription, unknown_key) {
  EXPECT_EQ(message_of(sample_with("capacity_J_per_K = 0.2", "capacity_J_per_K = 0.2\ncolour = 3")),
            "s.toml:50: surrounding.pocket.colour: unknown key; allowed here: name, kind, capacity_J_per_K");
  EXPECT_EQ(message_of(sample_with("degree = 1", "degre = 1")),
            "s.toml:9: mesh.degre: unknown key, did you mean \"degree\"?; allowed here: element_size_mm, degree, "
            "cells_across, part_time_limit_s, contact_element_size_mm, corner_element_size_mm, curved_arcs, "
            "arc_sagitta_mm");
  EXPECT_EQ(message_of(sample_with("kind = \"coolant\"", "kind = \"coolant\"\ncapacity_J_per_K = 1")),
            "s.toml:46: surrounding.water.capacity_J_per_K: unknown key; allowed here: name, kind");
}

TEST(BadDescription, missing_key) {
  EXPECT_EQ(message_of(sample_with("density_kg_per_m3 = 7650\n", "")),
            "s.toml:18: material.stack.density_kg_per_m3: this key is required");
}

TEST(BadDescription, missing_material) {
  EXPECT_EQ(message_of(sample_with("material = \"stack\"", "material = \"brass\"")),
            "s.toml:33: part.sleeve.material: there is no material \"brass\"; there are: stack, steel");
  EXPECT_EQ(message_of(sample_with("material = \"stack\"\n", "")),
            "s.toml:31: part.sleeve.material: this key is required");
}

TEST(BadDescription, unknown_references) {
  EXPECT_EQ(message_of(sample_with("between = [\"shaft\", \"sleeve\"]", "between = [\"shaft\", \"slewe\"]")),
            "s.toml:37: contact.shaft-slewe.between: there is no part \"slewe\"; there are: shaft, sleeve");
  EXPECT_EQ(message_of(sample_with("surrounding = \"pocket\"", "surrounding = \"oil\"")),
            "s.toml:64: film.outside.surrounding: there is no surrounding \"oil\"; there are: pocket, room, water");
  EXPECT_EQ(message_of(sample_with("only_parts = [\"sleeve\"]", "only_parts = [\"nut\"]")),
            "s.toml:66: film.outside.only_parts: there is no part \"nut\"; there are: shaft, sleeve");
  EXPECT_EQ(message_of(sample_with("water = 18", "pocket = 18")),
            "s.toml:6: operating.temperatures_degC.pocket: an air volume finds its own temperature; only ambient and "
            "coolant are given");
}

TEST(BadDescription, negative_value) {
  EXPECT_EQ(message_of(sample_with("conductance_W_per_m2K = 5000", "conductance_W_per_m2K = -5000")),
            "s.toml:38: contact.shaft-sleeve.conductance_W_per_m2K: must be a number above 0, is -5000");
  EXPECT_EQ(message_of(sample_with("heat_W = 10", "heat_W = -10")),
            "s.toml:77: heat.friction.heat_W: must be a number of at least 0, is -10");
  EXPECT_EQ(message_of(sample_with("[[0, 20, 0, 100]]", "[[-1, 20, 0, 100]]")),
            "s.toml:30: part.shaft.rectangles: every entry must be a number from 0 to 100000, is -1");
}

TEST(BadDescription, non_finite_value) {
  EXPECT_EQ(message_of(sample_with("density_kg_per_m3 = 7650", "density_kg_per_m3 = nan")),
            "s.toml:22: material.stack.density_kg_per_m3: must be a number above 0, is nan");
  EXPECT_EQ(message_of(sample_with("coefficient_W_per_m2K = 300", "coefficient_W_per_m2K = inf")),
            "s.toml:58: film.groove.coefficient_W_per_m2K: must be a number above 0, is inf");
}

TEST(BadDescription, value_out_of_range) {
  EXPECT_EQ(message_of(sample_with("poisson_ratio = 0.25", "poisson_ratio = 0.5")),
            "s.toml:25: material.stack.poisson_ratio: must be a number from 0 to 0.5 (excluded), is 0.5");
  EXPECT_EQ(message_of(sample_with("degree = 1", "degree = 9")),
            "s.toml:9: mesh.degree: must be an integer from 1 to 4, is 9");
  EXPECT_EQ(message_of(sample_with("room = 22", "room = -300")),
            "s.toml:6: operating.temperatures_degC.room: must be a number from -273.15 (excluded) to 1000, is -300");
  EXPECT_EQ(message_of(sample_with("[[20, 40, 0, 100]]", "[[40, 20, 0, 100]]")),
            "s.toml:34: part.sleeve.rectangles: [40, 20, 0, 100] must be [r0, r1, z0, z1] with r0 < r1 and z0 < z1");
  EXPECT_EQ(message_of(sample_with("fit_radius_mm = 20", "fit_radius_mm = 50")),
            "s.toml:39: contact.shaft-sleeve.interference_fit.fit_radius_mm: must lie between inner_radius_mm and "
            "outer_radius_mm");
}

TEST(BadDescription, doubled_names) {
  EXPECT_EQ(message_of(sample_with("name = \"sleeve\"", "name = \"shaft\"")),
            "s.toml:32: part.shaft.name: the name \"shaft\" is taken by the part of line 28");
  EXPECT_EQ(message_of(sample_with("name = \"groove\"", "name = \"ends\"")),
            "s.toml:57: film.ends.name: the name \"ends\" is taken by the film of line 51");
  EXPECT_EQ(message_of(sample_with("[[surrounding]]\nname = \"room\"",
                                   "[[contact]]\nbetween = [\"sleeve\", \"shaft\"]\nconductance_W_per_m2K = 1\n"
                                   "[[surrounding]]\nname = \"room\"")),
            "s.toml:41: contact.sleeve-shaft.between: this contact is declared already in line 37");
  const std::string doubled_key = message_of(sample_with("degree = 1", "degree = 1\ndegree = 2"));
  EXPECT_EQ(doubled_key.substr(0, 27), "s.toml:10: not valid TOML: ") << doubled_key;
}

TEST(BadDescription, name_that_could_not_be_a_key) {
  EXPECT_EQ(
      message_of(sample_with("name = \"sleeve\"", "name = \"rear sleeve\"")),
      "s.toml:32: part[2].name: must be letters, digits and underscores and start with a letter, is \"rear sleeve\"");
}

TEST(BadDescription, heat_without_clear_amount) {
  EXPECT_EQ(message_of(sample_with("heat_W = 10", "heat_W = 10\ndensity_W_per_m3 = 5")),
            "s.toml:77: heat.friction.heat_W: a heat needs either heat_W or density_W_per_m3 or flux_W_per_m2 or law");
  EXPECT_EQ(message_of(sample_with("weight = 0.75", "weight = 0.5")),
            "s.toml:78: heat.friction.shares: the weights must add up to 1, they make 0.75");
  EXPECT_EQ(message_of(sample_with("heat_W = 10", "density_W_per_m3 = 10")),
            "s.toml:78: heat.friction.shares: a density without density_over acts in volumes only, not on faces");
}

TEST(BadDescription, speed_law_that_is_not_one_at_the_reference_state) {
  EXPECT_EQ(message_of(sample_with("constant = 0.25", "constant = 0.5")),
            "s.toml:55: film.ends.speed_law: constant, coefficients and load_squared must add up to 1, the value at "
            "reference speed and full load; they make 1.25");
}

TEST(ShippedDescriptions, reference_holds_the_lists_of_the_spindle) {
  const Spindle s = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
  EXPECT_EQ(s.parts.size(), 22u);
  EXPECT_EQ(s.contacts.size(), 31u);
  EXPECT_EQ(s.films.size(), 8u);
  EXPECT_EQ(s.gap_films.size(), 1u);
  EXPECT_EQ(s.heats.size(), 4u);
  ASSERT_EQ(s.key_points.size(), 3u);
  EXPECT_EQ(s.key_points[0].name, "inner");
  EXPECT_EQ(s.key_points[1].name, "middle");
  EXPECT_EQ(s.key_points[2].name, "outer");
  EXPECT_EQ(s.deformations.front().name, "nose");
  EXPECT_EQ(s.operating.speed_rpm, 6000.0);
  for (const double temperature_K : s.operating.surrounding_K) EXPECT_DOUBLE_EQ(temperature_K, 300.15);
}

}  // namespace description_read_spindle_test
}  // namespace spindle_twin::fem_offline
