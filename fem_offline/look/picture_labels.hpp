#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fem_offline/look/picture_canvas.hpp"

namespace spindle_twin::fem_offline {

/// From a label to what it belongs to.
struct Leader {
  Pixel from;
  Pixel to;
};

/// A mark without size.
inline PixelBox box_of(const Pixel& point) { return {point.x, point.y, point.x, point.y}; }

/// A label that has its place.
struct Label {
  PixelBox mark;  ///< what it belongs to
  std::string words;
  TextStyle style;
  bool is_disc = false;            ///< a key point's letters
  bool is_on_mark = false;         ///< wants to stand on its mark, others beside it
  PixelBox box{};                  ///< what it covers
  std::optional<Leader> leader{};  ///< where it is not beside its mark
};

/// Labels that cover neither each other, nor other texts of the canvas, nor what is kept free. Each takes the free
/// place nearest to its mark, those on their mark first and then in the order in which they were added; the same labels
/// always get the same places.
class LabelBoard {
 public:
  /// No label leaves `bounds`.
  LabelBoard(Canvas& canvas, const PixelBox& bounds) : canvas_(&canvas), bounds_(bounds) {}

  void keep_free(const PixelBox& box) { kept_.push_back(box); }
  bool is_free(const PixelBox& box) const;

  /// Words beside their mark, with a line to it where that is not near.
  void add(const PixelBox& mark, const std::string& words, const TextStyle& style);
  /// Words on their point, beside it where another label stands there.
  void add_on(const Pixel& point, const std::string& words, const TextStyle& style);
  /// The same for the letter of a key point.
  void add_disc(const Pixel& point, const std::string& letter);

  /// Gives all labels that were added their places; a label for which nothing is free is left out. Before it, labels of
  /// one kind whose marks lie on each other become one, their words behind each other.
  void place();
  const std::vector<Label>& placed() const { return placed_; }

  /// Places what has no place yet, and draws all labels, leaders below the words.
  void draw();

 private:
  void queue(Label label);
  bool place_one(Label& label, bool with_clear_leader) const;
  bool try_at(Label& label, const Pixel& middle, bool with_clear_leader) const;
  bool is_clear(const Leader& leader) const;
  PixelBox box_around(const Pixel& middle, const Label& label) const;

  Canvas* canvas_;
  PixelBox bounds_;
  std::vector<PixelBox> kept_;
  std::vector<Label> waiting_;
  std::vector<Label> placed_;
};

/// Letters of key points on a disc that is as long as they are.
void draw_letter_disc(Canvas& canvas, const Pixel& at, const std::string& letters);

}  // namespace spindle_twin::fem_offline
