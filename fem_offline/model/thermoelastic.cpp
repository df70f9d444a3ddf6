#include "fem_offline/model/thermoelastic.hpp"

#include <omp.h>

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "fem_offline/mesh/section_mesh.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Union-find.
class Groups {
 public:
  explicit Groups(std::size_t count) : leader_(count) { std::iota(leader_.begin(), leader_.end(), 0); }
  int leader(int member) {
    while (leader_[member] != member) member = leader_[member] = leader_[leader_[member]];
    return member;
  }
  void join(int a, int b) { leader_[leader(a)] = leader(b); }

 private:
  std::vector<int> leader_;
};

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

/// Joins the places of both sides if every one has its opposite; false if the meshes do not match.
bool join_matching(const SurfacePair& pair, const std::vector<DofPlace>& places, Groups& groups) {
  const auto side_a = places_on(pair, &PairedPoint::a, places);
  const auto side_b = places_on(pair, &PairedPoint::b, places);
  const auto same_key = [](const auto& a, const auto& b) { return a.first == b.first; };
  if (!std::equal(side_a.begin(), side_a.end(), side_b.begin(), side_b.end(), same_key)) return false;
  for (auto a = side_a.begin(), b = side_b.begin(); a != side_a.end(); ++a, ++b) groups.join(a->second, b->second);
  return true;
}

void add_tie(const SurfacePair& pair, double stiffness_N_per_m3, std::vector<Eigen::Triplet<double>>& triplets) {
  for (const PairedPoint& point : pair.points) {
    std::vector<int> dofs = point.a.dofs;
    std::vector<double> jump = point.a.values;
    dofs.insert(dofs.end(), point.b.dofs.begin(), point.b.dofs.end());
    for (const double value : point.b.values) jump.push_back(-value);
    for (std::size_t i = 0; i < dofs.size(); ++i) {
      for (std::size_t j = 0; j < dofs.size(); ++j) {
        const double entry = stiffness_N_per_m3 * point.weight_m2 * jump[i] * jump[j];
        for (int c = 0; c < 2; ++c) triplets.emplace_back(2 * dofs[i] + c, 2 * dofs[j] + c, entry);
      }
    }
  }
}

/// Leaders of the groups of places that a support holds along z.
std::set<int> held_places(const Spindle& spindle, const Section& section, const SurfaceRules& rules, Groups& groups) {
  std::set<int> held;
  for (const Support& support : spindle.supports) {
    for (std::size_t p = 0; p < section.pieces.size(); ++p) {
      if (section.pieces[p].part != support.part || !lies_in(section.pieces[p], support.face)) continue;
      for (const SurfacePoint& point : rules.pieces[p]) {
        for (const int dof : point.trace.dofs) held.insert(groups.leader(dof));
      }
    }
  }
  return held;
}

void check_held(const Spindle& spindle, const SurfaceRules& rules) {
  Groups bonded(spindle.parts.size());
  for (const SurfacePair& pair : rules.pairs) {
    if (pair.kind == PieceKind::contact) bonded.join(static_cast<int>(pair.part_a), static_cast<int>(pair.part_b));
  }
  std::set<int> held;
  for (const Support& support : spindle.supports) held.insert(bonded.leader(static_cast<int>(support.part)));
  for (std::size_t part = 0; part < spindle.parts.size(); ++part) {
    if (held.contains(bonded.leader(static_cast<int>(part)))) continue;
    throw rom::InputError(spindle.parts[part].where, spindle.parts[part].name,
                          "free to move along z: no support holds it, neither itself nor through parts it touches; "
                          "deformation outputs need one");
  }
}

}  // namespace

