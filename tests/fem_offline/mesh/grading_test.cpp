// Meshes that get fine towards corners, and those with every element cut in four.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "fem_offline/mesh/mesh_quality.hpp"
#include "fem_offline/mesh/refine_quads.hpp"
#include "fem_offline/mesh/section_mesh.hpp"
#include "fem_offline/mesh/sharp_places.hpp"

namespace spindle_twin::fem_offline {
namespace mesh_grading_test {

using Key = std::pair<long, long>;

Key key_of(const Point& at) { return {std::lround(at.r_m / same_place_m), std::lround(at.z_m / same_place_m)}; }
Key key_of_mm(double r_mm, double z_mm) { return key_of({1e-3 * r_mm, 1e-3 * z_mm}); }

Spindle shipped(const std::string& name) {
  return read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/" + name + ".toml");
}

SectionMesh meshed(const Spindle& spindle) { return mesh_section(spindle, build_section(spindle)); }

double area_m2(const SectionMesh& mesh) {
  double sum_m2 = 0.0;
  for (const auto& [a, b, c, d] : mesh.quads) {
    sum_m2 += volume_within({mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]}, Geometry::planar);
  }
  return sum_m2;
}

/// Length of all sides that belong to one element: the outlines, unless a point of one element lies on another's side.
double rim_m(const SectionMesh& mesh) {
  std::map<std::pair<std::size_t, std::size_t>, int> uses;
  for (const auto& quad : mesh.quads) {
    for (std::size_t k = 0; k < 4; ++k) ++uses[std::minmax(quad[k], quad[(k + 1) % 4])];
  }
  double sum_m = 0.0;
  for (const auto& [side, count] : uses) {
    const Point &a = mesh.points[side.first], &b = mesh.points[side.second];
    if (count == 1) sum_m += std::hypot(b.r_m - a.r_m, b.z_m - a.z_m);
  }
  return sum_m;
}

double longest_side_at_m(const SectionMesh& mesh, const Key& place) {
  double longest_m = 0.0;
  for (const auto& quad : mesh.quads) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (key_of(mesh.points[quad[k]]) != place) continue;
      for (const std::size_t other : {quad[(k + 1) % 4], quad[(k + 3) % 4]}) {
        const Point &a = mesh.points[quad[k]], &b = mesh.points[other];
        longest_m = std::max(longest_m, std::hypot(b.r_m - a.r_m, b.z_m - a.z_m));
      }
    }
  }
  return longest_m;
}

std::set<Key> sharp_keys(const Spindle& spindle) {
  const Section section = build_section(spindle);
  std::set<Key> keys;
  for (const Point& at : sharp_places(spindle, section, mesh_section(spindle, section))) keys.insert(key_of(at));
  return keys;
}

TEST(SharpPlaces, are_corners_into_the_material_and_ends_of_held_faces) {
  const std::set<Key> keys = sharp_keys(shipped("reference"));
  EXPECT_TRUE(keys.contains(key_of_mm(30, 28)));     // the shaft's shoulder, though the labyrinth fills it
  EXPECT_TRUE(keys.contains(key_of_mm(88, 212)));    // flange and housing
  EXPECT_TRUE(keys.contains(key_of_mm(35.5, 48)));   // balls on a ring
  EXPECT_TRUE(keys.contains(key_of_mm(88.1, 232)));  // where the flange's face begins to be held
  EXPECT_FALSE(keys.contains(key_of_mm(105, 232)));  // its other end is a right corner, held in its plane of symmetry
  EXPECT_FALSE(keys.contains(key_of_mm(14, 0)));
  EXPECT_FALSE(keys.contains(key_of_mm(36, 112)));  // shaft and spacer, flush
}

TEST(SharpPlaces, joints_of_an_arcs_chords_are_none) {
  const Spindle spindle = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/tests/fuzz/corpus/good_arcs.toml");
  Spindle coarse = spindle;
  coarse.mesh.corner_size_m.reset();
  for (const Key& key : sharp_keys(coarse)) {
    for (const PartOutline& outline : build_section(coarse).outlines) {
      int ends = 0;
      for (const ArcChord& arc : outline.arcs) ends += (key_of(arc.start) == key) + (key_of(arc.end) == key);
      EXPECT_LT(ends, 2);
    }
  }
}

TEST(Grading, makes_elements_small_at_every_sharp_place_and_keeps_outlines_and_neighbours) {
  for (const std::string name :
       {"reference", "four_bearing_milling", "belt_driven", "grinding_40k", "jacket_circuit"}) {
    Spindle spindle = shipped(name);
    spindle.mesh.corner_size_m.reset();
    const SectionMesh even = meshed(spindle);
    const std::set<Key> sharp = sharp_keys(spindle);
    for (const double size_m : {1e-3, 5e-5}) {
      spindle.mesh.corner_size_m = size_m;
      const SectionMesh graded = meshed(spindle);
      EXPECT_NEAR(area_m2(graded), area_m2(even), 1e-9 * area_m2(even)) << name;
      EXPECT_NEAR(rim_m(graded), rim_m(even), 1e-9 * rim_m(even)) << name;
      for (const Key& place : sharp) EXPECT_LE(longest_side_at_m(graded, place), size_m) << name;
      EXPECT_TRUE(std::is_sorted(graded.part_of_quad.begin(), graded.part_of_quad.end()));
    }
  }
}

