#include "fem_offline/mesh/refine_quads.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

namespace spindle_twin::fem_offline {
namespace {

using Quad = std::array<std::size_t, 4>;

/// Of a side's length, from the place that elements get smaller towards.
constexpr double cut_share = 1.0 / 3.0;

Point between(const Point& a, const Point& b, double share) {
  return {a.r_m + share * (b.r_m - a.r_m), a.z_m + share * (b.z_m - a.z_m)};
}

/// Elements of a part one behind the other, as they were before.
void sort_by_part(SectionMesh& mesh) {
  std::vector<std::size_t> order(mesh.quads.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return mesh.part_of_quad[a] < mesh.part_of_quad[b]; });
  SectionMesh sorted;
  for (const std::size_t q : order) {
    sorted.quads.push_back(mesh.quads[q]);
    sorted.part_of_quad.push_back(mesh.part_of_quad[q]);
  }
  mesh.quads = std::move(sorted.quads);
  mesh.part_of_quad = std::move(sorted.part_of_quad);
}

/// The mesh while it is graded. Points of different parts at one place count as one there: what is cut in one part is
/// cut in all that touch it.
class Grading {
 public:
  explicit Grading(SectionMesh& mesh) : mesh_(mesh) {
    for (std::size_t point = 0; point < mesh.points.size(); ++point) register_point(point);
    for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
      for (const std::size_t point : mesh.quads[q]) around_[point].push_back(q);
    }
  }

  std::optional<std::size_t> place_at(const Point& at) const {
    const auto found = known_.find(place_key(at));
    return found == known_.end() ? std::nullopt : std::optional(found->second);
  }

  double longest_side_m(std::size_t place) const {
    double longest_m = 0.0;
    for_each_neighbour(place, [&](std::size_t point, std::size_t other) {
      longest_m = std::max(longest_m, distance_m(mesh_.points[point], mesh_.points[other]));
    });
    return longest_m;
  }

  /// Cuts the sides that lead away from the place and from what is close to it, measured by its longest side.
  void cut_around(std::size_t place) {
    const std::set<std::size_t> core = core_of(place);
    std::set<std::size_t> touched;
    for (const std::size_t member : core) {
      for (const std::size_t point : points_at_[member]) touched.insert(around_[point].begin(), around_[point].end());
    }
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> cuts;  // by the side, from its end in the core on
    const auto cut = [&](std::size_t from, std::size_t to) {
      const auto [entry, is_new] = cuts.try_emplace({from, to}, mesh_.points.size());
      if (is_new) add_point(between(mesh_.points[from], mesh_.points[to], cut_share));
      return entry->second;
    };
    for (const std::size_t q : touched) {
      const int inside = count_in(core, mesh_.quads[q]);
      if (inside == 4) continue;
      turn_to_core(core, mesh_.quads[q]);
      const auto [a, b, c, d] = mesh_.quads[q];
      const std::size_t part = mesh_.part_of_quad[q];
      for (const std::size_t point : {a, b, c, d}) std::erase(around_[point], q);
      if (inside == 2) {
        const std::size_t right = cut(b, c), left = cut(a, d);
        put_quad(q, {a, b, right, left}, part);
        put_quad(mesh_.quads.size(), {left, right, c, d}, part);
        continue;
      }
      const std::size_t right = cut(a, b), left = cut(a, d);
      // Bilinear: the same share of the way along both directions.
      const std::size_t middle = add_point(between(between(mesh_.points[a], mesh_.points[b], cut_share),
                                                   between(mesh_.points[d], mesh_.points[c], cut_share), cut_share));
      put_quad(q, {a, right, middle, left}, part);
      put_quad(mesh_.quads.size(), {right, b, c, middle}, part);
      put_quad(mesh_.quads.size(), {left, middle, c, d}, part);
    }
  }

 private:
  void register_point(std::size_t point) {
    const auto [entry, is_new] = known_.try_emplace(place_key(mesh_.points[point]), points_at_.size());
    if (is_new) points_at_.emplace_back();
    points_at_[entry->second].push_back(point);
    place_of_.push_back(entry->second);
    around_.emplace_back();
  }

  std::size_t add_point(const Point& point) {
    mesh_.points.push_back(point);
    register_point(mesh_.points.size() - 1);
    return mesh_.points.size() - 1;
  }

  void put_quad(std::size_t q, const Quad& quad, std::size_t part) {
    if (q == mesh_.quads.size()) {
      mesh_.quads.emplace_back();
      mesh_.part_of_quad.push_back(part);
    }
    mesh_.quads[q] = quad;
    for (const std::size_t point : quad) around_[point].push_back(q);
  }

  /// Both ends of every side at the place, its own first.
  template <typename Visit>
  void for_each_neighbour(std::size_t place, Visit visit) const {
    for (const std::size_t point : points_at_[place]) {
      for (const std::size_t q : around_[point]) {
        const Quad& quad = mesh_.quads[q];
        const auto k = static_cast<std::size_t>(std::find(quad.begin(), quad.end(), point) - quad.begin());
        visit(point, quad[(k + 1) % 4]);
        visit(point, quad[(k + 3) % 4]);
      }
    }
  }

