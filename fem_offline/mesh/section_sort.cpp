#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "fem_offline/mesh/section_detail.hpp"

namespace spindle_twin::fem_offline::section_detail {
namespace {

std::string quoted(const std::string& name) { return "\"" + name + "\""; }

std::string contact_name(const Spindle& spindle, const Contact& contact) {
  return spindle.parts[contact.part_a].name + "-" + spindle.parts[contact.part_b].name;
}

bool in_any(const std::vector<Box>& regions, const Vec& point) {
  return std::any_of(regions.begin(), regions.end(), [&](const Box& box) { return contains(to_mm(box), point); });
}

bool reversed(const Piece& a, const Piece& b) { return same(a.start, b.end) && same(a.end, b.start); }

/// Whether b looks at a from the other side of a gap: opposite, parallel to an axis and over the same stretch.
bool faces_across(const Piece& a, const Piece& b) {
  const bool along_z = std::abs(a.start.r - a.end.r) <= snap_mm && std::abs(b.start.r - b.end.r) <= snap_mm;
  const bool along_r = std::abs(a.start.z - a.end.z) <= snap_mm && std::abs(b.start.z - b.end.z) <= snap_mm;
  if (along_z) {
    const double outward = a.end.z > a.start.z ? 1.0 : -1.0;
    return same({0.0, a.start.z}, {0.0, b.end.z}) && same({0.0, a.end.z}, {0.0, b.start.z}) &&
           (b.start.r - a.start.r) * outward > snap_mm;
  }
  if (along_r) {
    const double outward = a.end.r < a.start.r ? 1.0 : -1.0;
    return same({a.start.r, 0.0}, {b.end.r, 0.0}) && same({a.end.r, 0.0}, {b.start.r, 0.0}) &&
           (b.start.z - a.start.z) * outward > snap_mm;
  }
  return false;
}

class Sorter {
 public:
  Sorter(const Spindle& spindle, std::vector<Piece> pieces) : spindle_(spindle), pieces_(std::move(pieces)) {}

  std::vector<BoundaryPiece> sort() {
    sort_contacts();
    sort_gaps();
    for (Piece& piece : pieces_) {
      if (!piece.law || piece.law->kind == PieceKind::gap) sort_exposed(piece);
    }
    refuse_idle_laws();
    refuse_bare_faces();
    join();
    number_pairs();
    return result();
  }

 private:
  void sort_contacts() {
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> declared;
    for (std::size_t i = 0; i < spindle_.contacts.size(); ++i) {
      const Contact& contact = spindle_.contacts[i];
      declared[std::minmax(contact.part_a, contact.part_b)] = i;
    }
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      for (std::size_t j = i + 1; j < pieces_.size(); ++j) {
        Piece &a = pieces_[i], &b = pieces_[j];
        if (a.part == b.part || !reversed(a, b)) continue;
        const auto found = declared.find(std::minmax(a.part, b.part));
        if (found == declared.end()) {
          const Part &first = spindle_.parts[a.part], &second = spindle_.parts[b.part];
          throw rom::InputError(second.where, "part." + second.name,
                                "touches part " + quoted(first.name) + " from " + printed(a.start, a.end) +
                                    ", but no contact between the two is declared");
        }
        const Contact& contact = spindle_.contacts[found->second];
        a.law = Law{PieceKind::contact, found->second, contact.part_a == a.part ? 0 : 1};
        b.law = Law{PieceKind::contact, found->second, contact.part_a == b.part ? 0 : 1};
      }
    }
  }

  void sort_gaps() {
    for (std::size_t g = 0; g < spindle_.gap_films.size(); ++g) {
      const GapFilm& gap = spindle_.gap_films[g];
      const BoxMm region = to_mm(gap.region);
      for (Piece& a : pieces_) {
        if (a.part != gap.part_a || !contains(region, a.hair_outside())) continue;
        for (Piece& b : pieces_) {
          if (b.part != gap.part_b || !contains(region, b.hair_outside()) || !faces_across(a, b)) continue;
          for (const Piece* piece : {&a, &b}) {
            if (piece->law && piece->law->kind == PieceKind::gap) {
              refuse_two_laws(*piece, describe(*piece->law), "gap_film " + quoted(gap.name), gap.where,
                              "gap_film." + gap.name);
            }
          }
          if (a.law || b.law) continue;
          a.law = Law{PieceKind::gap, g, 0};
          b.law = Law{PieceKind::gap, g, 1};
        }
      }
    }
  }

