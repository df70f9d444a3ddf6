#include "fem_offline/mesh/gmsh_quads.hpp"

#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace spindle_twin::fem_offline {
namespace {

/// gmsh's C++ interface is one global state: opened and closed around each part.
class GmshSession {
 public:
  GmshSession() {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    // Algorithm 8 of gmsh 4.8.4 crashes. Frontal triangles, paired where possible and then split in 3 or 4, give
    // quadrilaterals only.
    gmsh::option::setNumber("Mesh.Algorithm", 6);
    gmsh::option::setNumber("Mesh.RecombinationAlgorithm", 1);
    gmsh::option::setNumber("Mesh.SubdivisionAlgorithm", 1);
    gmsh::model::add("part");
  }
  ~GmshSession() { gmsh::finalize(); }
  GmshSession(const GmshSession&) = delete;
  GmshSession& operator=(const GmshSession&) = delete;
};

/// The ring with the ends of the part's pieces put between its corners.
Polygon with_piece_ends(const Polygon& ring, const Section& section, std::size_t part) {
  Polygon result;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Point& a = ring[i];
    const Point& b = ring[(i + 1) % ring.size()];
    const double length_m = std::hypot(b.r_m - a.r_m, b.z_m - a.z_m);
    std::vector<std::pair<double, Point>> between;
    for (const BoundaryPiece& piece : section.pieces) {
      if (piece.part != part) continue;
      for (const Point& end : {piece.start, piece.end}) {
        const double along_m = ((end.r_m - a.r_m) * (b.r_m - a.r_m) + (end.z_m - a.z_m) * (b.z_m - a.z_m)) / length_m;
        const double aside_m = ((end.r_m - a.r_m) * (b.z_m - a.z_m) - (end.z_m - a.z_m) * (b.r_m - a.r_m)) / length_m;
        if (std::abs(aside_m) > same_place_m) continue;
        if (along_m > same_place_m && along_m < length_m - same_place_m) between.push_back({along_m, end});
      }
    }
    std::sort(between.begin(), between.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    result.push_back(a);
    double last_m = 0.0;
    for (const auto& [along_m, end] : between) {
      if (along_m - last_m > same_place_m) result.push_back(end);
      last_m = along_m;
    }
  }
  return result;
}

int add_loop(const Polygon& ring, double coarse_size_m) {
  std::vector<int> points, lines;
  for (const Point& point : ring)
    points.push_back(gmsh::model::geo::addPoint(point.r_m, point.z_m, 0.0, coarse_size_m));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t next = (i + 1) % points.size();
    lines.push_back(gmsh::model::geo::addLine(points[i], points[next]));
    const double length_m = std::hypot(ring[next].r_m - ring[i].r_m, ring[next].z_m - ring[i].z_m);
    const int divisions = std::max(1, static_cast<int>(std::ceil(length_m / coarse_size_m - 1e-6)));
    gmsh::model::geo::mesh::setTransfiniteCurve(lines.back(), divisions + 1);
  }
  return gmsh::model::geo::addCurveLoop(lines);
}

void copy_quads(std::size_t part, SectionMesh& mesh) {
  constexpr int quadrilateral = 3;
  std::vector<std::size_t> tags, element_tags, element_nodes;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  gmsh::model::mesh::getElementsByType(quadrilateral, element_tags, element_nodes);
  std::unordered_map<std::size_t, std::size_t> position_of_tag, known;
  for (std::size_t i = 0; i < tags.size(); ++i) position_of_tag[tags[i]] = i;
  const auto point = [&](std::size_t tag) {
    const auto [entry, is_new] = known.try_emplace(tag, mesh.points.size());
    const std::size_t at = position_of_tag.at(tag);
    if (is_new) mesh.points.push_back({coordinates[3 * at], coordinates[3 * at + 1]});
    return entry->second;
  };
  for (std::size_t e = 0; e < element_tags.size(); ++e) {
    std::array<std::size_t, 4> quad{};
    for (std::size_t k = 0; k < 4; ++k) quad[k] = point(element_nodes[4 * e + k]);
    double twice_area = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      const Point& a = mesh.points[quad[k]];
      const Point& b = mesh.points[quad[(k + 1) % 4]];
      twice_area += a.r_m * b.z_m - b.r_m * a.z_m;
    }
    if (twice_area < 0.0) std::swap(quad[1], quad[3]);
    mesh.quads.push_back(quad);
    mesh.part_of_quad.push_back(part);
  }
}

}  // namespace

void add_gmsh_quads(const Spindle& spindle, const Section& section, std::size_t part, SectionMesh& mesh) {
  const double coarse_size_m = 2.0 * spindle.mesh.element_size_m;  // halved by the subdivision
  try {
    const GmshSession session;
    for (const OutlineFace& face : section.outlines[part].faces) {
      std::vector<int> loops = {add_loop(with_piece_ends(face.outer, section, part), coarse_size_m)};
      for (const Polygon& hole : face.holes) {
        loops.push_back(add_loop(with_piece_ends(hole, section, part), coarse_size_m));
      }
      const int surface = gmsh::model::geo::addPlaneSurface(loops);
      gmsh::model::geo::mesh::setRecombine(2, surface);
    }
    gmsh::model::geo::synchronize();
    gmsh::model::mesh::generate(2);
    copy_quads(part, mesh);
  } catch (const std::exception& error) {
    throw rom::InputError(spindle.parts[part].where, spindle.parts[part].name,
                          std::string("gmsh could not mesh this part: ") + error.what());
  }
}

}  // namespace spindle_twin::fem_offline
