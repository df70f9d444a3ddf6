#include "fem_offline/model/thermoelastic.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "fem_offline/mesh/section_mesh.hpp"
#include "fem_offline/model/thermoelastic_supports.hpp"
#include "fem_offline/model/union_find.hpp"

namespace spindle_twin::fem_offline {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;
using PlaceKey = std::pair<long, long>;

PlaceKey key_of(const DofPlace& place) {
  return {std::lround(place.r_m / same_place_m), std::lround(place.z_m / same_place_m)};
}

std::map<PlaceKey, int> places_on(const SurfacePair& pair, Trace PairedPoint::*side,
                                  const std::vector<DofPlace>& places) {
  std::map<PlaceKey, int> found;
  for (const PairedPoint& point : pair.points) {
    for (const int dof : (point.*side).dofs) found[key_of(places[dof])] = dof;
  }
  return found;
}

/// Joins the unknowns of both sides if every place has its opposite; false if the meshes do not match.
bool join_matching(const SurfacePair& pair, const std::vector<DofPlace>& places, UnionFind& groups) {
  const auto side_a = places_on(pair, &PairedPoint::a, places);
  const auto side_b = places_on(pair, &PairedPoint::b, places);
  const auto same_key = [](const auto& a, const auto& b) { return a.first == b.first; };
  if (!std::equal(side_a.begin(), side_a.end(), side_b.begin(), side_b.end(), same_key)) return false;
  for (auto a = side_a.begin(), b = side_b.begin(); a != side_a.end(); ++a, ++b) {
    for (int c = 0; c < 2; ++c) groups.join(2 * a->second + c, 2 * b->second + c);
  }
  return true;
}

/// stiffness · (Σ valuesᵢ uᵢ)² for one component.
void add_square(double stiffness, int component, const std::vector<int>& dofs, const std::vector<double>& values,
                Triplets& triplets) {
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    for (std::size_t j = 0; j < dofs.size(); ++j) {
      triplets.emplace_back(2 * dofs[i] + component, 2 * dofs[j] + component, stiffness * values[i] * values[j]);
    }
  }
}

void add_tie(const SurfacePair& pair, double stiffness_N_per_m3, Triplets& triplets) {
  for (const PairedPoint& point : pair.points) {
    std::vector<int> dofs = point.a.dofs;
    std::vector<double> jump = point.a.values;
    dofs.insert(dofs.end(), point.b.dofs.begin(), point.b.dofs.end());
    for (const double value : point.b.values) jump.push_back(-value);
    for (int c = 0; c < 2; ++c) add_square(stiffness_N_per_m3 * point.weight_m2, c, dofs, jump, triplets);
  }
}

/// Ties what touches: joined unknowns where the meshes match, surface springs elsewhere.
void bond(const Spindle& spindle, const SurfaceRules& rules, const std::vector<DofPlace>& places, double tie_factor,
          UnionFind& groups, Triplets& springs) {
  for (const SurfacePair& pair : rules.pairs) {
    if (pair.kind != PieceKind::contact || join_matching(pair, places, groups)) continue;
    const double modulus_Pa = std::max(spindle.materials[spindle.parts[pair.part_a].material].youngs_modulus_Pa,
                                       spindle.materials[spindle.parts[pair.part_b].material].youngs_modulus_Pa);
    add_tie(pair, tie_factor * modulus_Pa / pair.least_face_m, springs);
  }
}

void add_springs(const Support& support, const SupportPlaces& held, Triplets& springs) {
  double area_m2 = 0.0;
  for (const SurfacePoint& point : held.points) area_m2 += point.weight_m2;
  for (const SurfacePoint& point : held.points) {
    const double share = point.weight_m2 / area_m2;
    if (support.hold_r == Hold::spring) {
      add_square(share * support.stiffness_r_N_per_m, 0, point.trace.dofs, point.trace.values, springs);
    }
    if (support.hold_z == Hold::spring) {
      add_square(share * support.stiffness_z_N_per_m, 1, point.trace.dofs, point.trace.values, springs);
    }
  }
}

