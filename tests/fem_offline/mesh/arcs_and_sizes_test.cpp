#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "fem_offline/mesh/mesh_quality.hpp"
#include "fem_offline/mesh/section_mesh.hpp"
#include "tests/fem_offline/description/sample_spindle.hpp"

namespace spindle_twin::fem_offline {
namespace mesh_arcs_and_sizes_test {

using std::numbers::pi;

/// A disc of radius 10 mm in a ring up to 15 mm, given by centres and by points they run through; `geometry` planar or
/// axisymmetric.
std::string disc_in_ring(const std::string& geometry) {
  std::ostringstream text;
  text << std::ifstream(SPINDLE_TWIN_SOURCE_DIR "/tests/fuzz/corpus/good_planar_arcs.toml").rdbuf();
  std::string all = text.str();
  const std::string planar = "\"planar\"";
  return all.replace(all.find(planar), planar.size(), "\"" + geometry + "\"");
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

SectionMesh meshed(const Spindle& spindle) { return mesh_section(spindle, build_section(spindle)); }

double length_m(const BoundaryPiece& piece) {
  return std::hypot(piece.end.r_m - piece.start.r_m, piece.end.z_m - piece.start.z_m);
}

/// Chords take away at most the sagitta all around.
TEST(Arcs, a_disc_of_chords_loses_less_than_its_sagitta) {
  const Spindle spindle = parse_spindle(disc_in_ring("planar"), "s.toml");
  const double area_m2 = build_section(spindle).outlines[0].volume_m3, radius_m = 0.01;
  EXPECT_LT(area_m2, pi * radius_m * radius_m);
  EXPECT_GT(area_m2, pi * radius_m * radius_m - 2.0 * pi * radius_m * spindle.mesh.arc_sagitta_m);
}

/// The mesh gives back what the chords take: area of the parabolas through ends and middles of the arcs, 2/3 of chord
/// times sagitta each, against that of the disc.
TEST(Arcs, bent_sides_enclose_the_disc) {
  const SectionMesh mesh = meshed(parse_spindle(disc_in_ring("planar"), "s.toml"));
  const double radius_m = 0.01;
  double area_m2 = 0.0;
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    if (mesh.part_of_quad[q] != 0) continue;
    Polygon quad;
    for (const std::size_t corner : mesh.quads[q]) quad.push_back(mesh.points[corner]);
    area_m2 += volume_within(quad, Geometry::planar);
  }
  std::size_t of_disc = 0;
  for (const BentSide& side : mesh.bent_sides) {
    const Point &a = mesh.points[side.a], &b = mesh.points[side.b];
    const double chord_m = std::hypot(b.r_m - a.r_m, b.z_m - a.z_m);
    const double distance_m = std::hypot(a.r_m - side.centre.r_m, a.z_m - side.centre.z_m);
    EXPECT_NEAR(std::hypot(b.r_m - side.centre.r_m, b.z_m - side.centre.z_m), distance_m, 2e-9);
    if (mesh.part_of_quad[0] != 0 || std::abs(distance_m - radius_m) > 1e-6) continue;
    const double sagitta_m = radius_m - std::sqrt(radius_m * radius_m - 0.25 * chord_m * chord_m);
    // The ring's bore is bent with the disc, so every side comes twice.
    area_m2 += 0.5 * 2.0 / 3.0 * chord_m * sagitta_m;
    ++of_disc;
  }
  EXPECT_GT(of_disc, 8U);
  EXPECT_NEAR(area_m2, pi * radius_m * radius_m, 1e-6 * pi * radius_m * radius_m);
}

TEST(MeshSize, default_is_a_fortieth_of_the_root_of_the_area) {
  const std::string text = replaced(disc_in_ring("planar"), "\nelement_size_mm = 2", "");
  const double disc_and_ring_m2 = pi * 0.015 * 0.015;
  const Spindle spindle = parse_spindle(text, "s.toml"), halved = parse_spindle(text, "s.toml", 0.5);
  // The area is that of octagons at least.
  EXPECT_LE(spindle.mesh.element_size_m, std::sqrt(disc_and_ring_m2) / 40.0);
  EXPECT_GE(spindle.mesh.element_size_m, std::sqrt(0.9 * disc_and_ring_m2) / 40.0);
  EXPECT_DOUBLE_EQ(halved.mesh.element_size_m, 0.5 * spindle.mesh.element_size_m);
  EXPECT_DOUBLE_EQ(halved.mesh.arc_sagitta_m, 0.25 * spindle.mesh.arc_sagitta_m);
  EXPECT_GT(halved.parts[0].shapes[0].size(), spindle.parts[0].shapes[0].size() * 3 / 2);
}

TEST(Arcs, parts_that_share_an_arc_get_the_same_chords) {
  const Section section = build_section(parse_spindle(disc_in_ring("planar"), "s.toml"));
  std::array<double, 2> touching_m{};
  for (const BoundaryPiece& piece : section.pieces) {
    if (piece.kind == PieceKind::contact) touching_m[piece.part] += length_m(piece);
  }
  EXPECT_NEAR(touching_m[0], 2.0 * pi * 0.01, 2.0 * pi * 0.01 * 1e-2);
  EXPECT_NEAR(touching_m[1], touching_m[0], 1e-9);
}

TEST(Arcs, bad_ones_are_errors_with_their_line) {
  const std::string good = disc_in_ring("planar");
  const auto message = [&](const std::string& from, const std::string& to) {
    return message_of(replaced(good, from, to));
  };
  EXPECT_EQ(message_of(good), "no InputError");
  EXPECT_EQ(
      message("{ to = [12, 30], centre = [22, 30] }", "{ to = [12, 30], centre = [22.5, 30] }"),
      "s.toml:22: part.core.polygons[1].arcs[1].centre: must be as far from both ends of the arc, to 0.001 mm; it "
      "is 9.5 mm from the first and 10.5 mm from the second");
  EXPECT_EQ(message("{ to = [12, 30], centre = [22, 30] }", "{ to = [13, 30], centre = [22, 30] }"),
            "s.toml:22: part.core.polygons[1].arcs[1].to: must be one of the points, the one where the arc ends");
  EXPECT_EQ(message("{ to = [12, 30], centre = [22, 30] }", "{ to = [12, 30] }"),
            "s.toml:22: part.core.polygons[1].arcs[1].to: an arc needs either centre or through");
  EXPECT_EQ(
      message("through = [22, 45]", "through = [22, 30]"),
      "s.toml:27: part.ring.polygons[1].arcs[1].through: must be a point beside the straight line between the arc's "
      "two ends");
  EXPECT_EQ(message("points = [[12, 30], [32, 30]], arcs = [{ to = [12, 30], centre",
                    "points = [[12, 30], [12, 30]], arcs = [{ to = [12, 30], centre"),
            "s.toml:22: part.core.polygons[1].arcs[1].to: the arc begins and ends at the same point");
}

TEST(Planar, everything_counts_per_metre_of_depth_and_x_may_be_negative) {
  std::string text = replaced(sample_text, "name = \"sample\"", "name = \"sample\"\ngeometry = \"planar\"");
  text = replaced(text,
                  "interference_fit = { inner_radius_mm = 0, fit_radius_mm = 20, outer_radius_mm = 40, "
                  "interference_um = 6 }",
                  "");
  text = replaced(text, "[[0, 20, 0, 100]]", "[[-5, 20, 0, 100]]");
  text = replaced(text, "regions = [[0, 40, -1, 0], [0, 40, 100, 101]]",
                  "regions = [[-5, 40, -1, 0], [-5, 40, 100, 101], [-6, -5, 0, 100]]");
  const Spindle spindle = parse_spindle(text, "s.toml");
  const Section section = build_section(spindle);
  EXPECT_NEAR(section.outlines[0].volume_m3, 0.025 * 0.1, 1e-15);
  EXPECT_NEAR(section.outlines[1].volume_m3, 0.02 * 0.1 - 0.002 * 0.02, 1e-15);
  EXPECT_NO_THROW(mesh_section(spindle, section));
  // A planar body has no axis: a bare face at x = 0 is an error like any other.
  const std::string bare =
      replaced(replaced(text, "[[-5, 20, 0, 100]]", "[[0, 20, 0, 100]]"), ", [-6, -5, 0, 100]", "");
  EXPECT_NE(message_of(bare).find("has no film"), std::string::npos) << message_of(bare);
}

TEST(Sizes, cells_across_holds_for_every_part) {
  Spindle spindle = parse_spindle(sample_text, "s.toml");
  spindle.mesh.element_size_m = 1.0;
  spindle.mesh.cells_across = 4;
  const SectionMesh mesh = meshed(spindle);
  for (std::size_t part = 0; part < 2; ++part) {
    std::vector<double> r_m;
    for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
      // Clear of the groove, in whose rows the sleeve is thinner.
      if (mesh.part_of_quad[q] == part && mesh.points[mesh.quads[q][2]].z_m < 0.039) {
        r_m.push_back(mesh.points[mesh.quads[q][0]].r_m);
      }
    }
    std::sort(r_m.begin(), r_m.end());
    EXPECT_GE(std::unique(r_m.begin(), r_m.end()) - r_m.begin(), 4);
  }
}

TEST(Sizes, cells_grow_away_from_a_contact) {
  Spindle spindle = parse_spindle(sample_text, "s.toml");
  spindle.mesh.contact_size_m = 2e-4;
  const SectionMesh mesh = meshed(spindle);
  double at_contact_m = 1.0, at_axis_m = 0.0;
  for (const auto& quad : mesh.quads) {
    const double from_m = mesh.points[quad[0]].r_m, to_m = mesh.points[quad[2]].r_m;
    if (std::abs(to_m - 0.02) < 1e-9) at_contact_m = std::min(at_contact_m, to_m - from_m);
    if (from_m == 0.0) at_axis_m = std::max(at_axis_m, to_m - from_m);
  }
  EXPECT_LT(at_contact_m, 3e-4);
  EXPECT_GT(at_axis_m, 1.5e-3);
  EXPECT_LE(at_axis_m, spindle.mesh.element_size_m);
}

/// The pulley is meshed by gmsh, and beyond the cover no part of the grid is left beside it.
TEST(Sizes, a_contact_beside_a_stretch_without_cells_is_no_reason_to_refuse) {
  Spindle spindle = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/belt_driven.toml");
  const std::size_t without = meshed(spindle).quads.size();
  spindle.mesh.contact_size_m = 1e-3;
  EXPECT_GT(meshed(spindle).quads.size(), without);
}

TEST(Sizes, a_part_may_have_its_own) {
  Spindle spindle = parse_spindle(disc_in_ring("axisymmetric"), "s.toml");
  const auto coarse = mesh_quality(spindle, meshed(spindle));
  spindle.parts[1].element_size_m = 0.5e-3;
  const auto fine = mesh_quality(spindle, meshed(spindle));
  EXPECT_GT(fine[1].cells, 2 * coarse[1].cells);
}

TEST(Sizes, too_many_elements_are_refused_before_meshing) {
  EXPECT_NO_THROW(meshed(parse_spindle(sample_text, "s.toml")));
  try {
    meshed(parse_spindle(sample_with("element_size_mm = 3", "element_size_mm = 0.01"), "s.toml"));
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("s.toml:28: mesh: the element sizes would cut the section into"),
              std::string::npos)
        << error.what();
  }
  try {
    meshed(
        parse_spindle(replaced(disc_in_ring("planar"), "element_size_mm = 1.5", "element_size_mm = 0.01"), "s.toml"));
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find(": its element sizes would cut this part into"), std::string::npos)
        << error.what();
  }
}

