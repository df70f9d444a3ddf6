#include "fem_offline/reduce/tolerance.hpp"

#include <algorithm>

#include "fem_offline/reduce/trajectory.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

using Kind = MissedOutput::Kind;

void furthest_first(std::vector<MissedOutput>& missed) {
  std::sort(missed.begin(), missed.end(),
            [](const MissedOutput& one, const MissedOutput& other) { return one.ratio() > other.ratio(); });
}

/// Items of one kind whose error [K, um] exceeds `wanted`.
template <typename Items>
void add_missed(std::vector<MissedOutput>& missed, Kind kind, const Items& items, const Eigen::VectorXd& errors,
                double wanted) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    const double error = errors[static_cast<Eigen::Index>(i)];
    if (error > wanted) missed.push_back({kind, items[i].name, error, wanted});
  }
}

/// The limit of all items of one kind together, if it exceeds `wanted`.
template <typename Items>
void add_missed_limit(std::vector<MissedOutput>& missed, Kind kind, const Items& items,
                      const std::vector<rom::OutputError>& errors, double limit, double wanted) {
  if (limit <= wanted || errors.empty()) return;
  const auto most = std::max_element(errors.begin(), errors.end(),
                                     [](const auto& one, const auto& other) { return one.limit < other.limit; });
  missed.push_back({kind, items[static_cast<std::size_t>(most - errors.begin())].name, limit, wanted});
}

}  // namespace

std::vector<MissedOutput> missed_outputs(const AffineModel& model, const Eigen::VectorXd& errors,
                                         const Tolerance& wanted) {
  const OutputLayout layout = output_layout(model);
  std::vector<MissedOutput> missed;
  add_missed(missed, Kind::key_point, model.key_points, errors.head(layout.key_points), wanted.key_points_K);
  add_missed(missed, Kind::deformation, model.deformations,
             rom::um_per_m * errors.segment(layout.deformations_at(), layout.deformations), wanted.deformations_um);
  add_missed(missed, Kind::part_maximum, model.parts, errors.segment(layout.maxima_at(), layout.parts),
             wanted.part_max_K);
  furthest_first(missed);
  return missed;
}

std::vector<MissedOutput> missed_limits(const AffineModel& model, const rom::Certificate& certificate,
                                        const Tolerance& wanted) {
  std::vector<MissedOutput> missed;
  add_missed_limit(missed, Kind::key_point, model.key_points, certificate.key_points_K, certificate.limit.key_points_K,
                   wanted.key_points_K);
  add_missed_limit(missed, Kind::part_maximum, model.parts, certificate.part_maxima_K, certificate.limit.part_max_K,
                   wanted.part_max_K);
  for (std::size_t i = 0; i < certificate.deformations_m.size(); ++i) {
    const double limit_um = certificate.deformations_m[i].limit * rom::um_per_m;
    if (limit_um > wanted.deformations_um) {
      missed.push_back({Kind::deformation, model.deformations[i].name, limit_um, wanted.deformations_um});
    }
  }
  furthest_first(missed);
  return missed;
}

}  // namespace spindle_twin::fem_offline
