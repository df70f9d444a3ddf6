#include "fem_offline/mesh/tensor_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>

#include "fem_offline/mesh/element_sizes.hpp"

namespace spindle_twin::fem_offline {
namespace {

template <typename Visit>
void for_each_ring(const PartOutline& outline, Visit visit) {
  for (const OutlineFace& face : outline.faces) {
    visit(face.outer);
    for (const Polygon& hole : face.holes) visit(hole);
  }
}

std::vector<double> without_doubles(std::vector<double> lines) {
  std::sort(lines.begin(), lines.end());
  lines.erase(std::unique(lines.begin(), lines.end(), [](double a, double b) { return b - a < same_place_m; }),
              lines.end());
  return lines;
}

/// What the division of one direction hangs on, per stretch between two coarse lines and per coarse line.
struct Wanted {
  std::vector<double> size_m;    // of a stretch
  std::vector<bool> is_contact;  // of a line
};

/// Size of a stretch that no part of the grid covers: no cell lies in it.
constexpr double of_no_part_m = std::numeric_limits<double>::max();

/// Size at a distance from the nearer contact at the ends of the stretch.
double graded_m(double at, double length_m, double size_m, double contact_m, bool from_start, bool from_end) {
  double graded = size_m;
  if (from_start) graded = std::min(graded, contact_m + size_growth * at);
  if (from_end) graded = std::min(graded, contact_m + size_growth * (length_m - at));
  return graded;
}

/// Divides so that every cell takes the same share of the integral of 1 / size.
std::vector<double> graded_stretch(double start_m, double length_m, double size_m, double contact_m, bool from_start,
                                   bool from_end) {
  constexpr int samples = 4000;
  std::vector<double> sum = {0.0};
  for (int i = 0; i < samples; ++i) {
    const double at_m = length_m * (i + 0.5) / samples;
    sum.push_back(sum.back() + length_m / samples / graded_m(at_m, length_m, size_m, contact_m, from_start, from_end));
  }
  const int cells = std::max(1, static_cast<int>(std::ceil(sum.back() - 1e-6)));
  std::vector<double> fine = {start_m};
  for (int k = 1, i = 0; k < cells; ++k) {
    const double target = sum.back() * k / cells;
    while (sum[i + 1] < target) ++i;
    fine.push_back(start_m + length_m / samples * (i + (target - sum[i]) / (sum[i + 1] - sum[i])));
  }
  fine.push_back(start_m + length_m);
  return fine;
}

std::vector<double> even_stretch(double start_m, double length_m, double size_m) {
  const int cells = std::max(1, static_cast<int>(std::ceil(length_m / size_m - 1e-6)));
  std::vector<double> fine;
  fine.reserve(static_cast<std::size_t>(cells) + 1);
  for (int k = 0; k < cells; ++k) fine.push_back(start_m + length_m * k / cells);
  fine.push_back(start_m + length_m);
  return fine;
}

/// Before any line is made: how many cells the division of one direction comes to, at most.
double count_of(const std::vector<double>& lines, const Wanted& wanted, std::optional<double> contact_m) {
  double cells = 0.0;
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    cells += std::ceil((lines[i + 1] - lines[i]) / wanted.size_m[i]);
    const bool graded =
        contact_m && wanted.size_m[i] < of_no_part_m && (wanted.is_contact[i] || wanted.is_contact[i + 1]);
    if (graded) cells += 2.0 * std::log(1.0 + wanted.size_m[i] / *contact_m) / size_growth + 1.0;
  }
  return cells;
}

GridLines divided(std::vector<double> lines, const Wanted& wanted, std::optional<double> contact_m) {
  GridLines result{std::move(lines), {}};
  for (std::size_t i = 0; i + 1 < result.coarse_m.size(); ++i) {
    const double start_m = result.coarse_m[i], length_m = result.coarse_m[i + 1] - start_m;
    const bool graded = contact_m && *contact_m < wanted.size_m[i] && wanted.size_m[i] < of_no_part_m &&
                        (wanted.is_contact[i] || wanted.is_contact[i + 1]);
    result.fine_m.push_back(graded ? graded_stretch(start_m, length_m, wanted.size_m[i], *contact_m,
                                                    wanted.is_contact[i], wanted.is_contact[i + 1])
                                   : even_stretch(start_m, length_m, wanted.size_m[i]));
    result.fine_m.back().back() = result.coarse_m[i + 1];
  }
  return result;
}

/// Even-odd rule over all rings; `at` is a cell's centre and so never on a ring.
bool is_inside(const PartOutline& outline, const Point& at) {
  bool inside = false;
  for_each_ring(outline, [&](const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& a = ring[i];
      const Point& b = ring[(i + 1) % ring.size()];
      if ((a.z_m > at.z_m) == (b.z_m > at.z_m)) continue;
      if (at.r_m < a.r_m + (b.r_m - a.r_m) * (at.z_m - a.z_m) / (b.z_m - a.z_m)) inside = !inside;
    }
  });
  return inside;
}

