#include "fem_offline/exchange_files/deck_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "fem_offline/description/model_places.hpp"

namespace spindle_twin::fem_offline {
namespace {

void refuse_what_decks_cannot_carry(const Spindle& spindle) {
  const rom::SourceLine file{spindle.file, 0};
  if (spindle.geometry != Geometry::axisymmetric) {
    throw rom::InputError(file, "geometry", "only an axisymmetric description can be exported");
  }
  if (spindle.mesh.degree != 2) {
    throw rom::InputError(file, "mesh.degree", "only degree 2 can be exported (eight-node and six-node elements)");
  }
  for (const FaceItem& item : face_items(spindle)) {
    const std::string_view reason = item.condition->not_exported;
    if (!reason.empty()) throw rom::InputError(item.where, item.name, std::string(reason));
  }
  for (const Part& part : spindle.parts) {
    if (part.initial_K) {
      throw rom::InputError(part.where, part.name, "a part with a start temperature of its own cannot be exported");
    }
  }
  if (spindle.imposed_temperature) {
    throw rom::InputError(spindle.imposed_temperature->where, "imposed_temperature",
                          "cannot be exported: there is no heat to conduct");
  }
}

/// Why the decks carry no growth; empty: they do, or none is asked for.
std::string growth_left_out(const Spindle& spindle, const DeckModel& deck) {
  const auto reason = [](const rom::SourceLine& where, const std::string& field, const std::string& text) {
    return std::string(rom::InputError(where, field, text).what());
  };
  if (spindle.deformations.empty()) return {};
  for (const Support& support : spindle.supports) {
    if (support.is_point() || support.hold_r != Hold::free || support.hold_z != Hold::fixed) {
      return reason(support.where, "support",
                    "decks know only a face held along z, no point, spring or plane, nothing "
                    "along r");
    }
  }
  for (const DeformationOutput& output : spindle.deformations) {
    if (output.at || output.minus) {
      return reason(output.where, output.name, "decks know only the mean over a face, no point and no difference");
    }
  }
  for (const DeckPair& pair : deck.pairs) {
    if (pair.kind != PieceKind::contact || pair.matching) continue;
    const Contact& contact = spindle.contacts[pair.index];
    return reason(contact.where, "contact",
                  "the meshes of '" + spindle.parts[contact.part_a].name + "' and '" +
                      spindle.parts[contact.part_b].name + "' do not match, so that their nodes cannot be bonded");
  }
  return {};
}

void add_elements(const SectionMesh& mesh, DeckModel& deck) {
  deck.nodes = mesh.points;
  deck.part_of_element = mesh.part_of_quad;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> midside_of;
  for (const auto& quad : mesh.quads) {
    std::array<std::size_t, 8> element{};
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t a = quad[k], b = quad[(k + 1) % 4];
      const auto [found, added] = midside_of.emplace(std::minmax(a, b), deck.nodes.size());
      if (added) {
        const Point& from = mesh.points[a];
        const Point& to = mesh.points[b];
        deck.nodes.push_back({0.5 * (from.r_m + to.r_m), 0.5 * (from.z_m + to.z_m)});
      }
      element[k] = a;
      element[k + 4] = found->second;
    }
    deck.elements.push_back(element);
  }
  deck.part_of_node.assign(deck.nodes.size(), 0);
  for (std::size_t e = 0; e < deck.elements.size(); ++e) {
    for (const std::size_t node : deck.elements[e]) deck.part_of_node[node] = deck.part_of_element[e];
  }
}

bool lies_on(const Point& point, const BoundaryPiece& piece) {
  const double r = piece.end.r_m - piece.start.r_m, z = piece.end.z_m - piece.start.z_m;
  const double length_m = std::hypot(r, z);
  const double dr = point.r_m - piece.start.r_m, dz = point.z_m - piece.start.z_m;
  const double along_m = (dr * r + dz * z) / length_m;
  return std::abs(dr * z - dz * r) < same_place_m * length_m && along_m > -same_place_m &&
         along_m < length_m + same_place_m;
}

/// Sides that belong to one element only, on the piece that holds both of their ends and their middle.
void sort_sides(DeckModel& deck) {
  std::map<std::size_t, std::vector<DeckSide>> sides_of_midside;
  for (std::size_t e = 0; e < deck.elements.size(); ++e) {
    for (std::size_t k = 0; k < 4; ++k) sides_of_midside[deck.elements[e][k + 4]].push_back({e, k});
  }
  const auto& pieces = deck.section.pieces;
  deck.sides_of_piece.resize(pieces.size());
  for (const auto& [midside, sides] : sides_of_midside) {
    if (sides.size() != 1) continue;
    const auto [a, b, middle] = nodes_of(deck, sides[0]);
    for (std::size_t p = 0; p < pieces.size(); ++p) {
      if (pieces[p].part != deck.part_of_element[sides[0].element]) continue;
      if (!lies_on(deck.nodes[a], pieces[p]) || !lies_on(deck.nodes[b], pieces[p])) continue;
      deck.sides_of_piece[p].push_back(sides[0]);
      break;
    }
  }
}

void add_pairs(const Spindle& spindle, const rom::BoundaryValues& values, DeckModel& deck) {
  const auto& pieces = deck.section.pieces;
  for (std::size_t a = 0; a < pieces.size(); ++a) {
    const bool is_paired = pieces[a].kind == PieceKind::contact || pieces[a].kind == PieceKind::gap;
    if (!is_paired || pieces[a].side != 0) continue;
    for (std::size_t b = 0; b < pieces.size(); ++b) {
      if (pieces[b].kind != pieces[a].kind || pieces[b].side != 1 || pieces[b].pair != pieces[a].pair) continue;
      const std::size_t conductance = pieces[a].kind == PieceKind::contact
                                          ? conductance_of_contact(spindle, pieces[a].index)
                                          : conductance_of_gap_film(spindle, pieces[a].index);
      DeckPair pair{pieces[a].kind, pieces[a].index, a, b,
                    values.conductance_W_per_m2K[static_cast<Eigen::Index>(conductance)]};
      std::set<std::size_t> nodes_a, nodes_b;
      for (const DeckSide& side : deck.sides_of_piece[a]) {
        for (const std::size_t node : nodes_of(deck, side)) nodes_a.insert(node);
      }
      for (const DeckSide& side : deck.sides_of_piece[b]) {
        for (const std::size_t node : nodes_of(deck, side)) nodes_b.insert(node);
      }
      pair.matching = nodes_a.size() == nodes_b.size() && opposite_nodes(deck, pair).size() == nodes_a.size();
      deck.pairs.push_back(pair);
    }
  }
}

void add_films(const Spindle& spindle, const rom::BoundaryValues& values, DeckModel& deck) {
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    const BoundaryPiece& piece = deck.section.pieces[p];
    if (piece.kind != PieceKind::film) continue;
    const std::size_t conductance = conductance_of_film(spindle, piece.index);
    deck.films.push_back({p, values.conductance_W_per_m2K[static_cast<Eigen::Index>(conductance)],
                          spindle.films[piece.index].surrounding});
  }
}