  int count_in(const std::set<std::size_t>& core, const Quad& quad) const {
    return static_cast<int>(
        std::count_if(quad.begin(), quad.end(), [&](std::size_t point) { return core.contains(place_of_[point]); }));
  }

  /// The corner in the core first, or both of them.
  void turn_to_core(const std::set<std::size_t>& core, Quad& quad) const {
    const auto in_core = [&](std::size_t point) { return core.contains(place_of_[point]); };
    while (!in_core(quad[0]) || in_core(quad[3])) std::rotate(quad.begin(), quad.begin() + 1, quad.end());
  }

  /// The place and those that sides much shorter than its longest one lead to, so that no thin element is cut askew;
  /// filled up until every element has none, one, two neighbouring or all of its corners among them.
  std::set<std::size_t> core_of(std::size_t place) const {
    const double close_m = cut_share * longest_side_m(place);
    const Point centre = mesh_.points[points_at_[place].front()];
    std::set<std::size_t> core = {place};
    std::vector<std::size_t> open = {place};
    while (!open.empty()) {
      const std::size_t from = open.back();
      open.pop_back();
      for_each_neighbour(from, [&](std::size_t point, std::size_t other) {
        const Point& at = mesh_.points[other];
        const bool is_close =
            distance_m(centre, at) < close_m || distance_m(mesh_.points[point], at) < cut_share * close_m;
        if (is_close && core.insert(place_of_[other]).second) open.push_back(place_of_[other]);
      });
      for (const std::size_t point : points_at_[from]) {
        for (const std::size_t q : around_[point]) {
          const Quad& quad = mesh_.quads[q];
          const int inside = count_in(core, quad);
          const bool across = inside == 2 && core.contains(place_of_[quad[0]]) == core.contains(place_of_[quad[2]]);
          if (inside != 3 && !across) continue;
          for (const std::size_t corner : quad) {
            if (core.insert(place_of_[corner]).second) open.push_back(place_of_[corner]);
          }
        }
      }
    }
    // Filled up along its longest sides too, the core would leave the place as it is.
    bool is_too_large = false;
    for_each_neighbour(place, [&](std::size_t point, std::size_t other) {
      const bool is_long = distance_m(mesh_.points[point], mesh_.points[other]) >= close_m;
      is_too_large = is_too_large || (is_long && core.contains(place_of_[other]));
    });
    return is_too_large ? std::set<std::size_t>{place} : core;
  }

  SectionMesh& mesh_;
  std::map<PlaceKey, std::size_t> known_;            // places
  std::vector<std::vector<std::size_t>> points_at_;  // by place, one of each part
  std::vector<std::size_t> place_of_;                // by point
  std::vector<std::vector<std::size_t>> around_;     // numbers of quads, by point
};

}  // namespace

void halve_quads(SectionMesh& mesh) {
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
  const auto middle = [&](std::size_t a, std::size_t b) {
    const auto [entry, is_new] = middles.try_emplace(std::minmax(a, b), mesh.points.size());
    if (is_new) mesh.points.push_back(between(mesh.points[a], mesh.points[b], 0.5));
    return entry->second;
  };
  std::vector<Quad> quads;
  std::vector<std::size_t> parts;
  for (std::size_t q = 0; q < mesh.quads.size(); ++q) {
    const Quad& quad = mesh.quads[q];
    Quad sides{};
    for (std::size_t k = 0; k < 4; ++k) sides[k] = middle(quad[k], quad[(k + 1) % 4]);
    const std::size_t centre = mesh.points.size();
    mesh.points.push_back(between(mesh.points[sides[0]], mesh.points[sides[2]], 0.5));
    for (std::size_t k = 0; k < 4; ++k) {
      quads.push_back({quad[k], sides[k], centre, sides[(k + 3) % 4]});
      parts.push_back(mesh.part_of_quad[q]);
    }
  }
  mesh.quads = std::move(quads);
  mesh.part_of_quad = std::move(parts);
}

void grade_towards(const std::vector<Point>& places, double size_m, SectionMesh& mesh) {
  Grading grading(mesh);
  std::vector<std::size_t> numbers;
  for (const Point& at : places) {
    if (const auto place = grading.place_at(at)) numbers.push_back(*place);
  }
  while (true) {
    double longest_m = size_m;
    std::optional<std::size_t> coarsest;
    for (const std::size_t place : numbers) {
      const double side_m = grading.longest_side_m(place);
      if (side_m <= longest_m) continue;
      longest_m = side_m;
      coarsest = place;
    }
    if (!coarsest) break;
    grading.cut_around(*coarsest);
  }
  sort_by_part(mesh);
}

}  // namespace spindle_twin::fem_offline