/// inside[j][i]: whether the coarse cell between lines i, i + 1 of r and j, j + 1 of z belongs to the part.
using CoarseCells = std::vector<std::vector<bool>>;

CoarseCells coarse_cells(const std::vector<double>& r_m, const std::vector<double>& z_m, const PartOutline& outline) {
  CoarseCells inside(z_m.size() - 1, std::vector<bool>(r_m.size() - 1));
  for (std::size_t j = 0; j + 1 < z_m.size(); ++j) {
    for (std::size_t i = 0; i + 1 < r_m.size(); ++i) {
      inside[j][i] = is_inside(outline, {0.5 * (r_m[i] + r_m[i + 1]), 0.5 * (z_m[j] + z_m[j + 1])});
    }
  }
  return inside;
}

/// Lowers the sizes of the stretches that a part covers in one direction: its element size, and its thickness over
/// `cells_across` for every run of its cells. `covers(across, along)` tells whether a coarse cell belongs to it.
template <typename Covers>
void lower_sizes(const std::vector<double>& lines, std::size_t across_count, double size_m, int cells_across,
                 Covers covers, std::vector<double>& sizes_m) {
  for (std::size_t across = 0; across < across_count; ++across) {
    for (std::size_t i = 0; i + 1 < lines.size();) {
      if (!covers(across, i)) {
        ++i;
        continue;
      }
      std::size_t end = i;
      while (end + 1 < lines.size() && covers(across, end)) ++end;
      const double least_m = std::min(size_m, (lines[end] - lines[i]) / cells_across);
      for (; i < end; ++i) sizes_m[i] = std::min(sizes_m[i], least_m);
    }
  }
}

/// Which lines run along a contact of a part of the grid.
std::vector<bool> contact_lines(const std::vector<double>& lines, const Section& section,
                                const std::vector<bool>& aligned, double Point::*coordinate) {
  std::vector<bool> is_contact(lines.size(), false);
  for (const BoundaryPiece& piece : section.pieces) {
    if (!aligned[piece.part] || piece.kind != PieceKind::contact) continue;
    if (std::abs(piece.start.*coordinate - piece.end.*coordinate) > same_place_m) continue;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      if (std::abs(lines[i] - piece.start.*coordinate) <= same_place_m) is_contact[i] = true;
    }
  }
  return is_contact;
}

}  // namespace

bool is_axis_aligned(const PartOutline& outline) {
  bool aligned = true;
  for_each_ring(outline, [&](const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point& a = ring[i];
      const Point& b = ring[(i + 1) % ring.size()];
      const bool along_r = std::abs(a.z_m - b.z_m) < same_place_m;
      const bool along_z = std::abs(a.r_m - b.r_m) < same_place_m;
      aligned = aligned && (along_r || along_z);
    }
  });
  return aligned;
}

