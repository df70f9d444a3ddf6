#include "fem_offline/model/build_model.hpp"

#include <malloc.h>

#include <algorithm>
#include <optional>
#include <stdexcept>

#include "fem_offline/description/model_places.hpp"
#include "fem_offline/model/discretisation.hpp"
#include "fem_offline/model/exchange_terms.hpp"
#include "fem_offline/model/field_error.hpp"
#include "fem_offline/model/imposed_temperature.hpp"
#include "fem_offline/model/source_terms.hpp"
#include "fem_offline/model/thermoelastic.hpp"
#include "fem_offline/model/thermoelastic_stress.hpp"
#include "fem_offline/model/volume_terms.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// What `given` holds, in a matrix with rows and columns for the air volumes, which come last.
SparseMatrix enlarged(SparseMatrix& given, int unknowns) {
  SparseMatrix matrix = taken(given);
  matrix.conservativeResize(unknowns, unknowns);
  return matrix;
}

Eigen::VectorXd enlarged(const Eigen::VectorXd& row, int unknowns) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(unknowns);
  result.head(row.size()) = row;
  return result;
}

/// Air volumes get an unknown of their own, the last ones; of each surrounding its place, -1 for environments. Throws
/// for air that no film exchanges heat with, which would have any temperature.
std::vector<int> add_air(const Spindle& spindle, AffineModel& model) {
  std::vector<int> air_unknown;
  for (std::size_t s = 0; s < spindle.surroundings.size(); ++s) {
    const Surrounding& surrounding = spindle.surroundings[s];
    const bool is_air = surrounding.kind == SurroundingKind::air;
    const bool is_used = std::any_of(spindle.films.begin(), spindle.films.end(),
                                     [s](const Film& film) { return film.surrounding == s; });
    if (is_air && !is_used) {
      throw rom::InputError(surrounding.where, "surrounding." + surrounding.name, "no film leads to this air volume");
    }
    air_unknown.push_back(is_air ? static_cast<int>(model.places.size()) : -1);
    if (!is_air) continue;
    model.air_names.push_back(surrounding.name);
    model.places.push_back({});
  }
  return air_unknown;
}

void fill_surroundings(const Spindle& spindle, rom::Boundaries& boundaries) {
  for (const Surrounding& surrounding : spindle.surroundings) {
    if (surrounding.kind == SurroundingKind::air) continue;
    boundaries.environments.push_back({surrounding.name, surrounding.kind == SurroundingKind::coolant
                                                             ? rom::EnvironmentKind::coolant
                                                             : rom::EnvironmentKind::ambient});
  }
  boundaries.operating = operating_state(spindle);
  boundaries.plausible = spindle.plausible;
  boundaries.reference_speed_rpm = spindle.operating.speed_rpm;
  boundaries.reference_temperature_K = spindle.operating.reference_temperature_K;
}

void fill_circuits(const Spindle& spindle, rom::Boundaries& boundaries) {
  for (const CoolantCircuit& given : spindle.circuits) {
    rom::CoolantCircuit circuit{given.name, environment_of(spindle, given.inlet), given.heat_capacity_J_per_kgK, {}};
    for (const std::size_t film : given.segments) {
      circuit.segments.push_back(static_cast<int>(conductance_of_film(spindle, film)));
    }
    boundaries.circuits.push_back(std::move(circuit));
  }
}

void fill_parts(const Spindle& spindle, const std::vector<Eigen::VectorXd>& function_volume_m3, AffineModel& model) {
  const auto unknowns = static_cast<int>(model.places.size());
  for (std::size_t p = 0; p < spindle.parts.size(); ++p) {
    FePart part{spindle.parts[p].name, {}, {}, spindle.parts[p].initial_K};
    part.mean_row = enlarged(Eigen::VectorXd(function_volume_m3[p] / function_volume_m3[p].sum()), unknowns);
    for (int i = 0; i < unknowns; ++i) {
      if (model.places[i].part == static_cast<int>(p)) part.dofs.push_back(i);
    }
    model.parts.push_back(std::move(part));
  }
}

