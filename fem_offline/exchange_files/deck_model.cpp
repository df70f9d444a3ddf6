#include "fem_offline/exchange_files/deck_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "fem_offline/description/model_places.hpp"
#include "fem_offline/exchange_files/deck_rows.hpp"

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
std::string growth_left_out(const Spindle& spindle) {
  const auto reason = [](const rom::SourceLine& where, const std::string& field, const std::string& text) {
    return std::string(rom::InputError(where, field, text).what());
  };
  if (spindle.deformations.empty()) return {};
  for (const Support& support : spindle.supports) {
    if (support.is_point() || support.hold_r != Hold::free || support.hold_z != Hold::fixed) {
      return reason(support.where, "support",
                    "decks know only a face held along z, no point, spring or plane, nothing along r");
    }
  }
  for (const DeformationOutput& output : spindle.deformations) {
    if (output.at) return reason(output.where, output.name, "decks know only means over a face, no point");
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

/// 10⁴ E / h, h the shortest side of an element on the two faces: that of the model's own surface spring.
double tie_N_per_m3(const Spindle& spindle, const DeckModel& deck, const DeckPair& pair) {
  constexpr double over_element = 1e4;
  double least_m = std::numeric_limits<double>::max(), modulus_Pa = 0.0;
  for (const std::size_t piece : {pair.piece_a, pair.piece_b}) {
    for (const DeckSide& side : deck.sides_of_piece[piece]) {
      const auto [a, b, middle] = nodes_of(deck, side);
      least_m =
          std::min(least_m, std::hypot(deck.nodes[b].r_m - deck.nodes[a].r_m, deck.nodes[b].z_m - deck.nodes[a].z_m));
    }
    const Part& part = spindle.parts[deck.section.pieces[piece].part];
    modulus_Pa = std::max(modulus_Pa, spindle.materials[part.material].youngs_modulus_Pa);
  }
  return over_element * modulus_Pa / least_m;
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
      const std::size_t on_a = nodes_on(deck, a).size(), on_b = nodes_on(deck, b).size();
      pair.matching = on_a == on_b && opposite_nodes(deck, pair).size() == on_a;
      if (pair.kind == PieceKind::contact && !pair.matching) pair.tie_N_per_m3 = tie_N_per_m3(spindle, deck, pair);
      deck.pairs.push_back(pair);
    }
  }
}

void add_films(const Spindle& spindle, const rom::BoundaryValues& values, DeckModel& deck) {
  for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
    const BoundaryPiece& piece = deck.section.pieces[p];
    if (piece.kind != PieceKind::film) continue;
    const std::size_t conductance = conductance_of_film(spindle, piece.index);
    const Film& film = spindle.films[piece.index];
    const auto fluid = std::find_if(deck.fluids.begin(), deck.fluids.end(), [&](const DeckFluid& known) {
      return known.circuit ? known.name == film.name : known.surrounding == film.surrounding;
    });
    std::optional<std::size_t> sees;
    if (fluid != deck.fluids.end()) sees = static_cast<std::size_t>(fluid - deck.fluids.begin());
    deck.films.push_back(
        {p, values.conductance_W_per_m2K[static_cast<Eigen::Index>(conductance)], film.surrounding, sees});
  }
}

/// Volumes of air, then the segments of the circuits in the description's order; the liquid comes from the segment that
/// the flow passes before.
void add_fluids(const Spindle& spindle, const rom::BoundaryValues& values, DeckModel& deck) {
  for (std::size_t s = 0; s < spindle.surroundings.size(); ++s) {
    if (spindle.surroundings[s].kind != SurroundingKind::air) continue;
    deck.fluids.push_back({spindle.surroundings[s].name, s, std::nullopt, 0.0, std::nullopt});
  }
  for (std::size_t c = 0; c < spindle.circuits.size(); ++c) {
    const CoolantCircuit& circuit = spindle.circuits[c];
    const double flow_W_per_K = values.coolant_W_per_K[static_cast<Eigen::Index>(c)];
    const std::size_t first = deck.fluids.size(), count = circuit.segments.size();
    for (std::size_t i = 0; i < count; ++i) {
      std::optional<std::size_t> upstream;
      if (flow_W_per_K > 0.0 && i > 0) upstream = first + i - 1;
      if (flow_W_per_K < 0.0 && i + 1 < count) upstream = first + i + 1;
      deck.fluids.push_back(
          {spindle.films[circuit.segments[i]].name, circuit.inlet, c, std::abs(flow_W_per_K), upstream});
    }
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

std::vector<std::size_t> supported(const Spindle& spindle, const DeckModel& deck) {
  std::set<std::size_t> held;
  for (const Support& support : spindle.supports) {
    for (std::size_t p = 0; p < deck.section.pieces.size(); ++p) {
      if (deck.section.pieces[p].part != support.part || !lies_in(deck.section.pieces[p], support.face)) continue;
      held.merge(nodes_on(deck, p));
    }
  }
  return {held.begin(), held.end()};
}

}  // namespace

std::array<std::size_t, 3> nodes_of(const DeckModel& deck, const DeckSide& side) {
  const auto& element = deck.elements[side.element];
  return {element[side.side], element[(side.side + 1) % 4], element[side.side + 4]};
}

std::set<std::size_t> nodes_on(const DeckModel& deck, std::size_t piece) {
  std::set<std::size_t> nodes;
  for (const DeckSide& side : deck.sides_of_piece[piece]) {
    for (const std::size_t node : nodes_of(deck, side)) nodes.insert(node);
  }
  return nodes;
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
  add_fluids(spindle, values, deck);
  add_films(spindle, values, deck);
  add_heats(spindle, values, deck);
  for (const KeyPoint& point : spindle.key_points) deck.key_points.push_back(row_at(deck, point.part, point.at));
  deck.growth_left_out = growth_left_out(spindle);
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
    if (pair.kind != PieceKind::contact || !pair.matching) continue;
    for (const auto& [a, b] : opposite_nodes(deck, pair)) {
      const std::size_t of_a = root(a), of_b = root(b);
      leader[std::max(of_a, of_b)] = std::min(of_a, of_b);
    }
  }
  for (std::size_t node = 0; node < leader.size(); ++node) leader[node] = root(node);
  return leader;
}

}  // namespace spindle_twin::fem_offline
