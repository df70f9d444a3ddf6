#include "fem_offline/mesh/section.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace mesh_section_test {

using std::numbers::pi;

Section section_of(const std::string& text) { return build_section(parse_spindle(text, "s.toml")); }

double length_of(const Point& a, const Point& b) { return std::hypot(b.r_m - a.r_m, b.z_m - a.z_m); }

double area_of(const Point& a, const Point& b) { return pi * (a.r_m + b.r_m) * length_of(a, b); }

double area_of(const Section& section, PieceKind kind, std::size_t index, int side = 0) {
  double sum = 0.0;
  for (const auto& piece : section.pieces) {
    if (piece.kind == kind && piece.index == index && piece.side == side) sum += area_of(piece.start, piece.end);
  }
  return sum;
}

/// A cone of half angle 45 degrees in a bored ring, contact on the slanted face, with a stub below it.
const std::string cone_text = R"(name = "cone"
[operating]
speed_rpm = 1
reference_temperature_degC = 20
temperatures_degC = { room = 20 }
)" + steel_text + R"([[part]]
name = "cone"
material = "steel"
polygons = [{ points = [[0, 0], [30, 0], [0, 90]] }]
[[part]]
name = "ring"
material = "steel"
polygons = [{ points = [[20, 30], [40, 30], [40, 60], [10, 60]] }]
[[contact]]
between = ["cone", "ring"]
conductance_W_per_m2K = 1000
[[surrounding]]
name = "room"
kind = "ambient"
[[film]]
name = "low"
coefficient_W_per_m2K = 10
surrounding = "room"
regions = [[0, 100, -10, 12]]
[[film]]
name = "high"
coefficient_W_per_m2K = 10
surrounding = "room"
regions = [[0, 100, 12, 100]]
)";

/// Two cylinders of unequal length across a gap, in a still room that is not modelled.
const std::string gap_text = R"(name = "gap"
[operating]
speed_rpm = 1
reference_temperature_degC = 20
temperatures_degC = { room = 20 }
)" + steel_text + R"([[part]]
name = "rotor"
material = "steel"
rectangles = [[0, 40, 10, 50]]
[[part]]
name = "stator"
material = "steel"
rectangles = [[40.5, 60, 0, 60]]
cut_rectangles = [[40.5, 45, 20, 30]]
[[surrounding]]
name = "room"
kind = "ambient"
[[gap_film]]
name = "gap"
coefficient_W_per_m2K = 100
between = ["rotor", "stator"]
region = [40, 40.5, 10, 50]
[[film]]
name = "outside"
coefficient_W_per_m2K = 10
surrounding = "room"
regions = [[60, 80, 0, 60]]
[[adiabatic]]
name = "rest"
regions = [[0, 60, -1, 0], [0, 40.5, 0, 10], [40, 45, 20, 30], [0, 40.5, 50, 60], [0, 60, 60, 61]]
)";

class SectionLaws : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    const std::string name = GetParam();
    spindle = name == "sample" ? parse_spindle(sample_text, name)
              : name == "cone" ? parse_spindle(cone_text, name)
              : name == "gap"  ? parse_spindle(gap_text, name)
                               : read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/" + name + ".toml");
    section = build_section(spindle);
  }
  Spindle spindle;
  Section section;
};

TEST_P(SectionLaws, pieces_of_every_outline_close) {
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    std::map<std::pair<long, long>, int> balance;  // starts minus ends at each point, nanometres
    const auto at = [](const Point& p) { return std::make_pair(std::lround(p.r_m * 1e9), std::lround(p.z_m * 1e9)); };
    for (const auto& piece : section.pieces) {
      if (piece.part != part) continue;
      ++balance[at(piece.start)];
      --balance[at(piece.end)];
    }
    EXPECT_FALSE(balance.empty());
    for (const auto& [point, count] : balance) {
      EXPECT_EQ(count, 0) << spindle.parts[part].name << " at " << point.first << ", " << point.second << " nm";
    }
  }
}

TEST_P(SectionLaws, pieces_cover_the_outline_and_nothing_else) {
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    double outline_m = 0.0, outline_m2 = 0.0, pieces_m = 0.0, pieces_m2 = 0.0;
    const auto add_ring = [&](const Polygon& ring) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        outline_m += length_of(ring[i], ring[(i + 1) % ring.size()]);
        outline_m2 += area_of(ring[i], ring[(i + 1) % ring.size()]);
      }
    };
    for (const auto& face : section.outlines[part].faces) {
      add_ring(face.outer);
      for (const auto& hole : face.holes) add_ring(hole);
    }
    for (const auto& piece : section.pieces) {
      if (piece.part != part) continue;
      pieces_m += length_of(piece.start, piece.end);
      pieces_m2 += area_of(piece.start, piece.end);
    }
    EXPECT_NEAR(pieces_m, outline_m, 1e-8) << spindle.parts[part].name;
    EXPECT_NEAR(pieces_m2, outline_m2, 1e-9) << spindle.parts[part].name;
  }
}

