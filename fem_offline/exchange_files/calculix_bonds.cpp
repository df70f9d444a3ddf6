#include "fem_offline/exchange_files/calculix_bonds.hpp"

#include <cmath>
#include <map>
#include <set>

#include "fem_offline/exchange_files/deck_files.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// A node that moves as a weighted sum of others, none of which moves as a sum that it is part of itself.
using Equations = std::map<std::size_t, DeckRow>;

bool follows(const Equations& equations, std::size_t node, std::size_t other) {
  if (node == other) return true;
  const auto found = equations.find(node);
  if (found == equations.end()) return false;
  for (const auto& [next, weight] : found->second) {
    if (follows(equations, next, other)) return true;
  }
  return false;
}

/// The place on the face as a sum over the three nodes of the side that holds it; empty beyond its ends.
DeckRow on_face(const DeckModel& deck, std::size_t piece, const Point& at) {
  for (const DeckSide& side : deck.sides_of_piece[piece]) {
    const auto [a, b, middle] = nodes_of(deck, side);
    const double r = deck.nodes[b].r_m - deck.nodes[a].r_m, z = deck.nodes[b].z_m - deck.nodes[a].z_m;
    const double share = ((at.r_m - deck.nodes[a].r_m) * r + (at.z_m - deck.nodes[a].z_m) * z) / (r * r + z * z);
    const double slack = same_place_m / std::hypot(r, z);
    if (share < -slack || share > 1.0 + slack) continue;
    return {{a, (1.0 - share) * (1.0 - 2.0 * share)},
            {b, share * (2.0 * share - 1.0)},
            {middle, 4.0 * share * (1.0 - share)}};
  }
  return {};
}

void tie_faces(const DeckModel& deck, const DeckPair& pair, const std::vector<std::size_t>& leader,
               const std::set<std::size_t>& held, Equations& equations) {
  const bool first_is_finer = deck.sides_of_piece[pair.piece_a].size() > deck.sides_of_piece[pair.piece_b].size();
  const std::size_t finer = first_is_finer ? pair.piece_a : pair.piece_b;
  const std::size_t coarser = first_is_finer ? pair.piece_b : pair.piece_a;
  for (const std::size_t on_finer : nodes_on(deck, finer)) {
    const std::size_t node = leader[on_finer];
    if (held.contains(node) || deck.nodes[node].r_m < same_place_m || equations.contains(node)) continue;
    std::map<std::size_t, double> weights;
    bool circular = false;
    for (const auto& [other, weight] : on_face(deck, coarser, deck.nodes[node])) {
      if (std::abs(weight) < 1e-9) continue;
      weights[leader[other]] += weight;
      circular = circular || follows(equations, leader[other], node);
    }
    if (!weights.empty() && !circular) equations[node] = {weights.begin(), weights.end()};
  }
}

}  // namespace

void write_calculix_bonds(const DeckModel& deck, const std::string& directory) {
  const std::vector<std::size_t> leader = bonded_leaders(deck);
  std::set<std::size_t> held;
  for (const std::size_t node : deck.supported_nodes) held.insert(leader[node]);
  Equations equations;
  for (const DeckPair& pair : deck.pairs) {
    if (pair.tie_N_per_m3 > 0.0) tie_faces(deck, pair, leader, held, equations);
  }
  for (std::size_t node = 0; node < leader.size(); ++node) {
    if (leader[node] != node) equations[node] = {{leader[node], 1.0}};
  }
  DeckFile file(directory, "bonds.inc");
  for (const auto& [node, row] : equations) {
    for (int direction = 1; direction <= 2; ++direction) {
      file << "*EQUATION\n" << row.size() + 1 << "\n" << node + 1 << ", " << direction << ", 1.";
      for (const auto& [other, weight] : row) file << ",\n" << other + 1 << ", " << direction << ", " << -weight;
      file << "\n";
    }
  }
  file << "*BOUNDARY\n";
  for (const std::size_t node : held) file << node + 1 << ", 2, 2\n";
  for (std::size_t node = 0; node < leader.size(); ++node) {
    if (leader[node] == node && deck.nodes[node].r_m < same_place_m) file << node + 1 << ", 1, 1\n";
  }
  file.close();
}

}  // namespace spindle_twin::fem_offline