TEST(Quality, rectangles_are_perfect_and_gmsh_is_sound) {
  const Spindle straight = parse_spindle(sample_text, "s.toml");
  for (const PartQuality& part : mesh_quality(straight, meshed(straight))) {
    EXPECT_NEAR(part.least_scaled_jacobian, 1.0, 1e-9);
    EXPECT_LE(part.longest_side_m, straight.mesh.element_size_m * (1.0 + 1e-6));
  }
  const Spindle round = parse_spindle(disc_in_ring("planar"), "s.toml");
  for (const PartQuality& part : mesh_quality(round, meshed(round))) {
    EXPECT_GT(part.least_scaled_jacobian, 0.2) << part.part;
    EXPECT_LT(part.mean_scaled_jacobian, 1.0);
    EXPECT_GT(part.mean_scaled_jacobian, 0.8) << part.part;
    EXPECT_LT(part.largest_aspect, 10.0) << part.part;
  }
}

/// A corner of no angle: the shape of the element says so.
TEST(Quality, scaled_jacobian_of_known_shapes) {
  SectionMesh mesh;
  mesh.points = {{0.0, 0.0}, {2.0, 0.0}, {2.0, 1.0}, {0.0, 1.0}, {1.0, 1.0}};
  EXPECT_DOUBLE_EQ(shape_of(mesh, {0, 1, 2, 3}).scaled_jacobian, 1.0);
  EXPECT_DOUBLE_EQ(shape_of(mesh, {0, 1, 2, 3}).aspect, 2.0);
  EXPECT_NEAR(shape_of(mesh, {0, 1, 2, 4}).scaled_jacobian, std::sqrt(0.5), 1e-12);
  EXPECT_LT(shape_of(mesh, {0, 3, 2, 1}).scaled_jacobian, 0.0);
}

}  // namespace mesh_arcs_and_sizes_test
}  // namespace spindle_twin::fem_offline