TEST_P(SectionLaws, divergence_theorem_gives_the_volume_from_the_pieces) {
  std::vector<double> volume_m3(spindle.parts.size(), 0.0);
  for (const auto& piece : section.pieces) {  // flux of (0, z): the surface integral of z n_z is the volume
    const double r0 = piece.start.r_m, r1 = piece.end.r_m, z0 = piece.start.z_m, z1 = piece.end.z_m;
    volume_m3[piece.part] -= 2.0 * pi * (r1 - r0) * (r0 * z0 / 3.0 + r1 * z1 / 3.0 + (r0 * z1 + r1 * z0) / 6.0);
  }
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    EXPECT_NEAR(volume_m3[part], section.outlines[part].volume_m3, 1e-9 * section.outlines[part].volume_m3 + 1e-13)
        << spindle.parts[part].name;
  }
}

TEST_P(SectionLaws, contacts_and_gaps_come_in_pairs_that_face_each_other) {
  std::map<std::size_t, std::vector<const BoundaryPiece*>> pairs;
  for (const auto& piece : section.pieces) {
    if (piece.kind == PieceKind::contact || piece.kind == PieceKind::gap) pairs[piece.pair].push_back(&piece);
  }
  for (const auto& [number, both] : pairs) {
    ASSERT_EQ(both.size(), 2u) << "pair " << number;
    const auto& a = both[0]->side == 0 ? *both[0] : *both[1];
    const auto& b = both[0]->side == 0 ? *both[1] : *both[0];
    EXPECT_EQ(a.side, 0);
    EXPECT_EQ(b.side, 1);
    EXPECT_EQ(a.kind, b.kind);
    EXPECT_EQ(a.index, b.index);
    if (a.kind == PieceKind::contact) {
      EXPECT_EQ(a.part, spindle.contacts[a.index].part_a);
      EXPECT_EQ(b.part, spindle.contacts[a.index].part_b);
      EXPECT_EQ(a.start.r_m, b.end.r_m);
      EXPECT_EQ(a.start.z_m, b.end.z_m);
      EXPECT_EQ(a.end.r_m, b.start.r_m);
      EXPECT_EQ(a.end.z_m, b.start.z_m);
    } else {
      EXPECT_EQ(a.part, spindle.gap_films[a.index].part_a);
      EXPECT_EQ(b.part, spindle.gap_films[a.index].part_b);
      EXPECT_EQ(a.start.z_m, b.end.z_m);
      EXPECT_EQ(a.end.z_m, b.start.z_m);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Spindles, SectionLaws,
                         testing::Values("sample", "cone", "gap", "reference", "shaft_in_sleeve", "two_rings"),
                         [](const auto& parameter) { return parameter.param; });

TEST(Section, volumes_of_cone_and_ring_are_the_closed_forms) {
  const Section section = section_of(cone_text);
  EXPECT_NEAR(section.outlines[0].volume_m3, pi / 3.0 * 0.03 * 0.03 * 0.09, 1e-16);
  const double frustum_m3 = pi / 3.0 * 0.03 * (0.02 * 0.02 + 0.02 * 0.01 + 0.01 * 0.01);
  EXPECT_NEAR(section.outlines[1].volume_m3, pi * 0.04 * 0.04 * 0.03 - frustum_m3, 1e-16);
  const Section rings = build_section(read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/two_rings.toml"));
  EXPECT_NEAR(rings.outlines[1].volume_m3, pi * (0.06 * 0.06 - 0.035 * 0.035) * 0.01, 1e-16);
}

TEST(Section, slanted_faces_touch_over_the_frustum) {
  const Section section = section_of(cone_text);
  const double frustum_m2 = pi * (0.02 + 0.01) * std::hypot(0.01, 0.03);
  EXPECT_NEAR(area_of(section, PieceKind::contact, 0, 0), frustum_m2, 1e-12);
  EXPECT_NEAR(area_of(section, PieceKind::contact, 0, 1), frustum_m2, 1e-12);
}

TEST(Section, slanted_faces_touch_although_their_corners_are_rounded_to_the_grid) {
  std::string text = cone_text;
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("[0, 90]", "[0, 77]");  // the line through (30, 0) meets r 20 at z 25.6666..., r 10 at z 51.3333...
  replace("[20, 30], [40, 30], [40, 60], [10, 60]", "[20, 25.666667], [40, 25], [40, 60], [10, 51.333333]");
  EXPECT_NEAR(area_of(section_of(text), PieceKind::contact, 0, 1), pi * (0.02 + 0.01) * std::hypot(0.01, 0.077 / 3),
              1e-9);
}

TEST(Section, slanted_face_is_cut_where_the_region_ends) {
  const Section section = section_of(cone_text);
  // The cone's face from r 30 (z 0) to r 26 (z 12), and its base.
  EXPECT_NEAR(area_of(section, PieceKind::film, 0), pi * (0.030 + 0.026) * std::hypot(0.004, 0.012) + pi * 0.03 * 0.03,
              1e-12);
}

TEST(Section, gap_acts_only_where_two_faces_look_at_each_other) {
  const Section section = section_of(gap_text);
  // 10 mm of the 40 mm look into the stator's groove.
  EXPECT_NEAR(area_of(section, PieceKind::gap, 0, 0), 2.0 * pi * 0.040 * 0.030, 1e-12);
  EXPECT_NEAR(area_of(section, PieceKind::gap, 0, 1), 2.0 * pi * 0.0405 * 0.030, 1e-12);
}

TEST(Section, face_boxes_cut_the_outline) {
  const Section section = section_of(sample_text);
  const Box face{0.040, 0.040, 0.060, 0.080};
  double inside_m2 = 0.0;
  for (const auto& piece : section.pieces) {
    if (piece.part == 1 && lies_in(piece, face)) inside_m2 += area_of(piece.start, piece.end);
  }
  EXPECT_NEAR(inside_m2, 2.0 * pi * 0.040 * 0.020, 1e-12);
}

TEST(Section, touching_rectangles_of_a_part_become_one_outline) {
  const Section section =
      section_of(sample_with("[[0, 20, 0, 100]]", "[[0, 12, 0, 100], [12, 20, 0, 30], [10, 20, 30, 100]]"));
  ASSERT_EQ(section.outlines[0].faces.size(), 1u);
  EXPECT_EQ(section.outlines[0].faces[0].outer.size(), 4u);
  EXPECT_TRUE(section.outlines[0].faces[0].holes.empty());
  EXPECT_NEAR(section.outlines[0].volume_m3, pi * 0.02 * 0.02 * 0.1, 1e-16);
}

TEST(Section, closed_cut_becomes_a_hole) {
  const Section section = section_of(
      sample_with("cut_rectangles = [[38, 40, 40, 60]]", "cut_rectangles = [[30, 32, 40, 60], [38, 40, 40, 60]]") +
      "[[adiabatic]]\nname = \"bubble\"\nregions = [[30, 32, 40, 60]]\n");
  ASSERT_EQ(section.outlines[1].faces.size(), 1u);
  EXPECT_EQ(section.outlines[1].faces[0].holes.size(), 1u);
  const double cuts_m3 = pi * 0.02 * (0.04 * 0.04 - 0.038 * 0.038 + 0.032 * 0.032 - 0.03 * 0.03);
  EXPECT_NEAR(section.outlines[1].volume_m3, pi * 0.1 * (0.04 * 0.04 - 0.02 * 0.02) - cuts_m3, 1e-15);
}

TEST(Section, reference_heats_come_to_the_published_watts) {
  const Spindle s = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/reference.toml");
  const Section section = build_section(s);
  const std::map<std::string, double> published_W{
      {"front_bearings", 55.1}, {"rear_bearings", 25.5}, {"stator", 291.9}, {"rotor", 79.8}};
  for (const auto& heat : s.heats) {
    double volume_m3 = 0.0;
    for (const std::size_t part : heat.density_over) volume_m3 += section.outlines[part].volume_m3;
    if (heat.density_over.empty()) {
      for (const auto& share : heat.shares) volume_m3 += share.weight * section.outlines[share.part].volume_m3;
    }
    EXPECT_NEAR(*heat.density_W_per_m3 * volume_m3, published_W.at(heat.name), 0.05) << heat.name;
  }
}

TEST(Heat, lies_on_the_exposed_faces_in_its_box_and_on_no_contact_there) {
  const Spindle spindle = parse_spindle(sample_with("on_face = [40, 40, 60, 80]", "on_face = [20, 40, 60, 80]"), "s");
  const HeatShare &between = spindle.heats[1].shares[0], &in_box = spindle.heats[1].shares[1];
  double box_m2 = 0.0, contact_m2 = 0.0;
  for (const BoundaryPiece& piece : build_section(spindle).pieces) {
    if (carries(spindle, piece, in_box)) box_m2 += area_of(piece.start, piece.end);
    if (carries(spindle, piece, between)) contact_m2 += area_of(piece.start, piece.end);
    EXPECT_FALSE(carries(spindle, piece, spindle.heats[0].shares[0])) << "a share in a volume lies on no face";
  }
  // In the box are the outside, from z = 60 to 80 mm, the side of the groove, and the contact, which is not exposed.
  EXPECT_NEAR(box_m2, 2.0 * pi * 0.040 * 0.020 + pi * (0.040 * 0.040 - 0.038 * 0.038), 1e-12);
  EXPECT_NEAR(contact_m2, 2.0 * pi * 0.020 * 0.100, 1e-12);
}

}  // namespace mesh_section_test
}  // namespace spindle_twin::fem_offline