ElasticBody bond_and_support(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                             const std::vector<DofPlace>& places, const SparseMatrix& stiffness,
                             const SparseMatrix& load, double tie_factor) {
  check_held(spindle, rules);
  Groups groups(places.size());
  std::vector<Eigen::Triplet<double>> ties;
  for (const SurfacePair& pair : rules.pairs) {
    if (pair.kind != PieceKind::contact || join_matching(pair, places, groups)) continue;
    const double modulus_Pa = std::max(spindle.materials[spindle.parts[pair.part_a].material].youngs_modulus_Pa,
                                       spindle.materials[spindle.parts[pair.part_b].material].youngs_modulus_Pa);
    add_tie(pair, tie_factor * modulus_Pa / pair.least_face_m, ties);
  }
  const std::set<int> held = held_places(spindle, section, rules, groups);

  ElasticBody body;
  body.reduced.assign(2 * places.size(), -1);
  int count = 0;
  for (int place = 0; place < static_cast<int>(places.size()); ++place) {
    if (groups.leader(place) != place) continue;
    const bool on_axis = places[place].r_m < same_place_m;
    if (!on_axis) body.reduced[2 * place] = count++;
    if (!held.contains(place)) body.reduced[2 * place + 1] = count++;
  }
  for (int place = 0; place < static_cast<int>(places.size()); ++place) {
    for (int c = 0; c < 2; ++c) body.reduced[2 * place + c] = body.reduced[2 * groups.leader(place) + c];
  }

  std::vector<Eigen::Triplet<double>> entries, load_entries;
  const auto add = [&](int row, int column, double value) {
    const int i = body.reduced[row], j = body.reduced[column];
    if (i >= 0 && j >= 0) entries.emplace_back(i, j, value);
  };
  for (int column = 0; column < stiffness.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(stiffness, column); it; ++it) {
      add(static_cast<int>(it.row()), column, it.value());
    }
  }
  for (const auto& tie : ties) add(tie.row(), tie.col(), tie.value());
  for (int column = 0; column < load.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(load, column); it; ++it) {
      const int i = body.reduced[it.row()];
      if (i >= 0) load_entries.emplace_back(i, column, it.value());
    }
  }
  body.stiffness_N_per_m.resize(count, count);
  body.stiffness_N_per_m.setFromTriplets(entries.begin(), entries.end());
  body.thermal_load_N_per_K.resize(count, load.cols());
  body.thermal_load_N_per_K.setFromTriplets(load_entries.begin(), load_entries.end());
  return body;
}

namespace {

using Factor = Eigen::CholmodSupernodalLLT<SparseMatrix, Eigen::Lower>;

void factorise(Factor& factor, const ElasticBody& body) {
  omp_set_max_active_levels(0);  // CHOLMOD's own threads wait in loops; see solve/cholesky.cpp
  factor.compute(body.stiffness_N_per_m);
  if (factor.info() != Eigen::Success) throw std::runtime_error("the elastic stiffness is not positive definite");
}

}  // namespace

std::vector<FeDeformation> deformation_rows(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                                            const ElasticBody& body) {
  if (spindle.deformations.empty()) return {};
  Factor factor;
  factorise(factor, body);
  std::vector<FeDeformation> rows;
  for (const DeformationOutput& output : spindle.deformations) {
    const int component = output.direction == Direction::radial ? 0 : 1;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(body.stiffness_N_per_m.rows());
    double area_m2 = 0.0;
    for (std::size_t p = 0; p < section.pieces.size(); ++p) {
      if (section.pieces[p].part != output.part || !lies_in(section.pieces[p], output.face)) continue;
      for (const SurfacePoint& point : rules.pieces[p]) {
        area_m2 += point.weight_m2;
        for (std::size_t i = 0; i < point.trace.dofs.size(); ++i) {
          const int unknown = body.reduced[2 * point.trace.dofs[i] + component];
          if (unknown >= 0) mean[unknown] += point.weight_m2 * point.trace.values[i];
        }
      }
    }
    if (area_m2 <= 0.0) {
      throw rom::InputError(output.where, output.name,
                            "the face lies on no side of part '" + spindle.parts[output.part].name + "'");
    }
    mean *= output.sign / area_m2;
    const Eigen::VectorXd adjoint = factor.solve(mean);
    rows.push_back({output.name, body.thermal_load_N_per_K.transpose() * adjoint});
  }
  return rows;
}

Eigen::VectorXd displacements(const ElasticBody& body, const Eigen::VectorXd& rises_K) {
  Factor factor;
  factorise(factor, body);
  const Eigen::VectorXd load_N = body.thermal_load_N_per_K * rises_K;
  const Eigen::VectorXd solution = factor.solve(load_N);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(body.reduced.size()));
  for (std::size_t i = 0; i < body.reduced.size(); ++i) {
    if (body.reduced[i] >= 0) all[static_cast<Eigen::Index>(i)] = solution[body.reduced[i]];
  }
  return all;
}

}  // namespace spindle_twin::fem_offline
