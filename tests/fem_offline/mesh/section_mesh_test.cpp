#include "fem_offline/mesh/section_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "tests/verification/concentric_rings.hpp"

namespace spindle_twin::fem_offline {
namespace mesh_section_mesh_test {

/// A plug with a 10 degree cone, a triangle fan and a hole, in a sleeve that follows it: nothing runs along r or z
/// only.
Spindle cone_in_sleeve() {
  Spindle spindle = concentric_rings({0.0, 0.02, 0.04}, 5000.0, 200.0, 300.15);
  spindle.parts[0].shapes = {{{0.0, 0.0}, {0.02, 0.0}, {0.025, 0.03}, {0.0, 0.03}}};
  spindle.parts[0].cuts = {{{0.008, 0.010}, {0.013, 0.012}, {0.010, 0.020}}};
  spindle.parts[1].shapes = {{{0.02, 0.0}, {0.04, 0.0}, {0.04, 0.03}, {0.025, 0.03}}};
  spindle.adiabatics[0].regions.push_back({0.008, 0.013, 0.010, 0.020});
  spindle.mesh.element_size_m = 0.003;
  return spindle;
}

double volume_m3(const SectionMesh& mesh, std::size_t part) {
  double sum_m3 = 0.0;
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    if (mesh.part_of_quad[q] != part) continue;
    for (std::size_t k = 0; k < 4; ++k) {
      const Point& a = mesh.points[mesh.quads[q][k]];
      const Point& b = mesh.points[mesh.quads[q][(k + 1) % 4]];
      sum_m3 += std::numbers::pi / 3.0 * (a.r_m * a.r_m + a.r_m * b.r_m + b.r_m * b.r_m) * (b.z_m - a.z_m);
    }
  }
  return sum_m3;
}

bool has_point(const SectionMesh& mesh, const Point& wanted) {
  return std::any_of(mesh.points.begin(), mesh.points.end(), [&](const Point& point) {
    return std::hypot(point.r_m - wanted.r_m, point.z_m - wanted.z_m) < 1e-9;
  });
}

void expect_sound(const Spindle& spindle) {
  const Section section = build_section(spindle);
  const SectionMesh mesh = mesh_section(spindle, section);
  std::vector<std::set<std::size_t>> points(spindle.parts.size());
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    points[mesh.part_of_quad[q]].insert(mesh.quads[q].begin(), mesh.quads[q].end());
  }
  std::size_t total = 0;
  for (const auto& of_part : points) total += of_part.size();
  EXPECT_EQ(total, mesh.points.size()) << "parts share points";
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    EXPECT_NEAR(volume_m3(mesh, part), section.outlines[part].volume_m3, 1e-9 * section.outlines[part].volume_m3);
  }
  for (const BoundaryPiece& piece : section.pieces) {
    EXPECT_TRUE(has_point(mesh, piece.start));
    EXPECT_TRUE(has_point(mesh, piece.end));
  }
}

TEST(SectionMesh, grid_fills_the_parts_and_shares_no_point) { expect_sound(shaft_in_sleeve()); }

TEST(SectionMesh, gmsh_fills_slanted_parts_and_shares_no_point) { expect_sound(cone_in_sleeve()); }

TEST(SectionMesh, slanted_neighbours_match_where_they_touch) {
  const Spindle spindle = cone_in_sleeve();
  const SectionMesh mesh = mesh_section(spindle, build_section(spindle));
  std::vector<std::vector<double>> heights_m(2);
  for (std::size_t part = 0; part < 2; ++part) {
    std::set<std::size_t> points;
    for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
      if (mesh.part_of_quad[q] == part) points.insert(mesh.quads[q].begin(), mesh.quads[q].end());
    }
    for (const std::size_t p : points) {
      const Point& point = mesh.points[p];
      if (std::abs(point.r_m - 0.02 - point.z_m / 6.0) < 1e-9) heights_m[part].push_back(point.z_m);
    }
    std::sort(heights_m[part].begin(), heights_m[part].end());
  }
  ASSERT_GT(heights_m[0].size(), 8U);
  ASSERT_EQ(heights_m[0].size(), heights_m[1].size());
  for (std::size_t i = 0; i < heights_m[0].size(); ++i) EXPECT_NEAR(heights_m[0][i], heights_m[1][i], 1e-10);
}

TEST(SectionMesh, elements_are_no_larger_than_asked) {
  const Spindle spindle = shaft_in_sleeve();
  const SectionMesh mesh = mesh_section(spindle, build_section(spindle));
  for (const auto& quad : mesh.quads) {
    for (std::size_t k = 0; k < 4; ++k) {
      const Point& a = mesh.points[quad[k]];
      const Point& b = mesh.points[quad[(k + 1) % 4]];
      EXPECT_LT(std::hypot(b.r_m - a.r_m, b.z_m - a.z_m), spindle.mesh.element_size_m * (1.0 + 1e-5));
    }
  }
}

/// A needle of half a degree cannot be filled with sound elements.
TEST(SectionMesh, sliver_is_an_error_that_names_the_part) {
  Spindle spindle = shaft_in_sleeve();
  spindle.parts.resize(1);
  spindle.contacts.clear();
  spindle.heats.clear();
  spindle.parts[0].name = "needle";
  spindle.parts[0].shapes = {{{0.010, 0.0}, {0.0102, 0.0}, {0.010, 0.03}}};
  spindle.films[0].regions = {{0.0, 0.05, -0.01, 0.04}};
  spindle.adiabatics.clear();
  const Section section = build_section(spindle);
  try {
    mesh_section(spindle, section);
    FAIL() << "accepted";
  } catch (const rom::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("needle: inverted or sliver element near"), std::string::npos)
        << error.what();
  }
}

}  // namespace mesh_section_mesh_test
}  // namespace spindle_twin::fem_offline
