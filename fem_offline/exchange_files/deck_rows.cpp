#include "fem_offline/exchange_files/deck_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace spindle_twin::fem_offline {
namespace {

/// Serendipity functions of the eight-node square at (x, y) in [-1, 1]², corners counter-clockwise from (-1, -1).
std::array<double, 8> eight_functions(double x, double y) {
  constexpr std::array<double, 4> corner_x{-1.0, 1.0, 1.0, -1.0}, corner_y{-1.0, -1.0, 1.0, 1.0};
  std::array<double, 8> n{};
  for (std::size_t k = 0; k < 4; ++k) {
    const double u = x * corner_x[k], v = y * corner_y[k];
    n[k] = 0.25 * (1.0 + u) * (1.0 + v) * (u + v - 1.0);
  }
  n[4] = 0.5 * (1.0 - x * x) * (1.0 - y);
  n[5] = 0.5 * (1.0 + x) * (1.0 - y * y);
  n[6] = 0.5 * (1.0 - x * x) * (1.0 + y);
  n[7] = 0.5 * (1.0 - x) * (1.0 - y * y);
  return n;
}

/// Where the point lies in the straight-sided quadrilateral, Newton on the bilinear map.
std::pair<double, double> place_in(const DeckModel& deck, const std::array<std::size_t, 8>& element, const Point& at) {
  const Point& a = deck.nodes[element[0]];
  const Point& b = deck.nodes[element[1]];
  const Point& c = deck.nodes[element[2]];
  const Point& d = deck.nodes[element[3]];
  double x = 0.0, y = 0.0;
  for (int turn = 0; turn < 20; ++turn) {
    const double na = 0.25 * (1 - x) * (1 - y), nb = 0.25 * (1 + x) * (1 - y);
    const double nc = 0.25 * (1 + x) * (1 + y), nd = 0.25 * (1 - x) * (1 + y);
    const double off_r = na * a.r_m + nb * b.r_m + nc * c.r_m + nd * d.r_m - at.r_m;
    const double off_z = na * a.z_m + nb * b.z_m + nc * c.z_m + nd * d.z_m - at.z_m;
    const double rx = 0.25 * ((1 - y) * (b.r_m - a.r_m) + (1 + y) * (c.r_m - d.r_m));
    const double ry = 0.25 * ((1 - x) * (d.r_m - a.r_m) + (1 + x) * (c.r_m - b.r_m));
    const double zx = 0.25 * ((1 - y) * (b.z_m - a.z_m) + (1 + y) * (c.z_m - d.z_m));
    const double zy = 0.25 * ((1 - x) * (d.z_m - a.z_m) + (1 + x) * (c.z_m - b.z_m));
    const double determinant = rx * zy - ry * zx;
    x -= (off_r * zy - off_z * ry) / determinant;
    y -= (off_z * rx - off_r * zx) / determinant;
  }
  return {x, y};
}

}  // namespace

DeckRow row_at(const DeckModel& deck, std::size_t part, const Point& at) {
  double least_excess = std::numeric_limits<double>::max();
  DeckRow row;
  for (std::size_t e = 0; e < deck.elements.size(); ++e) {
    if (deck.part_of_element[e] != part) continue;
    const auto [x, y] = place_in(deck, deck.elements[e], at);
    const double excess = std::max(std::abs(x), std::abs(y)) - 1.0;
    if (!(excess < least_excess)) continue;
    least_excess = excess;
    row.clear();
    const std::array<double, 8> n = eight_functions(std::clamp(x, -1.0, 1.0), std::clamp(y, -1.0, 1.0));
    for (std::size_t k = 0; k < 8; ++k) {
      if (std::abs(n[k]) > 1e-12) row.emplace_back(deck.elements[e][k], n[k]);
    }
  }
  return row;
}

/// Mean over the face with weight r: on a side of three nodes Simpson's rule integrates r times a parabola exactly.
DeckRow mean_over(const DeckModel& deck, const DeformationOutput& output) {
  std::map<std::size_t, double> weights;
  double total = 0.0;
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    if (deck.section.pieces[p].part != output.part || !lies_in(deck.section.pieces[p], output.face)) continue;
    for (const DeckSide& side : deck.sides_of_piece[p]) {
      const auto [a, b, middle] = nodes_of(deck, side);
      const double length_m = std::hypot(deck.nodes[b].r_m - deck.nodes[a].r_m, deck.nodes[b].z_m - deck.nodes[a].z_m);
      const std::array<std::pair<std::size_t, double>, 3> parts{
          {{a, length_m / 6.0}, {b, length_m / 6.0}, {middle, 4.0 * length_m / 6.0}}};
      for (const auto& [node, weight_m] : parts) {
        weights[node] += weight_m * deck.nodes[node].r_m;
        total += weight_m * deck.nodes[node].r_m;
      }
    }
  }
  DeckRow row;
  for (const auto& [node, weight] : weights) row.emplace_back(node, output.sign * weight / total);
  return row;
}

}  // namespace spindle_twin::fem_offline
