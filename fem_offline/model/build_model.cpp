#include "fem_offline/model/build_model.hpp"

#include <optional>

#include "fem_offline/look/field_file.hpp"
#include "fem_offline/model/discretisation.hpp"
#include "fem_offline/model/exchange_terms.hpp"
#include "fem_offline/model/source_terms.hpp"
#include "fem_offline/model/thermoelastic.hpp"
#include "fem_offline/model/volume_terms.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Same entries in a matrix with rows and columns for the air volumes, which come last.
SparseMatrix enlarged(const SparseMatrix& matrix, int unknowns) {
  SparseMatrix result = matrix;
  result.conservativeResize(unknowns, unknowns);
  return result;
}

Eigen::VectorXd enlarged(const Eigen::VectorXd& row, int unknowns) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(unknowns);
  result.head(row.size()) = row;
  return result;
}

/// Where each surrounding went: an environment (input) or an unknown of its own.
struct Surroundings {
  std::vector<int> environment_of;
  std::vector<int> air_unknown;
};

Surroundings sort_surroundings(const Spindle& spindle, AffineModel& model) {
  Surroundings sorted;
  std::vector<double> environment_K;
  for (std::size_t i = 0; i < spindle.surroundings.size(); ++i) {
    const Surrounding& surrounding = spindle.surroundings[i];
    const bool is_air = surrounding.kind == SurroundingKind::air;
    sorted.environment_of.push_back(is_air ? -1 : static_cast<int>(environment_K.size()));
    sorted.air_unknown.push_back(is_air ? static_cast<int>(model.places.size()) : -1);
    if (is_air) {
      model.air_names.push_back(surrounding.name);
      model.places.push_back({});
      continue;
    }
    environment_K.push_back(spindle.operating.surrounding_K.at(i));
    model.boundaries.environments.push_back({surrounding.name, surrounding.kind == SurroundingKind::coolant
                                                                   ? rom::EnvironmentKind::coolant
                                                                   : rom::EnvironmentKind::ambient});
  }
  rom::OperatingState& operating = model.boundaries.operating;
  operating.speed_rpm = spindle.operating.speed_rpm;
  operating.load = spindle.operating.load;
  operating.environment_K =
      Eigen::Map<const Eigen::VectorXd>(environment_K.data(), static_cast<Eigen::Index>(environment_K.size()));
  model.boundaries.reference_speed_rpm = spindle.operating.speed_rpm;
  model.boundaries.reference_temperature_K = spindle.operating.reference_temperature_K;
  return sorted;
}

void fill_parts(const Spindle& spindle, const std::vector<Eigen::VectorXd>& function_volume_m3, AffineModel& model) {
  const auto unknowns = static_cast<int>(model.places.size());
  for (std::size_t p = 0; p < spindle.parts.size(); ++p) {
    FePart part{spindle.parts[p].name, {}, {}};
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
    model.key_points.push_back({point.name, part, point.at, std::move(row)});
  }
}

}  // namespace

struct FeModel::Impl {
  Impl(const Spindle& spindle, const Section& section)
      : discretisation(mesh_section(spindle, section), spindle.mesh.degree) {
    const SurfaceRules rules = make_surface_rules(discretisation, spindle, section);
    affine.spindle = spindle.name;
    affine.description_hash = spindle.hash;
    affine.places = discretisation.places;
    const auto fe_unknowns = static_cast<int>(affine.places.size());
    const Surroundings sorted = sort_surroundings(spindle, affine);
    const auto unknowns = static_cast<int>(affine.places.size());

    const VolumeTerms volume = volume_terms<2>(discretisation, spindle);
    affine.capacity_J_per_K = enlarged(volume.capacity_J_per_K, unknowns);
    affine.conduction_W_per_K = enlarged(volume.conduction_W_per_K, unknowns);
    for (std::size_t i = 0; i < spindle.surroundings.size(); ++i) {
      const int air = sorted.air_unknown[i];
      if (air >= 0) affine.capacity_J_per_K.coeffRef(air, air) = spindle.surroundings[i].capacity_J_per_K;
    }
    affine.capacity_J_per_K.makeCompressed();

    ExchangeTerms exchange =
        exchange_terms(spindle, section, rules, unknowns, sorted.environment_of, sorted.air_unknown);
    affine.conductance_terms_m2 = std::move(exchange.matrices_m2);
    affine.boundaries.conductances = std::move(exchange.conductances);
    SourceTerms sources = source_terms(spindle, section, rules, unknowns, volume.function_volume_m3);
    affine.boundaries.sources = std::move(sources.sources);
    affine.source_distribution = std::move(sources.distribution);

    fill_parts(spindle, volume.function_volume_m3, affine);
    fill_key_points(spindle, discretisation, affine);
    if (spindle.deformations.empty()) return;
    const ElasticTerms elastic = elastic_terms<2>(discretisation, spindle);
    const std::vector<DofPlace> fe_places(affine.places.begin(), affine.places.begin() + fe_unknowns);
    body =
        bond_and_support(spindle, section, rules, fe_places, elastic.stiffness_N_per_m, elastic.thermal_load_N_per_K);
    affine.deformations = deformation_rows(spindle, section, rules, *body);
    for (FeDeformation& output : affine.deformations) output.row_m_per_K = enlarged(output.row_m_per_K, unknowns);
  }

  Discretisation<2> discretisation;
  AffineModel affine;
  std::optional<ElasticBody> body;  ///< only if the description asks for deformations
};

FeModel::FeModel(const Spindle& spindle, const Section& section) : impl_(std::make_unique<Impl>(spindle, section)) {}
FeModel::~FeModel() = default;
FeModel::FeModel(FeModel&&) noexcept = default;
FeModel& FeModel::operator=(FeModel&&) noexcept = default;

const AffineModel& FeModel::affine() const { return impl_->affine; }

void FeModel::write_vtu(const std::string& directory, const std::string& name,
                        const Eigen::VectorXd& temperatures_K) const {
  const auto count = static_cast<Eigen::Index>(impl_->discretisation.places.size());
  const Eigen::VectorXd at_nodes_K = temperatures_K.head(count);
  const Eigen::VectorXd rises_K = at_nodes_K.array() - impl_->affine.boundaries.reference_temperature_K;
  const Eigen::VectorXd moved_m =
      impl_->body ? displacements(*impl_->body, rises_K) : Eigen::VectorXd(Eigen::VectorXd::Zero(2 * count));
  write_field_file(directory + "/" + name + ".vtu", impl_->discretisation, at_nodes_K, rises_K, moved_m);
}

FeModel build_fe_model(const std::string& spindle_path) {
  const Spindle spindle = read_spindle(spindle_path);
  return {spindle, build_section(spindle)};
}

}  // namespace spindle_twin::fem_offline