void fill_key_points(const Spindle& spindle, const Discretisation<2>& discretisation, AffineModel& model) {
  for (const KeyPoint& point : spindle.key_points) {
    const int part = static_cast<int>(point.part);
    const Trace trace = trace_at(discretisation, part, point.at);
    Eigen::SparseVector<double> row(static_cast<Eigen::Index>(model.places.size()));
    for (std::size_t i = 0; i < trace.dofs.size(); ++i) row.coeffRef(trace.dofs[i]) += trace.values[i];
    model.key_points.push_back({point.name, part, point.at, row});
  }
}

bool asks_for_mechanics(const Spindle& spindle) {
  return !spindle.deformations.empty() || !spindle.contact_pressures.empty() || !spindle.stress_probes.empty() ||
         (spindle.imposed_temperature && !spindle.supports.empty());
}

}  // namespace

struct FeModel::Impl {
  Impl(const Spindle& spindle, const Section& section) : Impl(spindle, section, mesh_section(spindle, section)) {}

  Impl(const Spindle& spindle, const Section& section, const SectionMesh& mesh)
      : discretisation(mesh, spindle.mesh.degree, spindle.geometry),
        quality(mesh_quality(spindle, mesh)),
        described(spindle),
        outlined(section) {
    const SurfaceRules rules = make_surface_rules(discretisation, spindle, section);
    affine.spindle = spindle.name;
    affine.description_hash = spindle.hash;
    affine.places = discretisation.places;
    const auto fe_unknowns = static_cast<int>(affine.places.size());
    const std::vector<int> air_unknown = add_air(spindle, affine);
    fill_surroundings(spindle, affine.boundaries);
    const auto unknowns = static_cast<int>(affine.places.size());

    VolumeTerms volume = volume_terms<2>(discretisation, spindle);
    affine.capacity_J_per_K = enlarged(volume.capacity_J_per_K, unknowns);
    affine.conduction_W_per_K = enlarged(volume.conduction_W_per_K, unknowns);
    for (std::size_t i = 0; i < spindle.surroundings.size(); ++i) {
      const int air = air_unknown[i];
      if (air >= 0) affine.capacity_J_per_K.coeffRef(air, air) = spindle.surroundings[i].capacity_J_per_K;
    }
    affine.capacity_J_per_K.makeCompressed();

    ExchangeTerms exchange = exchange_terms(spindle, section, rules, unknowns, air_unknown);
    affine.conductance_terms_m2 = std::move(exchange.matrices_m2);
    affine.boundaries.conductances = std::move(exchange.conductances);
    affine.held = std::move(exchange.held);
    fill_circuits(spindle, affine.boundaries);
    SourceTerms sources = source_terms(spindle, section, rules, unknowns, volume.function_volume_m3);
    affine.boundaries.sources = std::move(sources.sources);
    affine.source_distribution = std::move(sources.distribution);

    fill_parts(spindle, volume.function_volume_m3, affine);
    fill_key_points(spindle, discretisation, affine);
    if (spindle.imposed_temperature) {
      affine.imposed_rises_K = imposed_rises_K(*spindle.imposed_temperature, affine.places);
    }
    if (!asks_for_mechanics(spindle)) return;
    const std::vector<DofPlace> fe_places(affine.places.begin(), affine.places.begin() + fe_unknowns);
    ElasticTerms elastic = elastic_terms<2>(discretisation, spindle);
    const std::vector<ContactForces> forces = contact_forces(spindle, section, rules, fe_places, elastic);
    ElasticBody body = bond_and_support(spindle, section, rules, fe_places, elastic);
    taken(elastic.stiffness_N_per_m);  // given up before the factor, the largest of all, is made
    taken(elastic.thermal_load_N_per_K);
    malloc_trim(0);  // or the factor has pages beside theirs, as chance lays free memory
    solver.emplace(std::move(body));
    affine.deformations = deformation_rows(spindle, section, rules, discretisation, *solver);
    for (FeDeformation& output : affine.deformations) output.row_m_per_K = enlarged(output.row_m_per_K, unknowns);
    affine.contact_pressures = contact_pressure_rows(spindle, rules, forces, *solver);
    for (FeContactPressure& output : affine.contact_pressures) {
      output.row_Pa_per_K = enlarged(output.row_Pa_per_K, unknowns);
    }
  }

