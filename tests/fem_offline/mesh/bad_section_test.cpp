#include <gtest/gtest.h>

#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace mesh_bad_section_test {

std::string without_contact() {
  std::string text = sample_text;
  const auto from = text.find("[[contact]]"), to = text.find("[[surrounding]]");
  return text.erase(from, to - from);
}

TEST(BadSection, the_sample_itself_is_good) { EXPECT_EQ(message_of(sample_text), "no InputError"); }

TEST(BadSection, touching_parts_with_no_contact) {
  EXPECT_EQ(
      message_of(without_contact()),
      "s.toml:32: part.sleeve: touches part \"shaft\" from (r 20, z 0) to (r 20, z 100) mm, but no contact between "
      "the two is declared");
}

TEST(BadSection, declared_contact_that_does_not_touch) {
  EXPECT_EQ(message_of(sample_with("[[20, 40, 0, 100]]", "[[21, 40, 0, 100]]")),
            "s.toml:37: contact.shaft-sleeve: parts \"shaft\" and \"sleeve\" do not touch");
  // A common corner is no contact.
  EXPECT_EQ(message_of(sample_with("[[20, 40, 0, 100]]", "[[20, 40, 100, 200]]")),
            "s.toml:37: contact.shaft-sleeve: parts \"shaft\" and \"sleeve\" do not touch");
}

TEST(BadSection, overlapping_parts) {
  EXPECT_EQ(message_of(sample_with("[[20, 40, 0, 100]]", "[[19.9, 40, 0, 100]]")),
            "s.toml:32: part.sleeve: overlaps part \"shaft\" in the area (r 19.9, z 0) to (r 20, z 100) mm");
}

TEST(BadSection, film_on_no_face) {
  EXPECT_EQ(message_of(sample_with("regions = [[38, 40, 40, 60]]", "regions = [[45, 50, 40, 60]]")),
            "s.toml:57: film.groove: acts on no face: no exposed face looks into its regions");
  EXPECT_EQ(message_of(sample_with("only_parts = [\"sleeve\"]", "only_parts = [\"shaft\"]")),
            "s.toml:62: film.outside: acts on no face: no exposed face of shaft looks into its regions");
}

TEST(BadSection, outer_face_with_no_film) {
  EXPECT_EQ(
      message_of(sample_with("regions = [[40, 50, 60, 100]]", "regions = [[40, 50, 60, 90]]")),
      "s.toml:32: part.sleeve: the face from (r 40, z 90) to (r 40, z 100) mm has no film, no gap film, no contact "
      "and no adiabatic region");
}

TEST(BadSection, face_hit_by_two_laws) {
  EXPECT_EQ(message_of(sample_with("regions = [[40, 50, 0, 40]]", "regions = [[40, 50, 0, 40], [38, 40, 40, 45]]")),
            "s.toml:62: film.outside: the face of part \"sleeve\" from (r 40, z 40) to (r 38, z 40) mm is hit by two "
            "laws: film \"groove\" and film \"outside\"");
  EXPECT_EQ(message_of(sample_with("regions = [[40, 50, 60, 100]]", "regions = [[40, 50, 30, 100]]")),
            "s.toml:68: adiabatic.lagging: the face of part \"sleeve\" from (r 40, z 30) to (r 40, z 40) mm is hit by "
            "two laws: film \"outside\" and adiabatic region \"lagging\"");
}

TEST(BadSection, adiabatic_region_and_gap_on_no_face) {
  EXPECT_EQ(message_of(sample_text + "[[adiabatic]]\nname = \"far\"\nregions = [[90, 95, 0, 1]]\n"),
            "s.toml:95: adiabatic.far: acts on no face: no exposed face looks into its regions");
  EXPECT_EQ(
      message_of(sample_text + "[[gap_film]]\nname = \"gap\"\ncoefficient_W_per_m2K = 5\nbetween = [\"shaft\", "
                               "\"sleeve\"]\nregion = [20, 20.5, 0, 100]\n"),
      "s.toml:95: gap_film.gap: acts on no face: in its region no faces of parts \"shaft\" and \"sleeve\" look at "
      "each other");
}

TEST(BadSection, outputs_and_supports_off_their_part) {
  EXPECT_EQ(message_of(sample_with("at = [20, 50]", "at = [19, 50]")),
            "s.toml:86: key_point.bore: (r 19, z 50) mm lies outside part \"sleeve\"");
  EXPECT_EQ(message_of(sample_with("face = [0, 20, 0, 0]", "face = [0, 20, 1, 1]")),
            "s.toml:90: deformation.nose: part \"shaft\" has no face in (r 0, z 1) to (r 20, z 1) mm");
  EXPECT_EQ(message_of(sample_with("face = [20, 40, 100, 100]", "face = [41, 50, 100, 100]")),
            "s.toml:84: support: part \"sleeve\" has no face in (r 41, z 100) to (r 50, z 100) mm");
}

TEST(BadSection, heat_on_no_face) {
  EXPECT_EQ(message_of(sample_with("on_face = [40, 40, 60, 80]", "on_face = [39, 39, 60, 80]")),
            "s.toml:76: heat.friction: part \"sleeve\" has no exposed face in (r 39, z 60) to (r 39, z 80) mm");
}

TEST(BadSection, fit_whose_inner_part_is_named_second) {
  EXPECT_EQ(message_of(sample_with("between = [\"shaft\", \"sleeve\"]", "between = [\"sleeve\", \"shaft\"]")),
            "s.toml:37: contact.sleeve-shaft.interference_fit: part \"sleeve\" does not sit in part \"shaft\" at "
            "fit_radius_mm; the inner part is named first in \"between\"");
}

TEST(BadSection, polygon_that_crosses_itself) {
  const std::string message = message_of(sample_with(
      "rectangles = [[0, 20, 0, 100]]", "polygons = [{ points = [[0, 0], [20, 100], [20, 0], [0, 100]] }]"));
  EXPECT_EQ(message.substr(0, 81), "s.toml:28: part.shaft: the polygon that starts at (r 0, z 0) is not simple: Geome")
      << message;
}

TEST(BadSection, part_that_its_cuts_eat_up) {
  EXPECT_EQ(message_of(sample_with("cut_rectangles = [[38, 40, 40, 60]]", "cut_rectangles = [[0, 40, 0, 100]]")),
            "s.toml:32: part.sleeve: nothing is left of this part after its cuts");
}

}  // namespace mesh_bad_section_test
}  // namespace spindle_twin::fem_offline