TensorGrid make_tensor_grid(const Spindle& spindle, const Section& section, double element_limit) {
  std::vector<double> r_m, z_m;
  const auto add = [&](const Point& point) {
    r_m.push_back(point.r_m);
    z_m.push_back(point.z_m);
  };
  std::vector<bool> aligned;
  for (const PartOutline& outline : section.outlines) {
    aligned.push_back(is_axis_aligned(outline));
    if (!aligned.back()) continue;
    for_each_ring(outline, [&](const Polygon& ring) { std::for_each(ring.begin(), ring.end(), add); });
  }
  if (r_m.empty()) return {};
  for (const BoundaryPiece& piece : section.pieces) {
    if (!aligned[piece.part]) continue;
    add(piece.start);
    add(piece.end);
  }
  const auto [r_least, r_most] = std::minmax_element(r_m.begin(), r_m.end());
  const auto [z_least, z_most] = std::minmax_element(z_m.begin(), z_m.end());
  const Box extent{*r_least, *r_most, *z_least, *z_most};
  const auto add_box = [&](const Box& box) {
    for (const double r : {box.r0_m, box.r1_m}) {
      if (r > extent.r0_m && r < extent.r1_m) r_m.push_back(r);
    }
    for (const double z : {box.z0_m, box.z1_m}) {
      if (z > extent.z0_m && z < extent.z1_m) z_m.push_back(z);
    }
  };
  for (const Support& support : spindle.supports) add_box(support.face);
  for (const DeformationOutput& output : spindle.deformations) {
    if (!output.at) add_box(output.face);
  }
  r_m = without_doubles(r_m);
  z_m = without_doubles(z_m);
  Wanted along_r{std::vector<double>(r_m.size() - 1, of_no_part_m), contact_lines(r_m, section, aligned, &Point::r_m)};
  Wanted along_z{std::vector<double>(z_m.size() - 1, of_no_part_m), contact_lines(z_m, section, aligned, &Point::z_m)};
  for (std::size_t part = 0; part < section.outlines.size(); ++part) {
    if (!aligned[part]) continue;
    const CoarseCells inside = coarse_cells(r_m, z_m, section.outlines[part]);
    const double size_m = size_of(spindle, part);
    const int across = spindle.mesh.cells_across;
    lower_sizes(
        r_m, z_m.size() - 1, size_m, across, [&](auto j, auto i) { return inside[j][i]; }, along_r.size_m);
    lower_sizes(
        z_m, r_m.size() - 1, size_m, across, [&](auto i, auto j) { return inside[j][i]; }, along_z.size_m);
  }
  const auto contact_m = spindle.mesh.contact_size_m;
  const double cells = count_of(r_m, along_r, contact_m) * count_of(z_m, along_z, contact_m);
  if (cells > element_limit) {
    std::ostringstream message;
    message << "the element sizes would cut the section into " << cells << " cells, at most " << element_limit
            << " are allowed: raise element_size_mm";
    throw rom::InputError({spindle.file, spindle.parts[0].where.line}, "mesh", message.str());
  }
  return {divided(std::move(r_m), along_r, contact_m), divided(std::move(z_m), along_z, contact_m)};
}

void add_grid_cells(const TensorGrid& grid, const PartOutline& outline, std::size_t part, SectionMesh& mesh) {
  const CoarseCells inside = coarse_cells(grid.r.coarse_m, grid.z.coarse_m, outline);
  // Number of the first fine line of every stretch.
  const auto first_lines = [](const GridLines& lines) {
    std::vector<std::size_t> first = {0};
    for (const auto& fine : lines.fine_m) first.push_back(first.back() + fine.size() - 1);
    return first;
  };
  const auto first_r = first_lines(grid.r), first_z = first_lines(grid.z);
  constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> known((first_r.back() + 1) * (first_z.back() + 1), none);
  for (std::size_t j = 0; j < grid.z.fine_m.size(); ++j) {
    for (std::size_t i = 0; i < grid.r.fine_m.size(); ++i) {
      if (!inside[j][i]) continue;
      const auto &r_m = grid.r.fine_m[i], &z_m = grid.z.fine_m[j];
      const auto point = [&](std::size_t k, std::size_t l) {
        std::size_t& at = known[(first_z[j] + l) * (first_r.back() + 1) + first_r[i] + k];
        if (at == none) {
          at = mesh.points.size();
          mesh.points.push_back({r_m[k], z_m[l]});
        }
        return at;
      };
      for (std::size_t l = 0; l + 1 < z_m.size(); ++l) {
        for (std::size_t k = 0; k + 1 < r_m.size(); ++k) {
          mesh.quads.push_back({point(k, l), point(k + 1, l), point(k + 1, l + 1), point(k, l + 1)});
          mesh.part_of_quad.push_back(part);
        }
      }
    }
  }
}

}  // namespace spindle_twin::fem_offline
