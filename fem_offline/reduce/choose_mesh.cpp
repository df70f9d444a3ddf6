#include "fem_offline/reduce/choose_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "fem_offline/mesh/element_sizes.hpp"
#include "fem_offline/model/build_model.hpp"
#include "fem_offline/reduce/trajectory.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double corner_step = 1.0 / 3.0, part_step = 0.6;
constexpr double corner_share_of_limit = 1.0 / 200.0;
/// Elements are not made smaller than the description may say.
constexpr double least_size_m = 1e-5;
/// Parts that moved nothing by this share of what is wanted are not asked again.
constexpr double least_share = 0.05;

struct Answer {
  std::size_t unknowns = 0;
  Eigen::VectorXd deformations_m;
};

Answer answer_of(const Spindle& spindle, const Section& section) {
  const FeModel fe(spindle, section);
  const AffineModel& model = fe.affine();
  const OutputLayout layout = output_layout(model);
  return {model.places.size(), steady_outputs(model).segment(layout.deformations_at(), layout.deformations)};
}

double largest_change_m(const Answer& a, const Answer& b) {
  return (a.deformations_m - b.deformations_m).cwiseAbs().maxCoeff();
}

/// What may be made finer: one part, or the corners of all.
using Place = std::optional<std::size_t>;

/// To two digits of a millimetre, so that what is printed is what was tried.
double rounded_m(double size_m) {
  const double digit_m = std::pow(10.0, std::floor(std::log10(size_m)) - 1.0);
  return std::floor(size_m / digit_m) * digit_m;
}

/// Empty where the elements are as small as may be.
std::optional<Spindle> refined(Spindle spindle, const Place& place) {
  std::optional<double>& size_m = place ? spindle.parts[*place].element_size_m : spindle.mesh.corner_size_m;
  size_m = rounded_m(place ? part_step * size_of(spindle, *place)
                           : corner_step * spindle.mesh.corner_size_m.value_or(spindle.mesh.element_size_m));
  return *size_m < least_size_m ? std::nullopt : std::optional(std::move(spindle));
}

struct Candidate {
  Place place;
  Spindle spindle;
  Answer answer;
  double step_m = 0.0;
};

class Search {
 public:
  Search(const Spindle& spindle, double wanted_m, const Progress& progress)
      : section_(build_section(spindle)),
        wanted_m_(wanted_m),
        progress_(progress),
        spindle_(spindle),
        answer_(answer_of(spindle, section_)) {
    Spindle fine = spindle;
    fine.mesh.degree += 1;
    fine.mesh.corner_size_m = corner_share_of_limit * spindle.mesh.element_size_m;
    limit_ = answer_of(fine, section_);
    places_.push_back(std::nullopt);
    for (std::size_t part = 0; part < spindle.parts.size(); ++part) places_.emplace_back(part);
  }

  const Spindle& spindle() const { return spindle_; }
  TriedMesh tried(const std::string& finer, double largest_step_m) const {
    return {finer, answer_.unknowns, largest_change_m(answer_, limit_), largest_step_m};
  }

  /// All that may be made finer next; the places that moved nothing are left out from now on.
  std::vector<Candidate> candidates() {
    std::vector<Candidate> found;
    std::vector<Place> left;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      if (progress_) progress_("refinements", static_cast<double>(i) / static_cast<double>(places_.size()));
      std::optional<Spindle> finer = refined(spindle_, places_[i]);
      if (!finer) continue;
      Answer answer = answer_of(*finer, section_);
      const double step_m = largest_change_m(answer, answer_);
      if (step_m < least_share * wanted_m_) continue;
      left.push_back(places_[i]);
      found.push_back({places_[i], std::move(*finer), std::move(answer), step_m});
    }
    places_ = std::move(left);
    return found;
  }

  /// By how much deformations move for every unknown more.
  double worth(const Candidate& candidate) const {
    const std::size_t more = candidate.answer.unknowns - std::min(candidate.answer.unknowns, answer_.unknowns);
    return candidate.step_m / static_cast<double>(more + 1);
  }

  void take(Candidate candidate) {
    spindle_ = std::move(candidate.spindle);
    answer_ = std::move(candidate.answer);
  }

 private:
  Section section_;
  double wanted_m_;
  const Progress& progress_;
  Spindle spindle_;
  Answer answer_, limit_;
  std::vector<Place> places_;
};

}  // namespace

MeshChoice choose_mesh(const Spindle& spindle, double wanted_m, double most_times, const Progress& progress) {
  if (spindle.deformations.empty()) {
    throw rom::InputError({spindle.file, 0}, "deformation",
                          "a mesh is chosen for deformation outputs, and there is none");
  }
  Search search(spindle, wanted_m, progress);
  MeshChoice choice;
  std::string finer;
  while (true) {
    std::vector<Candidate> candidates = search.candidates();
    double largest_step_m = 0.0;
    for (const Candidate& candidate : candidates) largest_step_m = std::max(largest_step_m, candidate.step_m);
    choice.meshes.push_back(search.tried(finer, largest_step_m));
    const TriedMesh& now = choice.meshes.back();
    choice.reached = now.error_m < wanted_m && now.largest_step_m < wanted_m;
    const double most = most_times * static_cast<double>(choice.meshes.front().unknowns);
    std::erase_if(candidates, [&](const Candidate& candidate) {
      return static_cast<double>(candidate.answer.unknowns) > most || candidate.answer.unknowns <= now.unknowns;
    });
    if (choice.reached || candidates.empty()) break;
    auto best = std::max_element(candidates.begin(), candidates.end(), [&](const Candidate& a, const Candidate& b) {
      return search.worth(a) < search.worth(b);
    });
    finer = best->place ? spindle.parts[*best->place].name : "corners";
    search.take(std::move(*best));
  }
  choice.spindle = search.spindle();
  return choice;
}

}  // namespace spindle_twin::fem_offline
