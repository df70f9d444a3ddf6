#include <map>

#include "fem_offline/mesh/piece_track.hpp"
#include "fem_offline/model/exchange_terms.hpp"
#include "fem_offline/model/thermoelastic.hpp"
#include "fem_offline/sparse/cholesky.hpp"

namespace spindle_twin::fem_offline {

struct ElasticSolver::Impl {
  explicit Impl(ElasticBody&& given)
      : body{taken(given.stiffness_N_per_m), taken(given.thermal_load_N_per_K), std::move(given.reduced)},
        factor(body.stiffness_N_per_m, Solutions::few) {}
  ElasticBody body;
  CholeskyFactor factor;
};

ElasticSolver::ElasticSolver(ElasticBody&& body) : impl_(std::make_unique<Impl>(std::move(body))) {}

ElasticSolver::~ElasticSolver() = default;
ElasticSolver::ElasticSolver(ElasticSolver&&) noexcept = default;
ElasticSolver& ElasticSolver::operator=(ElasticSolver&&) noexcept = default;

const ElasticBody& ElasticSolver::body() const { return impl_->body; }

Eigen::MatrixXd ElasticSolver::solve(const Eigen::MatrixXd& loads_N) const { return impl_->factor.solve(loads_N); }

Eigen::VectorXd ElasticSolver::displacements_m(const Eigen::VectorXd& rises_K) const {
  const ElasticBody& body = impl_->body;
  const Eigen::VectorXd solution = solve(body.thermal_load_N_per_K * rises_K);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(body.reduced.size()));
  for (std::size_t i = 0; i < body.reduced.size(); ++i) {
    if (body.reduced[i] >= 0) all[static_cast<Eigen::Index>(i)] = solution[body.reduced[i]];
  }
  return all;
}

namespace {

/// Sum of the displacements that an output takes, as weights on the reduced unknowns.
class OutputWeights {
 public:
  OutputWeights(const ElasticBody& body, Direction direction)
      : body_(&body),
        component_(direction == Direction::radial ? 0 : 1),
        weights_(Eigen::VectorXd::Zero(body.stiffness_N_per_m.rows())) {}
  void add(double weight, const Trace& trace) {
    total_ += weight;
    for (std::size_t i = 0; i < trace.dofs.size(); ++i) {
      const int unknown = body_->reduced[2 * trace.dofs[i] + component_];
      if (unknown >= 0) weights_[unknown] += weight * trace.values[i];
    }
  }
  double total() const { return total_; }
  Eigen::VectorXd mean() const { return weights_ / total_; }

 private:
  const ElasticBody* body_;
  int component_;
  Eigen::VectorXd weights_;
  double total_ = 0.0;
};

/// Normals on the nodes of a contact. Pieces in one line or around a curve share a node's normal; those that meet at a
/// corner both count there.
class NodeNormals {
 public:
  void add(int dof, const Eigen::Vector2d& normal) {
    for (Eigen::Vector2d& known : of_[dof]) {
      if (known.dot(normal) < corner_cosine) continue;
      known = (known + normal).normalized();
      return;
    }
    of_[dof].push_back(normal);
  }
  /// ½ of the normals, 2·places long.
  void add_half_to(Eigen::VectorXd& field) const {
    for (const auto& [dof, normals] : of_) {
      for (const Eigen::Vector2d& normal : normals) field.segment<2>(2 * dof) += 0.5 * normal;
    }
  }

 private:
  static constexpr double corner_cosine = 0.7;
  std::map<int, std::vector<Eigen::Vector2d>> of_;
};

double area_of(const SurfaceRules& rules, std::size_t contact) {
  double area_m2 = 0.0;
  for (const SurfacePair& pair : rules.pairs) {
    if (pair.kind != PieceKind::contact || pair.index != contact) continue;
    for (const PairedPoint& point : pair.points) area_m2 += point.weight_m2;
  }
  return area_m2;
}

Eigen::VectorXd normals_of(const Section& section, const SurfaceRules& rules, const std::vector<DofPlace>& places,
                           std::size_t contact) {
  NodeNormals normals[2];
  for (std::size_t p = 0; p < section.pieces.size(); ++p) {
    const BoundaryPiece& piece = section.pieces[p];
    if (piece.kind != PieceKind::contact || piece.index != contact) continue;
    const PieceTrack track(piece);
    for (const SurfacePoint& point : rules.pieces[p]) {
      for (const int dof : point.trace.dofs) {
        const Point normal = track.outward({places[dof].r_m, places[dof].z_m});
        normals[piece.side].add(dof, {normal.r_m, normal.z_m});
      }
    }
  }
  Eigen::VectorXd field = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(places.size()));
  for (const NodeNormals& of_side : normals) of_side.add_half_to(field);
  return field;
}