double area_m2(const BoundaryPiece& piece) {
  return std::numbers::pi * (piece.start.r_m + piece.end.r_m) *
         std::hypot(piece.end.r_m - piece.start.r_m, piece.end.z_m - piece.start.z_m);
}

std::vector<std::size_t> pieces_of(const HeatShare& share, const Spindle& spindle, const Section& section) {
  std::vector<std::size_t> found;
  for (std::size_t p = 0; p < section.pieces.size(); ++p) {
    if (carries(spindle, section.pieces[p], share)) found.push_back(p);
  }
  return found;
}

/// Heat divided among the shares by weight alone, or by weight times extent where the weights multiply a density.
void add_heats(const Spindle& spindle, const rom::BoundaryValues& values, DeckModel& deck) {
  for (std::size_t s = 0; s < spindle.heats.size(); ++s) {
    const HeatSource& heat = spindle.heats[s];
    const bool weight_by_extent = !heat.heat_W && heat.density_over.empty();
    std::vector<double> extents, amounts;
    double total = 0.0;
    for (const HeatShare& share : heat.shares) {
      double extent = 0.0;
      if (share.on_contact_with || share.on_face) {
        for (const std::size_t p : pieces_of(share, spindle, deck.section)) extent += area_m2(deck.section.pieces[p]);
      } else {
        extent = deck.section.outlines[share.part].volume_m3;
      }
      extents.push_back(extent);
      amounts.push_back(share.weight * (weight_by_extent ? extent : 1.0));
      total += amounts.back();
    }
    for (std::size_t i = 0; i < heat.shares.size(); ++i) {
      const HeatShare& share = heat.shares[i];
      const double density = values.heat_W[static_cast<Eigen::Index>(s)] * amounts[i] / total / extents[i];
      if (share.on_contact_with || share.on_face) {
        for (const std::size_t p : pieces_of(share, spindle, deck.section)) deck.surface_heats.push_back({p, density});
      } else {
        deck.volume_heats.push_back({share.part, density});
      }
    }
  }
}

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