  Eigen::VectorXd rises_K(const Eigen::VectorXd& temperatures_K) const {
    const auto count = static_cast<Eigen::Index>(discretisation.places.size());
    return temperatures_K.head(count).array() - affine.boundaries.reference_temperature_K;
  }

  /// False where the description asks for no mechanics; throws where it does and they were forgotten.
  bool knows_growth() const {
    if (!solver && asks_for_mechanics(described)) {
      throw std::logic_error("displacements and stresses of this model were given up (FeModel::forget_growth)");
    }
    return solver.has_value();
  }

  Stress stress_at(const Eigen::MatrixXd& nodal_Pa, std::size_t part, const Point& at) const {
    if (nodal_Pa.rows() == 0) throw std::logic_error("the description asks for no mechanics, so there is no stress");
    const Trace trace = trace_at(discretisation, static_cast<int>(part), at);
    Eigen::RowVector4d stress_Pa = Eigen::RowVector4d::Zero();
    for (std::size_t i = 0; i < trace.dofs.size(); ++i) stress_Pa += trace.values[i] * nodal_Pa.row(trace.dofs[i]);
    return stress_from(stress_Pa);
  }

  Discretisation<2> discretisation;
  std::vector<PartQuality> quality;
  AffineModel affine;
  Spindle described;
  Section outlined;
  std::optional<ElasticSolver> solver;  ///< only if the description asks for mechanics
};

FeModel::FeModel(const Spindle& spindle, const Section& section) : impl_(std::make_unique<Impl>(spindle, section)) {}
FeModel::~FeModel() = default;
FeModel::FeModel(FeModel&&) noexcept = default;
FeModel& FeModel::operator=(FeModel&&) noexcept = default;

const AffineModel& FeModel::affine() const& { return impl_->affine; }

AffineModel FeModel::affine() && {
  AffineModel affine = std::move(impl_->affine);
  impl_.reset();
  return affine;
}

void FeModel::forget_growth() { impl_->solver.reset(); }

const std::vector<PartQuality>& FeModel::quality() const { return impl_->quality; }
const Spindle& FeModel::description() const { return impl_->described; }
const Section& FeModel::section() const { return impl_->outlined; }
const Discretisation<2>& FeModel::discretisation() const { return impl_->discretisation; }
std::size_t FeModel::element_count() const { return impl_->discretisation.triangulation.n_active_cells(); }

FieldError FeModel::error_against(const ExactField& exact, const Eigen::VectorXd& nodal) const {
  return field_error(impl_->discretisation, nodal, exact);
}

Eigen::VectorXd FeModel::displacements_m(const Eigen::VectorXd& temperatures_K) const {
  if (impl_->knows_growth()) return impl_->solver->displacements_m(impl_->rises_K(temperatures_K));
  return Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(impl_->discretisation.places.size()));
}

Eigen::MatrixXd FeModel::stresses_Pa(const Eigen::VectorXd& temperatures_K) const {
  if (!impl_->knows_growth()) return Eigen::MatrixXd(0, 4);
  return nodal_stresses_Pa(impl_->discretisation, impl_->described, displacements_m(temperatures_K),
                           impl_->rises_K(temperatures_K));
}

Stress FeModel::stress_at(std::size_t part, const Point& at, const Eigen::VectorXd& temperatures_K) const {
  return impl_->stress_at(stresses_Pa(temperatures_K), part, at);
}

std::vector<ProbedStress> FeModel::probed_stresses(const Eigen::VectorXd& temperatures_K) const {
  std::vector<ProbedStress> probed;
  if (impl_->described.stress_probes.empty()) return probed;
  const Eigen::MatrixXd nodal_Pa = stresses_Pa(temperatures_K);
  for (const StressProbe& probe : impl_->described.stress_probes) {
    probed.push_back({probe.name, impl_->stress_at(nodal_Pa, probe.part, probe.at)});
  }
  return probed;
}

FeModel build_fe_model(const std::string& spindle_path) {
  const Spindle spindle = read_spindle(spindle_path);
  return {spindle, build_section(spindle)};
}

}  // namespace spindle_twin::fem_offline
