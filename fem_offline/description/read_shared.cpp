#include "fem_offline/description/read_tables.hpp"

#include <cmath>
#include <sstream>

namespace spindle_twin::fem_offline {

using rom::any_number;
using rom::not_negative;

Box box_from(const TomlTable& table, const std::string& key, const std::vector<double>& row_mm, bool may_be_flat) {
  const Box box{row_mm[0] * metre_per_mm, row_mm[1] * metre_per_mm, row_mm[2] * metre_per_mm, row_mm[3] * metre_per_mm};
  const bool ordered =
      may_be_flat ? box.r0_m <= box.r1_m && box.z0_m <= box.z1_m && (box.r0_m < box.r1_m || box.z0_m < box.z1_m)
                  : box.r0_m < box.r1_m && box.z0_m < box.z1_m;
  if (!ordered) {
    std::ostringstream text;
    text << "[" << row_mm[0] << ", " << row_mm[1] << ", " << row_mm[2] << ", " << row_mm[3]
         << "] must be [r0, r1, z0, z1] with "
         << (may_be_flat ? "r0 <= r1, z0 <= z1 and not a single point" : "r0 < r1 and z0 < z1");
    table.fail(key, text.str());
  }
  return box;
}

namespace {

std::vector<Box> read_boxes(const TomlTable& table, const std::string& key) {
  std::vector<Box> boxes;
  for (const auto& row : table.rows_or_empty(key, 4, any_number)) boxes.push_back(box_from(table, key, row, false));
  return boxes;
}

}  // namespace

std::vector<Box> read_regions(const TomlTable& table) {
  auto boxes = read_boxes(table, "regions");
  if (boxes.empty()) table.fail("regions", "must hold at least one [r0, r1, z0, z1]");
  return boxes;
}

Box read_face(const TomlTable& table, const std::string& key) {
  return box_from(table, key, table.numbers(key, 4, any_number), true);
}

std::vector<Polygon> read_shapes(const TomlTable& table, const std::string& rectangles, const std::string& polygons,
                                 Geometry geometry, const MeshSettings& mesh, std::vector<ArcChord>& arcs) {
  std::vector<Polygon> shapes;
  for (const auto& row : table.rows_or_empty(rectangles, 4, coordinate_mm(geometry))) {
    const Box box = box_from(table, rectangles, row, false);
    shapes.push_back({{box.r0_m, box.z0_m}, {box.r1_m, box.z0_m}, {box.r1_m, box.z1_m}, {box.r0_m, box.z1_m}});
  }
  for (const auto& polygon : table.tables_or_empty(polygons)) {
    shapes.push_back(read_polygon(polygon, geometry, mesh, arcs));
  }
  return shapes;
}

}  // namespace spindle_twin::fem_offline
