#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fem_offline/description/spindle.hpp"

namespace spindle_twin::rom {
class TomlTable;
}

/// What may happen at a face of a part: one table with one row per [[table]] of a description. Reader, section, model,
/// pictures and decks ask the row, so that another condition of a known shape is a reader and a row
/// (face_conditions.cpp).
namespace spindle_twin::fem_offline {

struct Reading;

/// What a piece of outline is to the section; an index beside it points into the description's list of that kind.
enum class PieceKind { contact, film, gap, adiabatic, axis };

/// Which faces a condition finds; outlines are cut where they begin and end.
enum class Finds {
  touching_parts,       ///< where two parts touch
  walls_of_a_gap,       ///< where two parts look at each other across a region
  faces_towards_voids,  ///< whose outward side lies in a region
  faces_in_a_box,       ///< of one part, within the box; that cut lasts, although the same happens on both of its sides
};

/// Whether a face has room for a second condition.
enum class Claims {
  alone,   ///< two of this sort on one face are an error
  beside,  ///< acts besides the one that claims the face, but in no gap; where there is none it is that one itself
};

/// What the model makes of it.
enum class Assembles {
  nothing,
  conductance,       ///< between two parts, or towards a surrounding
  held_temperature,  ///< a conductance so large that the face takes the surrounding's temperature
  heat,              ///< a source
};

/// A line along the face on a picture; lengths in pixels of a picture 2000 wide.
struct FaceMark {
  double offset_px = 0.0;  ///< from the face outwards
  double width_px = 4.0;
  double legend_width_px = 4.0;
  std::array<double, 2> dashes_px = {};              ///< on, off; solid where 0
  bool white_dashes = false;                         ///< the dashes are white and narrower, on a solid band
  std::optional<std::array<double, 4>> colour = {};  ///< red, green, blue, opacity, 0 to 1; else by its surrounding
  std::string_view legend = {};                      ///< stands before the name
};

/// One row of the table.
struct FaceCondition {
  std::string_view table;                                    ///< [[table]] in the description
  void (*read)(const rom::TomlTable& table, Reading& into);  ///< adds the table to the description
  std::string_view words;                                    ///< before the name in a message
  std::string_view field;                                    ///< of an error: field.name
  std::optional<PieceKind> piece;                            ///< none: it never has a piece of outline to itself
  Finds finds;
  Claims claims;
  Assembles assembles;
  FaceMark mark;
  std::string_view not_exported = {};  ///< why decks for other solvers refuse it; empty: they carry it
};

/// All of them, in the order in which a description is read.
std::span<const FaceCondition> face_conditions();

/// The row of a [[table]]. Throws std::logic_error if there is none.
const FaceCondition& face_condition(std::string_view table);

/// The condition that holds the index-th item of a kind of piece; not for the axis.
const FaceCondition& face_condition(const Spindle& spindle, PieceKind piece, std::size_t index);

/// One condition of a description and the faces that it asks for.
struct FaceItem {
  const FaceCondition* condition = nullptr;
  std::size_t index = 0;           ///< into Spindle::contacts, gap_films, films, adiabatics or heats
  std::string name;                ///< of a contact: its parts, a-b
  std::vector<std::size_t> parts;  ///< of contact and gap the two, else only these; all if empty
  std::vector<Box> regions;        ///< none of a contact; of a heat on a face: the box
  rom::SourceLine where;
};

/// All of a description: contacts, gap films, films, adiabatic regions, then the heats on faces, share by share. What
/// assembles a conductance stands in the order of model_places.
std::vector<FaceItem> face_items(const Spindle& spindle);

}  // namespace spindle_twin::fem_offline