  void sort_exposed(Piece& piece) {
    if (spindle_.geometry == Geometry::axisymmetric && std::abs(piece.start.r) <= snap_mm &&
        std::abs(piece.end.r) <= snap_mm) {
      piece.law = Law{PieceKind::axis, 0, 0};
      return;
    }
    const Vec outside = piece.hair_outside();
    const auto take = [&](const Law& law, const std::string& name, const rom::SourceLine& where,
                          const std::string& field) {
      if (piece.law) refuse_two_laws(piece, describe(*piece.law), name, where, field);
      piece.law = law;
    };
    for (std::size_t i = 0; i < spindle_.films.size(); ++i) {
      const Film& film = spindle_.films[i];
      const auto& only = film.only_parts;
      if (!only.empty() && std::find(only.begin(), only.end(), piece.part) == only.end()) continue;
      if (!in_any(film.regions, outside)) continue;
      if (film.kind == FilmKind::radiation) {
        const bool in_gap = piece.law && piece.law->kind == PieceKind::gap;
        if (!in_gap) piece.radiations.push_back(i);
      } else {
        take(Law{PieceKind::film, i, 0}, "film " + quoted(film.name), film.where, "film." + film.name);
      }
    }
    for (std::size_t i = 0; i < spindle_.adiabatics.size(); ++i) {
      const Adiabatic& adiabatic = spindle_.adiabatics[i];
      if (in_any(adiabatic.regions, outside)) {
        take(Law{PieceKind::adiabatic, i, 0}, "adiabatic region " + quoted(adiabatic.name), adiabatic.where,
             "adiabatic." + adiabatic.name);
      }
    }
    if (piece.law || piece.radiations.empty()) return;
    piece.law = Law{PieceKind::film, piece.radiations.front(), 0};
    piece.radiations.erase(piece.radiations.begin());
  }

  std::string describe(const Law& law) const {
    switch (law.kind) {
      case PieceKind::film:
        return "film " + quoted(spindle_.films[law.index].name);
      case PieceKind::gap:
        return "gap_film " + quoted(spindle_.gap_films[law.index].name);
      case PieceKind::adiabatic:
        return "adiabatic region " + quoted(spindle_.adiabatics[law.index].name);
      case PieceKind::contact:
        return "contact " + quoted(contact_name(spindle_, spindle_.contacts[law.index]));
      default:
        return "the axis";
    }
  }

  [[noreturn]] void refuse_two_laws(const Piece& piece, const std::string& first, const std::string& second,
                                    const rom::SourceLine& where, const std::string& field) const {
    throw rom::InputError(where, field,
                          "the face of part " + quoted(spindle_.parts[piece.part].name) + " from " +
                              printed(piece.start, piece.end) + " is hit by two laws: " + first + " and " + second);
  }

  bool any_with(PieceKind kind, std::size_t index) const {
    return std::any_of(pieces_.begin(), pieces_.end(), [&](const Piece& piece) {
      const auto& beside = piece.radiations;
      return (piece.law && piece.law->kind == kind && piece.law->index == index) ||
             (kind == PieceKind::film && std::find(beside.begin(), beside.end(), index) != beside.end());
    });
  }

