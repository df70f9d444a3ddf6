#include "fem_offline/exchange_files/freefem_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "fem_offline/exchange_files/deck_files.hpp"

namespace spindle_twin::fem_offline {
namespace {

struct Edge {
  std::size_t a, b, label;
};

/// Border labels are numbers of pieces plus 1, regions are numbers of parts plus 1.
void write_msh(const std::string& directory, const std::string& name, const DeckModel& deck,
               const std::vector<std::size_t>& elements, const std::vector<Edge>& edges,
               const std::vector<std::size_t>& leader) {
  std::map<std::size_t, std::size_t> number;
  std::vector<std::size_t> order;
  const auto numbered = [&](std::size_t node) {
    const auto [found, added] = number.emplace(leader[node], order.size() + 1);
    if (added) order.push_back(leader[node]);
    return found->second;
  };
  std::ostringstream triangles, borders;
  for (const std::size_t e : elements) {
    const auto& nodes = deck.elements[e];
    const std::size_t a = numbered(nodes[0]), b = numbered(nodes[1]), c = numbered(nodes[2]), d = numbered(nodes[3]);
    const std::size_t region = deck.part_of_element[e] + 1;
    triangles << a << " " << b << " " << c << " " << region << "\n"
              << a << " " << c << " " << d << " " << region << "\n";
  }
  for (const Edge& edge : edges) borders << numbered(edge.a) << " " << numbered(edge.b) << " " << edge.label << "\n";
  DeckFile file(directory, name);
  file << order.size() << " " << 2 * elements.size() << " " << edges.size() << "\n";
  for (const std::size_t node : order) file << deck.nodes[node].r_m << " " << deck.nodes[node].z_m << " 0\n";
  file << triangles.str() << borders.str();
  file.close();
}

std::vector<Edge> edges_of(const DeckModel& deck, std::size_t piece) {
  std::vector<Edge> edges;
  for (const DeckSide& side : deck.sides_of_piece[piece]) {
    const auto [a, b, middle] = nodes_of(deck, side);
    edges.push_back({a, b, piece + 1});
  }
  return edges;
}

/// FreeFEM reads no mesh with two nodes at one place: nodes on faces that do not match move this far into their part.
constexpr double apart_m = 1e-8;

DeckModel moved_apart(const DeckModel& deck, const std::vector<std::size_t>& leader) {
  std::map<std::size_t, Point> shift_m;
  for (const DeckPair& pair : deck.pairs) {
    if (pair.tie_N_per_m3 == 0.0) continue;
    for (const std::size_t piece : {pair.piece_a, pair.piece_b}) {
      const BoundaryPiece& line = deck.section.pieces[piece];
      const double r = line.end.r_m - line.start.r_m, z = line.end.z_m - line.start.z_m;
      const double scale = apart_m / std::hypot(r, z);
      for (const std::size_t on_piece : nodes_on(deck, piece)) {
        Point& shift = shift_m[leader[on_piece]];
        shift.r_m -= scale * z;
        shift.z_m += scale * r;
      }
    }
  }
  DeckModel moved = deck;
  for (const auto& [node, shift] : shift_m) {
    moved.nodes[node].r_m += shift.r_m;
    moved.nodes[node].z_m += shift.z_m;
  }
  return moved;
}

/// Where the sides of elements on either face end, and their middles, along the first one.
std::vector<double> common_places_m(const DeckModel& deck, const DeckPair& pair) {
  const BoundaryPiece& line = deck.section.pieces[pair.piece_a];
  const double r = line.end.r_m - line.start.r_m, z = line.end.z_m - line.start.z_m, length_m = std::hypot(r, z);
  std::vector<double> all_m;
  for (const std::size_t piece : {pair.piece_a, pair.piece_b}) {
    for (const DeckSide& side : deck.sides_of_piece[piece]) {
      const auto [a, b, middle] = nodes_of(deck, side);
      for (const std::size_t node : {a, b, middle}) {
        all_m.push_back(((deck.nodes[node].r_m - line.start.r_m) * r + (deck.nodes[node].z_m - line.start.z_m) * z) /
                        length_m);
      }
    }
  }
  std::sort(all_m.begin(), all_m.end());
  std::vector<double> places_m;
  for (const double at_m : all_m) {
    if (places_m.empty() || at_m - places_m.back() > same_place_m) places_m.push_back(at_m);
  }
  return places_m;
}

/// A strip of triangles per face, on the common refinement of both: its border 1 runs along the face, a hair inside the
/// part, so that a field is found there in no other part. Both strips have the same triangles in the same order.
void write_strips(const DeckModel& deck, std::size_t number, const std::string& directory) {
  constexpr double inside_m = 5.0 * apart_m;
  const DeckPair& pair = deck.pairs[number];
  const BoundaryPiece& line = deck.section.pieces[pair.piece_a];
  const std::vector<double> places_m = common_places_m(deck, pair);
  const double length_m = std::hypot(line.end.r_m - line.start.r_m, line.end.z_m - line.start.z_m);
  const Point along{(line.end.r_m - line.start.r_m) / length_m, (line.end.z_m - line.start.z_m) / length_m};
  const Point left{-along.z_m, along.r_m};  // into the part of the first face
  const Point across = offset_of(deck, pair);
  const double width_m = 0.1 * length_m / static_cast<double>(places_m.size());
  for (const bool first : {true, false}) {
    const double shift_m = first ? inside_m : -inside_m;
    const Point from{line.start.r_m + shift_m * left.r_m + (first ? 0.0 : across.r_m),
                     line.start.z_m + shift_m * left.z_m + (first ? 0.0 : across.z_m)};
    DeckFile file(directory, strip_name(number, first) + ".msh");
    const std::size_t count = places_m.size();
    file << 2 * count << " " << 2 * (count - 1) << " " << 2 * count << "\n";
    for (const double to_left_m : {0.0, width_m}) {
      for (const double at_m : places_m) {
        file << from.r_m + at_m * along.r_m + to_left_m * left.r_m << " "
             << from.z_m + at_m * along.z_m + to_left_m * left.z_m << " 0\n";
      }
    }
    for (std::size_t i = 1; i < count; ++i) {
      file << i << " " << i + 1 << " " << count + i + 1 << " 1\n"
           << i << " " << count + i + 1 << " " << count + i << " 1\n";
    }
    for (std::size_t i = 1; i < count; ++i) file << i << " " << i + 1 << " 1\n";
    for (std::size_t i = 1; i < count; ++i) file << count + i + 1 << " " << count + i << " 2\n";
    file << count << " " << 2 * count << " 2\n" << count + 1 << " 1 2\n";
    file.close();
  }
}

}  // namespace

std::string strip_name(std::size_t pair, bool first) {
  return std::string("strip_").append(std::to_string(pair)).append(first ? "a" : "b");
}

std::vector<std::size_t> pieces_in(const DeckModel& deck, std::size_t part, const Box& face) {
  std::vector<std::size_t> found;
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    if (deck.section.pieces[p].part == part && lies_in(deck.section.pieces[p], face)) found.push_back(p);
  }
  return found;
}

