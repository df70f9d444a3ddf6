#include "fem_offline/model/thermoelastic_supports.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "fem_offline/mesh/section_mesh.hpp"
#include "fem_offline/model/union_find.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Below this share of what one held point does, a rigid motion counts as free.
constexpr double least_hold = 1e-12;

/// Displacements (r, z) of a place in the rigid motions along r, along z and turning about the middle of the spindle.
struct RigidMotions {
  Eigen::Vector3d r, z;
};

/// Coordinates centred and scaled, so that all three motions are of one size.
class Frame {
 public:
  explicit Frame(const std::vector<DofPlace>& places) {
    double r0 = places[0].r_m, r1 = r0, z0 = places[0].z_m, z1 = z0;
    for (const DofPlace& place : places) {
      r0 = std::min(r0, place.r_m);
      r1 = std::max(r1, place.r_m);
      z0 = std::min(z0, place.z_m);
      z1 = std::max(z1, place.z_m);
    }
    r_m_ = 0.5 * (r0 + r1);
    z_m_ = 0.5 * (z0 + z1);
    size_m_ = std::max(r1 - r0, z1 - z0);
  }
  RigidMotions at(const DofPlace& place) const {
    return {{1.0, 0.0, -(place.z_m - z_m_) / size_m_}, {0.0, 1.0, (place.r_m - r_m_) / size_m_}};
  }

 private:
  double r_m_, z_m_, size_m_;
};

/// Σ cᵀc over what the support forbids: zero for the motions that it leaves free.
Eigen::Matrix3d hold_of(const Support& support, const SupportPlaces& held, const std::vector<DofPlace>& places,
                        const Frame& frame) {
  Eigen::Matrix3d hold = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const int place : held.places) mean += frame.at(places[place]).z / static_cast<double>(held.places.size());
  for (const int place : held.places) {
    const RigidMotions motions = frame.at(places[place]);
    if (support.hold_r != Hold::free) hold += motions.r * motions.r.transpose();
    if (support.hold_z == Hold::free) continue;
    const Eigen::Vector3d kept = support.hold_z == Hold::plane ? Eigen::Vector3d(motions.z - mean) : motions.z;
    hold += kept * kept.transpose();
  }
  return hold;
}

}  // namespace

SupportPlaces places_of(const Support& support, const Section& section, const SurfaceRules& rules,
                        const std::vector<DofPlace>& places) {
  SupportPlaces found;
  if (support.is_point()) {
    for (int place = 0; place < static_cast<int>(places.size()); ++place) {
      if (places[place].part != static_cast<int>(support.part)) continue;
      if (std::abs(places[place].r_m - support.face.r0_m) > same_place_m) continue;
      if (std::abs(places[place].z_m - support.face.z0_m) > same_place_m) continue;
      found.places.push_back(place);
      found.points.push_back({{support.face.r0_m, support.face.z0_m}, 1.0, {{place}, {1.0}}});
    }
    return found;
  }
  std::set<int> unique;
  for (std::size_t p = 0; p < section.pieces.size(); ++p) {
    if (section.pieces[p].part != support.part || !lies_in(section.pieces[p], support.face)) continue;
    for (const SurfacePoint& point : rules.pieces[p]) {
      unique.insert(point.trace.dofs.begin(), point.trace.dofs.end());
      found.points.push_back(point);
    }
  }
  found.places.assign(unique.begin(), unique.end());
  return found;
}

void check_held(const Spindle& spindle, const SurfaceRules& rules, const std::vector<DofPlace>& places,
                const std::vector<SupportPlaces>& held) {
  UnionFind bonded(spindle.parts.size());
  for (const SurfacePair& pair : rules.pairs) {
    if (pair.kind == PieceKind::contact) bonded.join(static_cast<int>(pair.part_a), static_cast<int>(pair.part_b));
  }
  const Frame frame(places);
  std::vector<Eigen::Matrix3d> hold(spindle.parts.size(), Eigen::Matrix3d::Zero());
  for (std::size_t s = 0; s < spindle.supports.size(); ++s) {
    hold[bonded.leader(static_cast<int>(spindle.supports[s].part))] +=
        hold_of(spindle.supports[s], held[s], places, frame);
  }
  const bool planar = spindle.geometry == Geometry::planar;
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    const Eigen::Matrix3d& group = hold[bonded.leader(static_cast<int>(part))];
    // A body of revolution cannot move along r or turn without strain.
    const double least =
        planar ? Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(group, Eigen::EigenvaluesOnly).eigenvalues()[0]
               : group(1, 1);
    if (least > least_hold) continue;
    throw rom::InputError(spindle.parts[part].where, spindle.parts[part].name,
                          std::string(planar ? "free to move as a rigid body" : "free to move along z") +
                              ": no support holds it, neither itself nor through parts it touches; deformations, "
                              "contact pressures and stresses need one");
  }
}

}  // namespace spindle_twin::fem_offline
