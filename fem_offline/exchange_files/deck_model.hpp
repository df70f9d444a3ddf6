#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {

/// Side k of an element runs from its corner k to corner k + 1, the element to the left.
struct DeckSide {
  std::size_t element = 0;
  std::size_t side = 0;
};

/// Heat per volume of a part, or per area of a piece of its outline.
struct DeckVolumeHeat {
  std::size_t part = 0;
  double density_W_per_m3 = 0.0;
};
struct DeckSurfaceHeat {
  std::size_t piece = 0;
  double flux_W_per_m2 = 0.0;
};

/// Two pieces that face each other across a contact or a gap, by their index in Section::pieces.
struct DeckPair {
  PieceKind kind = PieceKind::contact;
  std::size_t index = 0;  ///< into Spindle::contacts or gap_films
  std::size_t piece_a = 0;
  std::size_t piece_b = 0;
  double conductance_W_per_m2K = 0.0;
  bool matching = true;       ///< every node of one side faces a node of the other
  double tie_N_per_m3 = 0.0;  ///< of a contact that does not match: as stiff a spring bonds its faces
};

/// A volume of air, or the liquid on its way into a segment of a coolant circuit: its temperature follows from walls.
///   air      Σ g A (T_wall − T) = C dT/dt
///   liquid   ṁ c (T − T_upstream) = Σ g A (T_wall − T_upstream) over the segment upstream; into the first the inlet's
struct DeckFluid {
  std::string name;                     ///< of the air volume, or of the segment's film
  std::size_t surrounding = 0;          ///< the air itself, or the circuit's inlet
  std::optional<std::size_t> circuit;   ///< of liquid
  double flow_W_per_K = 0.0;            ///< of liquid, |ṁ| c; 0: it stands still, and carries and takes no heat
  std::optional<std::size_t> upstream;  ///< of liquid: the fluid that it was before; none at the inlet
};

/// A circuit's segment has the conductance over the liquid that enters it, |ṁ| c (1 − exp(−NTU)) / A, as the model.
struct DeckFilm {
  std::size_t piece = 0;
  double coefficient_W_per_m2K = 0.0;
  std::size_t surrounding = 0;
  std::optional<std::size_t> fluid;  ///< into DeckModel::fluids; none: the surrounding's temperature is given
};

/// Value of an output as a weighted sum over nodes.
using DeckRow = std::vector<std::pair<std::size_t, double>>;

/// What another FE program needs to solve the same spindle on the same mesh: only geometry, material numbers and loads,
/// none of our matrices. Axisymmetric, eight-node quadrilaterals with straight sides, arcs as chords (`curved_arcs`
/// false).
struct DeckModel {  // NOLINT(public-members): plain data, a member for each block of a deck
  Section section;
  std::vector<Point> nodes;                          ///< corners, then midsides; no node is shared by two parts
  std::vector<std::array<std::size_t, 8>> elements;  ///< corners counter-clockwise, then the midsides of sides 0 to 3
  std::vector<std::size_t> part_of_element;
  std::vector<std::size_t> part_of_node;
  std::vector<std::vector<DeckSide>> sides_of_piece;  ///< one list per Section::pieces
  std::vector<DeckPair> pairs;
  std::vector<DeckFluid> fluids;  ///< volumes of air, then the segments of all circuits, in the description's order
  std::vector<DeckFilm> films;
  std::vector<DeckVolumeHeat> volume_heats;
  std::vector<DeckSurfaceHeat> surface_heats;
  std::vector<DeckRow> key_points;           ///< in the description's order
  std::vector<DeckRow> deformations;         ///< mean over the face, weighted by r, times the sign; `minus` not off
  std::vector<std::size_t> supported_nodes;  ///< u_z = 0
  std::string growth_left_out;  ///< why the two above are empty though growth is asked for: file, line, field
};

/// Loads are those of `values` (conductances in the order of description/model_places; heats in the description's
/// order). Throws rom::InputError for a model that the decks cannot carry: planar, not of degree 2, with
/// radiation, imposed temperatures or start temperatures of single parts. The thermal part goes alone, and
/// `growth_left_out` says why, with supports other than faces held along z and with outputs at points.
DeckModel make_deck_model(const Spindle& spindle, const rom::BoundaryValues& values);

/// End nodes and midside of a side.
std::array<std::size_t, 3> nodes_of(const DeckModel& deck, const DeckSide& side);

/// Nodes of the sides on a piece.
std::set<std::size_t> nodes_on(const DeckModel& deck, std::size_t piece);

/// Nodes of `piece_b` that lie opposite to each node of `piece_a`, as pairs (a, b); only for matching pairs.
std::vector<std::pair<std::size_t, std::size_t>> opposite_nodes(const DeckModel& deck, const DeckPair& pair);

/// Bonded nodes at one place move together, where the meshes of a contact match: for every node the lowest one of its
/// group, itself if it has none.
std::vector<std::size_t> bonded_leaders(const DeckModel& deck);

/// Temperatures of DeckModel::fluids along time, from our own solution: a program without unknowns for them gets them
/// prescribed.
struct FluidHistory {
  std::vector<double> time_s;
  std::vector<std::vector<double>> fluid_K;  ///< per time, one per fluid
  std::vector<double> steady_K;
};

/// What all decks of one description share.
struct DeckPlan {
  std::vector<double> output_times_s = {60.0, 300.0, 900.0, 1800.0};  ///< rising
  double start_K = 293.15;                                            ///< of the transient, everywhere
  std::vector<double> surrounding_K;                                  ///< one per surrounding; unused for air
  double constant_step_s = 0.5;                                       ///< of a scheme of second order
};

}  // namespace spindle_twin::fem_offline