double assembly_pressure_Pa(const Spindle& spindle, const Contact& contact) {
  double pressure_Pa = contact.preload_pressure_Pa.value_or(0.0);
  if (contact.fit) {
    pressure_Pa += joint_fit(*contact.fit, spindle.materials[spindle.parts[contact.part_a].material],
                             spindle.materials[spindle.parts[contact.part_b].material])
                       .assembly_pressure_Pa;
  }
  return pressure_Pa;
}

}  // namespace

std::vector<FeDeformation> deformation_rows(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                                            const Discretisation<2>& discretisation, const ElasticSolver& solver) {
  const ElasticBody& body = solver.body();
  Eigen::MatrixXd loads(body.stiffness_N_per_m.rows(), static_cast<Eigen::Index>(spindle.deformations.size()));
  Eigen::Index column = 0;
  for (const DeformationOutput& output : spindle.deformations) {
    OutputWeights weights(body, output.direction);
    if (output.at) weights.add(1.0, trace_at(discretisation, static_cast<int>(output.part), *output.at));
    for (std::size_t p = 0; p < section.pieces.size() && !output.at; ++p) {
      if (section.pieces[p].part != output.part || !lies_in(section.pieces[p], output.face)) continue;
      for (const SurfacePoint& point : rules.pieces[p]) weights.add(point.weight_m2, point.trace);
    }
    if (weights.total() <= 0.0) {
      throw rom::InputError(output.where, output.name,
                            "the face lies on no side of part '" + spindle.parts[output.part].name + "'");
    }
    loads.col(column++) = output.sign * weights.mean();
  }
  const Eigen::MatrixXd adjoints = solver.solve(loads);
  std::vector<FeDeformation> rows;
  for (const DeformationOutput& output : spindle.deformations) {
    rows.push_back(
        {output.name, body.thermal_load_N_per_K.transpose() * adjoints.col(static_cast<Eigen::Index>(rows.size()))});
    if (output.minus) rows.back().row_m_per_K -= rows[*output.minus].row_m_per_K;
  }
  return rows;
}

std::vector<ContactForces> contact_forces(const Spindle& spindle, const Section& section, const SurfaceRules& rules,
                                          const std::vector<DofPlace>& places, const ElasticTerms& terms) {
  std::vector<ContactForces> forces;
  for (const ContactPressureOutput& output : spindle.contact_pressures) {
    const Eigen::VectorXd normals = normals_of(section, rules, places, output.contact);
    forces.push_back({terms.stiffness_N_per_m * normals, terms.thermal_load_N_per_K.transpose() * normals});
  }
  return forces;
}

std::vector<FeContactPressure> contact_pressure_rows(const Spindle& spindle, const SurfaceRules& rules,
                                                     const std::vector<ContactForces>& forces,
                                                     const ElasticSolver& solver) {
  const ElasticBody& body = solver.body();
  std::vector<FeContactPressure> rows;
  // One after the other: on the finest meshes all at once would be the largest matrices of a build.
  for (const ContactPressureOutput& output : spindle.contact_pressures) {
    const ContactForces& of_contact = forces[rows.size()];
    Eigen::VectorXd reduced = Eigen::VectorXd::Zero(body.stiffness_N_per_m.rows());
    for (std::size_t i = 0; i < body.reduced.size(); ++i) {
      if (body.reduced[i] >= 0) reduced[body.reduced[i]] += of_contact.stiffness_N_per_m[static_cast<Eigen::Index>(i)];
    }
    const Eigen::VectorXd adjoint = solver.solve(reduced);
    const Eigen::VectorXd row =
        (of_contact.load_N_per_K - body.thermal_load_N_per_K.transpose() * adjoint) / area_of(rules, output.contact);
    rows.push_back({output.name, assembly_pressure_Pa(spindle, spindle.contacts[output.contact]), row});
  }
  return rows;
}

}  // namespace spindle_twin::fem_offline
