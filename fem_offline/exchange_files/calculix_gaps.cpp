#include "fem_offline/exchange_files/calculix_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace spindle_twin::fem_offline {
namespace {

/// A gap's layer: elements between the two faces, nodes across numbered after those of the mesh.
struct GapLayer {
  std::size_t pair = 0;
  double conductivity_r_W_per_mK = 0.0;
  double conductivity_z_W_per_mK = 0.0;
  std::vector<std::array<std::size_t, 8>> elements;
};

/// Along the faces the layer must not conduct; a millionth keeps the material matrix regular.
constexpr double along_share = 1e-6;

GapLayer make_layer(const Spindle& spindle, const DeckModel& deck, std::size_t number, std::vector<Point>& nodes) {
  const DeckPair& pair = deck.pairs[number];
  const GapFilm& gap = spindle.gap_films[pair.index];
  if (!pair.matching) {
    throw rom::InputError(gap.where, gap.name, "the meshes of the two faces do not match, which CalculiX needs here");
  }
  const Point& a = deck.section.pieces[pair.piece_a].start;
  const Point& a_end = deck.section.pieces[pair.piece_a].end;
  const Point& b = deck.section.pieces[pair.piece_b].start;
  GapLayer layer{number, 0.0, 0.0, {}};
  if (std::abs(a.r_m - a_end.r_m) < same_place_m) {
    const double across = pair.conductance_W_per_m2K * 0.5 * (a.r_m + b.r_m) * std::abs(std::log(b.r_m / a.r_m));
    layer.conductivity_r_W_per_mK = across;
    layer.conductivity_z_W_per_mK = along_share * across;
  } else if (std::abs(a.z_m - a_end.z_m) < same_place_m) {
    const double across = pair.conductance_W_per_m2K * std::abs(b.z_m - a.z_m);
    layer.conductivity_r_W_per_mK = along_share * across;
    layer.conductivity_z_W_per_mK = across;
  } else {
    throw rom::InputError(gap.where, gap.name, "a gap along neither r nor z cannot be exported to CalculiX");
  }
  std::map<std::size_t, std::size_t> opposite, across;
  for (const auto& [on_a, on_b] : opposite_nodes(deck, pair)) opposite[on_a] = on_b;
  const auto across_at = [&](std::size_t node) {
    const auto [found, added] = across.emplace(node, nodes.size());
    if (added) {
      const Point& from = deck.nodes[node];
      const Point& to = deck.nodes[opposite.at(node)];
      nodes.push_back({0.5 * (from.r_m + to.r_m), 0.5 * (from.z_m + to.z_m)});
    }
    return found->second;
  };
  for (const DeckSide& side : deck.sides_of_piece[pair.piece_a]) {
    const auto [from, to, middle] = nodes_of(deck, side);
    layer.elements.push_back(
        {to, from, opposite.at(from), opposite.at(to), middle, across_at(from), opposite.at(middle), across_at(to)});
  }
  return layer;
}

}  // namespace

void write_nodes(DeckFile& file, const std::vector<Point>& nodes, std::size_t first) {
  file << "*NODE, NSET=ALL\n";
  for (std::size_t i = first; i < nodes.size(); ++i) {
    file << i + 1 << ", " << nodes[i].r_m << ", " << nodes[i].z_m << ", 0\n";
  }
}

void write_element(DeckFile& file, std::size_t number, const std::array<std::size_t, 8>& nodes) {
  file << number;
  for (const std::size_t node : nodes) file << ", " << node + 1;
  file << "\n";
}

void write_gap_layers(DeckFile& file, const Spindle& spindle, const DeckModel& deck) {
  std::vector<Point> nodes = deck.nodes;
  std::vector<GapLayer> layers;
  for (std::size_t p = 0; p < deck.pairs.size(); ++p) {
    if (deck.pairs[p].kind == PieceKind::gap) layers.push_back(make_layer(spindle, deck, p, nodes));
  }
  if (!layers.empty()) write_nodes(file, nodes, deck.nodes.size());
  std::size_t number = deck.elements.size();
  for (const GapLayer& layer : layers) {
    const std::string set = set_name('G', layer.pair);
    file << "** " << spindle.gap_films[deck.pairs[layer.pair].index].name << "\n*ELEMENT, TYPE=CAX8, ELSET=" << set
         << "\n";
    for (const auto& element : layer.elements) write_element(file, ++number, element);
    // No mass and no stiffness to speak of: the film stores nothing.
    file << "*MATERIAL, NAME=" << set << "\n*CONDUCTIVITY, TYPE=ORTHO\n"
         << layer.conductivity_r_W_per_mK << ", " << layer.conductivity_z_W_per_mK << ", "
         << along_share * layer.conductivity_r_W_per_mK << "\n*DENSITY\n1.E-6\n*SPECIFIC HEAT\n1.\n*ELASTIC\n1., .3\n"
         << "*SOLID SECTION, ELSET=" << set << ", MATERIAL=" << set << "\n";
  }
}

}  // namespace spindle_twin::fem_offline