Point offset_of(const DeckModel& deck, const DeckPair& pair) {
  const BoundaryPiece& a = deck.section.pieces[pair.piece_a];
  const BoundaryPiece& b = deck.section.pieces[pair.piece_b];
  const double length_m = std::hypot(a.end.r_m - a.start.r_m, a.end.z_m - a.start.z_m);
  const double normal_r = (a.end.z_m - a.start.z_m) / length_m, normal_z = -(a.end.r_m - a.start.r_m) / length_m;
  const double distance_m = (b.start.r_m - a.start.r_m) * normal_r + (b.start.z_m - a.start.z_m) * normal_z;
  return {distance_m * normal_r, distance_m * normal_z};
}

namespace {

/// Pieces whose edges carry a number in the bonded mesh: all outer ones, ties, supports and faces of outputs.
std::set<std::size_t> pieces_of_growth(const Spindle& spindle, const DeckModel& deck) {
  std::set<std::size_t> wanted;
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    if (deck.section.pieces[p].kind != PieceKind::contact) wanted.insert(p);
  }
  for (const DeckPair& pair : deck.pairs) {
    if (pair.tie_N_per_m3 > 0.0) wanted.insert({pair.piece_a, pair.piece_b});
  }
  for (const Support& support : spindle.supports) {
    for (const std::size_t p : pieces_in(deck, support.part, support.face)) wanted.insert(p);
  }
  for (const DeformationOutput& output : spindle.deformations) {
    for (const std::size_t p : pieces_in(deck, output.part, output.face)) wanted.insert(p);
  }
  return wanted;
}

}  // namespace

void write_freefem_meshes(const Spindle& spindle, const DeckModel& deck, const std::string& directory) {
  for (std::size_t p = 0; p < deck.pairs.size(); ++p) {
    if (!deck.pairs[p].matching) write_strips(deck, p, directory);
  }
  std::vector<std::size_t> itself(deck.nodes.size());
  for (std::size_t i = 0; i < itself.size(); ++i) itself[i] = i;
  std::vector<std::size_t> all;
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    std::vector<std::size_t> elements;
    for (std::size_t e = 0; e < deck.elements.size(); ++e) {
      if (deck.part_of_element[e] == part) elements.push_back(e);
    }
    all.insert(all.end(), elements.begin(), elements.end());
    std::vector<Edge> edges;
    for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
      if (deck.section.pieces[p].part != part) continue;
      for (const Edge& edge : edges_of(deck, p)) edges.push_back(edge);
    }
    write_msh(directory, "part_" + std::to_string(part) + ".msh", deck, elements, edges, itself);
  }
  if (deck.deformations.empty()) return;
  std::vector<Edge> edges;
  for (const std::size_t p : pieces_of_growth(spindle, deck)) {
    for (const Edge& edge : edges_of(deck, p)) edges.push_back(edge);
  }
  const std::vector<std::size_t> leader = bonded_leaders(deck);
  write_msh(directory, "bonded.msh", moved_apart(deck, leader), all, edges, leader);
}

}  // namespace spindle_twin::fem_offline