  void refuse_idle_laws() const {
    for (std::size_t i = 0; i < spindle_.contacts.size(); ++i) {
      const Contact& contact = spindle_.contacts[i];
      if (any_with(PieceKind::contact, i)) continue;
      throw rom::InputError(contact.where, "contact." + contact_name(spindle_, contact),
                            "parts " + quoted(spindle_.parts[contact.part_a].name) + " and " +
                                quoted(spindle_.parts[contact.part_b].name) + " do not touch");
    }
    for (std::size_t i = 0; i < spindle_.gap_films.size(); ++i) {
      const GapFilm& gap = spindle_.gap_films[i];
      if (any_with(PieceKind::gap, i)) continue;
      throw rom::InputError(gap.where, "gap_film." + gap.name,
                            "acts on no face: in its region no faces of parts " +
                                quoted(spindle_.parts[gap.part_a].name) + " and " +
                                quoted(spindle_.parts[gap.part_b].name) + " look at each other");
    }
    for (std::size_t i = 0; i < spindle_.films.size(); ++i) {
      const Film& film = spindle_.films[i];
      if (any_with(PieceKind::film, i)) continue;
      std::string parts;
      for (const std::size_t part : film.only_parts) parts += (parts.empty() ? "" : ", ") + spindle_.parts[part].name;
      throw rom::InputError(
          film.where, "film." + film.name,
          "acts on no face: no exposed face " + (parts.empty() ? "" : "of " + parts + " ") + "looks into its regions");
    }
    for (std::size_t i = 0; i < spindle_.adiabatics.size(); ++i) {
      const Adiabatic& adiabatic = spindle_.adiabatics[i];
      if (any_with(PieceKind::adiabatic, i)) continue;
      throw rom::InputError(adiabatic.where, "adiabatic." + adiabatic.name,
                            "acts on no face: no exposed face looks into its regions");
    }
  }

  void refuse_bare_faces() const {
    const auto bare = [](const Piece& piece) { return !piece.law; };
    const auto first = std::find_if(pieces_.begin(), pieces_.end(), bare);
    if (first == pieces_.end()) return;
    const auto more = std::count_if(first + 1, pieces_.end(), bare);
    const Part& part = spindle_.parts[first->part];
    std::string others;
    if (more > 0) others = "; so have " + std::to_string(more) + " more";
    throw rom::InputError(part.where, "part." + part.name,
                          "the face from " + printed(first->start, first->end) +
                              " has no film, no gap film, no contact and no adiabatic region" + others);
  }

  void join() {
    std::vector<Piece> joined;
    for (const Piece& piece : pieces_) {
      if (!joined.empty() && !joined.back().last_of_edge && !joined.back().lasting_end &&
          joined.back().law == piece.law && joined.back().radiations == piece.radiations) {
        joined.back().end = piece.end;
        joined.back().lasting_end = piece.lasting_end;
        joined.back().last_of_edge = piece.last_of_edge;
      } else {
        joined.push_back(piece);
      }
    }
    pieces_ = std::move(joined);
  }

  void number_pairs() {
    std::size_t count = 0;
    for (Piece& a : pieces_) {
      if ((a.law->kind != PieceKind::contact && a.law->kind != PieceKind::gap) || a.law->side != 0) continue;
      const auto other = std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& b) {
        return b.law->kind == a.law->kind && b.law->index == a.law->index && b.law->side == 1 &&
               (a.law->kind == PieceKind::contact ? reversed(a, b) : faces_across(a, b));
      });
      if (other == pieces_.end())
        throw std::logic_error("section: a face has no opposite at " + printed(a.start, a.end));
      // The grid allows two sides of a slanted contact to differ by a rounding; from here on they are one.
      if (a.law->kind == PieceKind::contact) {
        other->start = a.end;
        other->end = a.start;
      }
      a.pair = other->pair = count++;
    }
  }

  std::vector<BoundaryPiece> result() const {
    std::vector<BoundaryPiece> pieces;
    for (const Piece& piece : pieces_) {
      pieces.push_back({piece.part,
                        to_m(piece.start),
                        to_m(piece.end),
                        piece.law->kind,
                        piece.law->index,
                        piece.law->side,
                        piece.pair,
                        piece.radiations,
                        {}});
    }
    return pieces;
  }

  const Spindle& spindle_;
  std::vector<Piece> pieces_;
};

}  // namespace

std::vector<BoundaryPiece> sort_pieces(const Spindle& spindle, std::vector<Piece> pieces) {
  return Sorter(spindle, std::move(pieces)).sort();
}

}  // namespace spindle_twin::fem_offline::section_detail
