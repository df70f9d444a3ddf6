#pragma once

#include <array>
#include <cstddef>
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
  bool matching = true;  ///< every node of one side faces a node of the other
};

struct DeckFilm {
  std::size_t piece = 0;
  double coefficient_W_per_m2K = 0.0;
  std::size_t surrounding = 0;
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
  std::vector<DeckFilm> films;
  std::vector<DeckVolumeHeat> volume_heats;
  std::vector<DeckSurfaceHeat> surface_heats;
  std::vector<DeckRow> key_points;           ///< in the description's order
  std::vector<DeckRow> deformations;         ///< mean over the face, weighted by r, times the output's sign
  std::vector<std::size_t> supported_nodes;  ///< u_z = 0
  std::string growth_left_out;  ///< why the two above are empty though growth is asked for: file, line, field
};

/// Loads are those of `values` (conductances in the order of description/model_places; heats in the description's
/// order). Throws rom::InputError for a model that the decks cannot carry: planar, not of degree 2, with
/// radiation, imposed temperatures or start temperatures of single parts. The thermal part goes alone, and
/// `growth_left_out` says why, with supports other than faces held along z, with outputs at points or of differences,
/// and where the meshes of two parts in contact do not match.
DeckModel make_deck_model(const Spindle& spindle, const rom::BoundaryValues& values);

/// End nodes and midside of a side.
std::array<std::size_t, 3> nodes_of(const DeckModel& deck, const DeckSide& side);

/// Nodes of `piece_b` that lie opposite to each node of `piece_a`, as pairs (a, b); only for matching pairs.
std::vector<std::pair<std::size_t, std::size_t>> opposite_nodes(const DeckModel& deck, const DeckPair& pair);

/// Bonded nodes at one place move together: for every node the lowest one of its group, itself if it has none.
std::vector<std::size_t> bonded_leaders(const DeckModel& deck);

/// Temperatures of the air volumes along time, from our own solution: a program without a node for a volume of
/// well-mixed air gets them prescribed.
struct AirHistory {
  std::vector<double> time_s;
  std::vector<std::vector<double>> air_K;  ///< per time, one per air surrounding in the description's order
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
