#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "fem_offline/mesh/section_detail.hpp"

namespace spindle_twin::fem_offline::section_detail {
namespace {

std::string quoted(const std::string& name) { return "\"" + name + "\""; }

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
  Sorter(const Spindle& spindle, std::vector<Piece> pieces)
      : spindle_(spindle), items_(face_items(spindle)), pieces_(std::move(pieces)) {}

  std::vector<BoundaryPiece> sort() {
    claim_contacts();
    claim_gaps();
    for (Piece& piece : pieces_) {
      if (!piece.claim || piece.claim->kind == PieceKind::gap) claim_exposed(piece);
    }
    refuse_idle_conditions();
    refuse_bare_faces();
    join();
    number_pairs();
    return result();
  }

 private:
  void claim_contacts() {
    std::map<std::pair<std::size_t, std::size_t>, const FaceItem*> declared;
    for (const FaceItem& item : items_) {
      if (item.condition->finds == Finds::touching_parts) declared[std::minmax(item.parts[0], item.parts[1])] = &item;
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
        const FaceItem& contact = *found->second;
        a.claim = claim_of(contact, contact.parts[0] == a.part ? 0 : 1);
        b.claim = claim_of(contact, contact.parts[0] == b.part ? 0 : 1);
      }
    }
  }

  void claim_gaps() {
    for (const FaceItem& gap : items_) {
      if (gap.condition->finds != Finds::walls_of_a_gap) continue;
      for (Piece& a : pieces_) {
        if (a.part != gap.parts[0] || !in_any(gap.regions, a.hair_outside())) continue;
        for (Piece& b : pieces_) {
          if (b.part != gap.parts[1] || !in_any(gap.regions, b.hair_outside()) || !faces_across(a, b)) continue;
          for (const Piece* piece : {&a, &b}) {
            if (piece->claim && piece->claim->kind == PieceKind::gap) refuse_two(*piece, gap);
          }
          if (a.claim || b.claim) continue;
          a.claim = claim_of(gap, 0);
          b.claim = claim_of(gap, 1);
        }
      }
    }
  }

  void claim_exposed(Piece& piece) {
    if (spindle_.geometry == Geometry::axisymmetric && std::abs(piece.start.r) <= snap_mm &&
        std::abs(piece.end.r) <= snap_mm) {
      piece.claim = Claim{PieceKind::axis, 0, 0};
      return;
    }
    const Vec outside = piece.hair_outside();
    for (const FaceItem& item : items_) {
      if (item.condition->finds != Finds::faces_towards_voids || !in_any(item.regions, outside)) continue;
      const auto& only = item.parts;
      if (!only.empty() && std::find(only.begin(), only.end(), piece.part) == only.end()) continue;
      if (item.condition->claims == Claims::beside) {
        const bool in_gap = piece.claim && piece.claim->kind == PieceKind::gap;
        if (!in_gap) piece.beside.push_back(item.index);
        continue;
      }
      if (piece.claim) refuse_two(piece, item);
      piece.claim = claim_of(item, 0);
    }
    if (piece.claim || piece.beside.empty()) return;
    piece.claim = Claim{PieceKind::film, piece.beside.front(), 0};
    piece.beside.erase(piece.beside.begin());
  }

  static Claim claim_of(const FaceItem& item, int side) { return {*item.condition->piece, item.index, side}; }

  static std::string described(const FaceItem& item) {
    return std::string(item.condition->words) + " " + quoted(item.name);
  }

  static std::string field_of(const FaceItem& item) { return std::string(item.condition->field) + "." + item.name; }

  std::string described(const Claim& claim) const {
    for (const FaceItem& item : items_) {
      if (item.condition->piece == claim.kind && item.index == claim.index) return described(item);
    }
    return "the axis";
  }

  [[noreturn]] void refuse_two(const Piece& piece, const FaceItem& second) const {
    throw rom::InputError(second.where, field_of(second),
                          "the face of part " + quoted(spindle_.parts[piece.part].name) + " from " +
                              printed(piece.start, piece.end) + " is hit by two laws: " + described(*piece.claim) +
                              " and " + described(second));
  }

  bool acts_somewhere(const FaceItem& item) const {
    const PieceKind kind = *item.condition->piece;
    return std::any_of(pieces_.begin(), pieces_.end(), [&](const Piece& piece) {
      return (piece.claim && piece.claim->kind == kind && piece.claim->index == item.index) ||
             (kind == PieceKind::film &&
              std::find(piece.beside.begin(), piece.beside.end(), item.index) != piece.beside.end());
    });
  }

  void refuse_idle_conditions() const {
    for (const FaceItem& item : items_) {
      if (item.condition->piece && !acts_somewhere(item)) {
        throw rom::InputError(item.where, field_of(item), why_idle(item));
      }
    }
  }

  std::string why_idle(const FaceItem& item) const {
    const auto part = [&](std::size_t of_item) { return spindle_.parts[item.parts[of_item]].name; };
    switch (item.condition->finds) {
      case Finds::touching_parts:
        return "parts " + quoted(part(0)) + " and " + quoted(part(1)) + " do not touch";
      case Finds::walls_of_a_gap:
        return "acts on no face: in its region no faces of parts " + quoted(part(0)) + " and " + quoted(part(1)) +
               " look at each other";
      default:
        break;
    }
    std::string parts;
    for (std::size_t p = 0; p < item.parts.size(); ++p) parts += (parts.empty() ? "" : ", ") + part(p);
    return "acts on no face: no exposed face " + (parts.empty() ? "" : "of " + parts + " ") + "looks into its regions";
  }

  void refuse_bare_faces() const {
    const auto bare = [](const Piece& piece) { return !piece.claim; };
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
          joined.back().claim == piece.claim && joined.back().beside == piece.beside) {
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
      if ((a.claim->kind != PieceKind::contact && a.claim->kind != PieceKind::gap) || a.claim->side != 0) continue;
      const auto other = std::find_if(pieces_.begin(), pieces_.end(), [&](const Piece& b) {
        return b.claim->kind == a.claim->kind && b.claim->index == a.claim->index && b.claim->side == 1 &&
               (a.claim->kind == PieceKind::contact ? reversed(a, b) : faces_across(a, b));
      });
      if (other == pieces_.end())
        throw std::logic_error("section: a face has no opposite at " + printed(a.start, a.end));
      // The grid allows two sides of a slanted contact to differ by a rounding; from here on they are one.
      if (a.claim->kind == PieceKind::contact) {
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
                        piece.claim->kind,
                        piece.claim->index,
                        piece.claim->side,
                        piece.pair,
                        piece.beside,
                        {}});
    }
    return pieces;
  }

  const Spindle& spindle_;
  std::vector<FaceItem> items_;
  std::vector<Piece> pieces_;
};

}  // namespace

std::vector<BoundaryPiece> sort_pieces(const Spindle& spindle, std::vector<Piece> pieces) {
  return Sorter(spindle, std::move(pieces)).sort();
}

}  // namespace spindle_twin::fem_offline::section_detail