std::vector<std::size_t> supported(const Spindle& spindle, const DeckModel& deck) {
  std::set<std::size_t> held;
  for (const Support& support : spindle.supports) {
    for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
      if (deck.section.pieces[p].part != support.part || !lies_in(deck.section.pieces[p], support.face)) continue;
      for (const DeckSide& side : deck.sides_of_piece[p]) {
        for (const std::size_t node : nodes_of(deck, side)) held.insert(node);
      }
    }
  }
  return {held.begin(), held.end()};
}

}  // namespace

std::array<std::size_t, 3> nodes_of(const DeckModel& deck, const DeckSide& side) {
  const auto& element = deck.elements[side.element];
  return {element[side.side], element[(side.side + 1) % 4], element[side.side + 4]};
}

std::vector<std::pair<std::size_t, std::size_t>> opposite_nodes(const DeckModel& deck, const DeckPair& pair) {
  const BoundaryPiece& line = deck.section.pieces[pair.piece_a];
  const auto by_place = [&](std::size_t piece) {
    std::map<long, std::size_t> found;
    for (const DeckSide& side : deck.sides_of_piece[piece]) {
      for (const std::size_t node : nodes_of(deck, side)) {
        const double r = line.end.r_m - line.start.r_m, z = line.end.z_m - line.start.z_m;
        const Point& at = deck.nodes[node];
        const double along_m = ((at.r_m - line.start.r_m) * r + (at.z_m - line.start.z_m) * z) / std::hypot(r, z);
        found[std::lround(along_m / same_place_m)] = node;
      }
    }
    return found;
  };
  const auto side_b = by_place(pair.piece_b);
  std::vector<std::pair<std::size_t, std::size_t>> opposite;
  for (const auto& [place, node] : by_place(pair.piece_a)) {
    const auto found = side_b.find(place);
    if (found != side_b.end()) opposite.emplace_back(node, found->second);
  }
  return opposite;
}

DeckModel make_deck_model(const Spindle& described, const rom::BoundaryValues& values) {
  refuse_what_decks_cannot_carry(described);
  Spindle spindle = described;
  spindle.mesh.curved_arcs = false;
  DeckModel deck;
  deck.section = build_section(spindle);
  add_elements(mesh_section(spindle, deck.section), deck);
  sort_sides(deck);
  add_pairs(spindle, values, deck);
  add_films(spindle, values, deck);
  add_heats(spindle, values, deck);
  for (const KeyPoint& point : spindle.key_points) deck.key_points.push_back(row_at(deck, point.part, point.at));
  deck.growth_left_out = growth_left_out(spindle, deck);
  if (!deck.growth_left_out.empty()) return deck;
  for (const DeformationOutput& output : spindle.deformations) deck.deformations.push_back(mean_over(deck, output));
  deck.supported_nodes = supported(spindle, deck);
  return deck;
}

std::vector<std::size_t> bonded_leaders(const DeckModel& deck) {
  std::vector<std::size_t> leader(deck.nodes.size());
  std::iota(leader.begin(), leader.end(), std::size_t{0});
  const auto root = [&](std::size_t node) {
    while (leader[node] != node) node = leader[node];
    return node;
  };
  for (const DeckPair& pair : deck.pairs) {
    if (pair.kind != PieceKind::contact) continue;
    for (const auto& [a, b] : opposite_nodes(deck, pair)) {
      const std::size_t of_a = root(a), of_b = root(b);
      leader[std::max(of_a, of_b)] = std::min(of_a, of_b);
    }
  }
  for (std::size_t node = 0; node < leader.size(); ++node) leader[node] = root(node);
  return leader;
}

}  // namespace spindle_twin::fem_offline