/// Points of one part on a straight piece.
std::set<Key> points_on(const SectionMesh& mesh, const BoundaryPiece& piece) {
  std::set<Key> keys;
  const double r = piece.end.r_m - piece.start.r_m, z = piece.end.z_m - piece.start.z_m, length_m = std::hypot(r, z);
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    if (mesh.part_of_quad[q] != piece.part) continue;
    for (const std::size_t point : mesh.quads[q]) {
      const double dr = mesh.points[point].r_m - piece.start.r_m, dz = mesh.points[point].z_m - piece.start.z_m;
      const double along_m = (dr * r + dz * z) / length_m;
      if (std::abs(dr * z - dz * r) > same_place_m * length_m || along_m < -same_place_m) continue;
      if (along_m < length_m + same_place_m) keys.insert(key_of(mesh.points[point]));
    }
  }
  return keys;
}

TEST(Grading, keeps_both_sides_of_a_contact_matching) {
  Spindle spindle = shipped("reference");
  spindle.mesh.corner_size_m = 1e-4;
  const Section section = build_section(spindle);
  const SectionMesh mesh = mesh_section(spindle, section);
  int compared = 0;
  for (const BoundaryPiece& a : section.pieces) {
    for (const BoundaryPiece& b : section.pieces) {
      if (a.kind != PieceKind::contact || b.kind != PieceKind::contact || a.pair != b.pair || a.side >= b.side)
        continue;
      EXPECT_EQ(points_on(mesh, a), points_on(mesh, b)) << 1e3 * a.start.r_m << ' ' << 1e3 * a.start.z_m;
      ++compared;
    }
  }
  EXPECT_GT(compared, 30);
}

TEST(Grading, costs_few_elements) {
  Spindle spindle = shipped("reference");
  spindle.mesh.corner_size_m.reset();
  const std::size_t even = meshed(spindle).quads.size();
  spindle.mesh.corner_size_m = 5e-4;  // an eighth
  EXPECT_LT(meshed(spindle).quads.size(), 3 * even / 2);
}

TEST(Halving, cuts_every_element_in_four_and_moves_nothing) {
  Spindle spindle = shipped("four_bearing_milling");
  const SectionMesh whole = meshed(spindle);
  spindle.mesh.halvings = 1;
  const SectionMesh halved = meshed(spindle);
  EXPECT_EQ(halved.quads.size(), 4 * whole.quads.size());
  EXPECT_NEAR(area_m2(halved), area_m2(whole), 1e-12 * area_m2(whole));
  EXPECT_NEAR(rim_m(halved), rim_m(whole), 1e-12 * rim_m(whole));
  for (std::size_t i = 0; i < whole.points.size(); ++i) {
    EXPECT_EQ(halved.points[i].r_m, whole.points[i].r_m);
    EXPECT_EQ(halved.points[i].z_m, whole.points[i].z_m);
  }
}

/// Certificates cut elements twice; the grinding spindle's nose has a quadrilateral with two sides on its arc.
TEST(Halving, can_be_done_three_times_with_every_spindle) {
  for (const char* name : {"belt_driven", "four_bearing_milling", "grinding_40k", "jacket_circuit", "reference"}) {
    Spindle spindle = shipped(name);
    const std::size_t whole = meshed(spindle).quads.size();
    spindle.mesh.halvings = 3;
    EXPECT_EQ(meshed(spindle).quads.size(), 64 * whole) << name;
  }
}

TEST(Halving, puts_the_new_points_of_arcs_on_them) {
  Spindle spindle = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/verify_cases/orders/harmonic_arcs.toml", 8.0);
  const auto farthest_m = [](const SectionMesh& mesh) {
    double most_m = 0.0;
    for (const BentSide& side : mesh.bent_sides) {
      const auto radius_m = [&](std::size_t point) {
        return std::hypot(mesh.points[point].r_m - side.centre.r_m, mesh.points[point].z_m - side.centre.z_m);
      };
      most_m = std::max(most_m, std::abs(radius_m(side.a) - radius_m(side.b)));
    }
    return most_m;
  };
  const std::size_t bent = meshed(spindle).bent_sides.size();
  spindle.mesh.halvings = 2;
  const SectionMesh halved = meshed(spindle);
  EXPECT_EQ(halved.bent_sides.size(), 4 * bent);
  EXPECT_LT(farthest_m(halved), 2e-9);
}

}  // namespace mesh_grading_test
}  // namespace spindle_twin::fem_offline