/// Adds the supports to joined unknowns and springs; returns the leaders of the unknowns that are zero.
std::set<int> support(const Spindle& spindle, const std::vector<SupportPlaces>& held,
                      const std::vector<DofPlace>& places, UnionFind& groups, Triplets& springs) {
  for (std::size_t s = 0; s < held.size(); ++s) {
    add_springs(spindle.supports[s], held[s], springs);
    if (spindle.supports[s].hold_z != Hold::plane) continue;
    for (const int place : held[s].places) groups.join(2 * place + 1, 2 * held[s].places[0] + 1);
  }
  std::set<int> zero;
  for (std::size_t s = 0; s < held.size(); ++s) {
    for (const int place : held[s].places) {
      if (spindle.supports[s].hold_r == Hold::fixed) zero.insert(groups.leader(2 * place));
      if (spindle.supports[s].hold_z == Hold::fixed) zero.insert(groups.leader(2 * place + 1));
    }
  }
  if (spindle.geometry == Geometry::planar) return zero;
  for (int place = 0; place < static_cast<int>(places.size()); ++place) {
    if (places[place].r_m < same_place_m) zero.insert(groups.leader(2 * place));
  }
  return zero;
}

/// Sums over joined unknowns, lower triangle, `count` of them; what is held at zero is left out.
SparseMatrix joined_stiffness(const SparseMatrix& stiffness_N_per_m, const Triplets& springs,
                              const std::vector<int>& reduced, int count) {
  Triplets entries;
  entries.reserve(static_cast<std::size_t>(stiffness_N_per_m.nonZeros()) / 2 + springs.size());
  const auto add = [&](int row, int column, double value) {
    const int i = reduced[row], j = reduced[column];
    if (j >= 0 && i >= j) entries.emplace_back(i, j, value);
  };
  for (int column = 0; column < stiffness_N_per_m.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(stiffness_N_per_m, column); it; ++it) {
      add(static_cast<int>(it.row()), column, it.value());
    }
  }
  for (const auto& spring : springs) add(spring.row(), spring.col(), spring.value());
  SparseMatrix joined(count, count);
  joined.setFromTriplets(entries.begin(), entries.end());
  return joined;
}

SparseMatrix joined_load(const SparseMatrix& thermal_load_N_per_K, const std::vector<int>& reduced, int count) {
  Triplets entries;
  entries.reserve(static_cast<std::size_t>(thermal_load_N_per_K.nonZeros()));
  for (int column = 0; column < thermal_load_N_per_K.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(thermal_load_N_per_K, column); it; ++it) {
      const int i = reduced[it.row()];
      if (i >= 0) entries.emplace_back(i, column, it.value());
    }
  }
  SparseMatrix joined(count, thermal_load_N_per_K.cols());
  joined.setFromTriplets(entries.begin(), entries.end());
  return joined;
}

}  // namespace

ElasticBody bond_and_support(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                             const std::vector<DofPlace>& places, const ElasticTerms& terms, double tie_factor) {
  std::vector<SupportPlaces> held;
  for (const Support& support : spindle.supports) held.push_back(places_of(support, section, rules, places));
  check_held(spindle, rules, places, held);
  UnionFind groups(2 * places.size());
  Triplets springs;
  bond(spindle, rules, places, tie_factor, groups, springs);
  const std::set<int> zero = support(spindle, held, places, groups, springs);

  std::vector<int> reduced(2 * places.size(), -1);
  int count = 0;
  for (int unknown = 0; unknown < static_cast<int>(reduced.size()); ++unknown) {
    if (groups.leader(unknown) == unknown && !zero.contains(unknown)) reduced[unknown] = count++;
  }
  for (int unknown = 0; unknown < static_cast<int>(reduced.size()); ++unknown) {
    reduced[unknown] = reduced[groups.leader(unknown)];
  }

  return {joined_stiffness(terms.stiffness_N_per_m, springs, reduced, count),
          joined_load(terms.thermal_load_N_per_K, reduced, count), reduced};
}

}  // namespace spindle_twin::fem_offline
