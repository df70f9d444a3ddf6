#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "rom/file/payload.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/laws/law_fields.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::rom {
namespace {

constexpr double rounding = 1e-9;  // of the largest entry: what a change of coordinates may leave
constexpr double weight_rounding = 1e-6;

class Checker {
 public:
  explicit Checker(const std::string& file) : file_(file) {}

  void require(bool condition, const std::string& field, const std::string& message) const {
    if (!condition) throw InputError({file_, 0}, field, message);
  }

  template <class Numbers>
  void finite(const Numbers& numbers, const std::string& field) const {
    require(numbers.allFinite(), field, "has a value that is not finite");
  }

  void finite(double number, const std::string& field) const { require(std::isfinite(number), field, "is not finite"); }

  void not_negative(double number, const std::string& field) const {
    require(std::isfinite(number) && number >= 0.0, field, "must be finite and not negative");
  }

  void above_absolute_zero(double kelvin, const std::string& field) const {
    require(std::isfinite(kelvin) && kelvin > 0.0, field, "must be finite and above 0 K");
  }

  void shape(const Eigen::MatrixXd& matrix, Eigen::Index rows, Eigen::Index columns, const std::string& field) const {
    require(matrix.rows() == rows && matrix.cols() == columns, field,
            "is " + std::to_string(matrix.rows()) + " x " + std::to_string(matrix.cols()) + ", but must be " +
                std::to_string(rows) + " x " + std::to_string(columns));
  }

  void symmetric(const Eigen::MatrixXd& matrix, const std::string& field) const {
    const double largest = matrix.cwiseAbs().maxCoeff();
    require((matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= rounding * largest, field, "is not symmetric");
  }

  /// Temperatures are averages of node temperatures: a uniform temperature must come out as itself.
  void sums_to_one(double sum, const std::string& field) const {
    require(std::abs(sum - 1.0) <= weight_rounding, field, "weights sum to " + std::to_string(sum) + ", not to 1");
  }

  void law(const SpeedLaw& law, double reference_speed_rpm, const std::string& field) const {
    finite(law.constant, field + " law constant");
    finite(law.load_squared, field + " law load_squared");
    for (const PowerTerm& term : law.speed_terms) {
      finite(term.coefficient, field + " law coefficient");
      not_negative(term.exponent, field + " law exponent");
      require(reference_speed_rpm > 0.0, "reference_speed_rpm", "must be positive where a law depends on speed");
    }
  }

  /// Numbers in range, indices that exist, and a heat where a heat is wanted.
  void physics(const std::optional<BoundLaw>& bound, bool heat, int segment_of, const Network& network,
               const std::string& field) const {
    if (!bound) return;
    const std::string fault = law_fault(bound->law.parameters);
    require(fault.empty(), field + " law", fault);
    require(static_cast<std::size_t>(bound->law.mode) < law_modes.size(), field + " law mode", "does not exist");
    require(is_heat(bound->law) == heat, field + " law",
            heat ? "is one of a conductance, not of a heat" : "is one of a heat, not of a conductance");
    require(heat || is_channel(bound->law) == (segment_of >= 0), field + " law",
            "of a channel belongs to the segments of a coolant circuit, and any other does not");
    require(bound->circuit == segment_of, field + " law circuit", "must be the circuit of its segment, -1 without");
    const auto index = [&](int at, std::size_t size, const std::string& what) {
      require(at >= -1 && at < static_cast<int>(size), field + " law " + what, "names one that does not exist");
    };
    for (const LawTemperature& temperature : {bound->first, bound->second}) {
      index(temperature.part, network.parts.size(), "part");
      index(temperature.environment, network.boundaries.environments.size(), "environment");
      require(temperature.part < 0 || temperature.environment < 0, field + " law temperature",
              "must be a part's or an environment's, not both");
      above_absolute_zero(temperature.nominal_K, field + " law nominal_K");
    }
    index(bound->pressure, network.contact_pressures.size(), "pressure");
    index(bound->displacement, network.deformations.size(), "displacement");
    for (const double number : {bound->displacement_sign, bound->nominal_pressure_Pa, bound->nominal_displacement_m}) {
      finite(number, field + " law");
    }
  }

  template <class Item>
  void names(const std::vector<Item>& items, const std::string& what) const {
    std::set<std::string> seen;
    for (const Item& item : items) {
      require(!item.name.empty(), what, "one has no name");
      require(seen.insert(item.name).second, what + " " + item.name, "name is used twice");
    }
  }

 private:
  const std::string& file_;
};

void check_matrices(const Network& network, Eigen::Index nodes, const Checker& check) {
  const Eigen::MatrixXd& capacity = network.capacity_J_per_K;
  check.shape(capacity, nodes, nodes, "capacity_J_per_K");
  check.finite(capacity, "capacity_J_per_K");
  check.symmetric(capacity, "capacity_J_per_K");
  check.require(Eigen::LLT<Eigen::MatrixXd>(capacity).info() == Eigen::Success, "capacity_J_per_K",
                "is not positive definite");

  const Eigen::MatrixXd& conduction = network.conduction_W_per_K;
  check.shape(conduction, nodes, nodes, "conduction_W_per_K");
  check.finite(conduction, "conduction_W_per_K");
  check.symmetric(conduction, "conduction_W_per_K");
  const double largest = conduction.cwiseAbs().maxCoeff();
  check.require(conduction.rowwise().sum().cwiseAbs().maxCoeff() <= rounding * largest, "conduction_W_per_K",
                "rows do not sum to zero; heat would not be conserved");
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(conduction, Eigen::EigenvaluesOnly);
  check.require(modes.info() == Eigen::Success && modes.eigenvalues()[0] >= -rounding * largest, "conduction_W_per_K",
                "is not positive semidefinite; heat would flow from cold to warm");
}

/// The circuit that conductance j is a segment of, -1 if of none.
int circuit_of(const Boundaries& boundaries, std::size_t j) {
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const std::vector<int>& segments = boundaries.circuits[c].segments;
    if (std::find(segments.begin(), segments.end(), static_cast<int>(j)) != segments.end()) return static_cast<int>(c);
  }
  return -1;
}

void check_conductances(const Network& network, Eigen::Index nodes, const Checker& check) {
  const Boundaries& boundaries = network.boundaries;
  check.require(network.factors_m.size() == boundaries.conductances.size(), "conductances", "not one factor for each");
  check.names(boundaries.conductances, "conductance");
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const Conductance& conductance = boundaries.conductances[j];
    const Eigen::MatrixXd& factor = network.factors_m[j];
    const std::string field = "conductance " + conductance.name;
    check.not_negative(conductance.nominal_W_per_m2K, field + " nominal_W_per_m2K");
    check.not_negative(conductance.area_m2, field + " area_m2");
    check.law(conductance.law, boundaries.reference_speed_rpm, field);
    check.physics(conductance.physics, false, circuit_of(boundaries, j), network, field);
    check.require(
        conductance.environment >= -1 && conductance.environment < static_cast<int>(boundaries.environments.size()),
        field + " environment", "names one that does not exist");
    for (const int part : {conductance.part_a, conductance.part_b}) {
      check.require(part >= -1 && part < static_cast<int>(network.parts.size()), field + " part",
                    "names one that does not exist");
    }
    if (conductance.fit) {
      check.finite(conductance.fit->assembly_pressure_Pa, field + " assembly_pressure_Pa");
      check.finite(conductance.fit->pressure_per_inner_rise_Pa_per_K, field + " pressure_per_inner_rise_Pa_per_K");
      check.finite(conductance.fit->pressure_per_outer_rise_Pa_per_K, field + " pressure_per_outer_rise_Pa_per_K");
    }
    check.require(factor.rows() == nodes && factor.cols() > 0, field + " factor",
                  "must have one row per node and at least one column");
    check.finite(factor, field + " factor");
    if (conductance.environment < 0) {
      check.require(factor.colwise().sum().cwiseAbs().maxCoeff() <= rounding * factor.cwiseAbs().maxCoeff(),
                    field + " factor",
                    "columns do not sum to zero; an exchange between bodies would not conserve heat");
    }
  }
}

void check_inputs(const Network& network, Eigen::Index nodes, const Checker& check) {
  const Boundaries& boundaries = network.boundaries;
  check.not_negative(boundaries.reference_speed_rpm, "reference_speed_rpm");
  check.above_absolute_zero(boundaries.reference_temperature_K, "reference_temperature_K");
  check.finite(boundaries.operating.speed_rpm, "operating_speed_rpm");
  check.finite(boundaries.operating.load, "operating_load");
  check.names(boundaries.environments, "environment");
  check.require(boundaries.operating.environment_K.size() == static_cast<Eigen::Index>(boundaries.environments.size()),
                "environments", "not one operating temperature for each");
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    check.above_absolute_zero(boundaries.operating.environment_K[static_cast<Eigen::Index>(i)],
                              "environment " + boundaries.environments[i].name + " operating_K");
  }
  for (const PlausibleRange& own : boundaries.plausible) {
    check.require(own.range.min <= own.range.max, "plausible " + own.of, "has no lowest <= highest");
  }
  check.names(boundaries.sources, "source");
  check.shape(network.source_distribution, nodes, static_cast<Eigen::Index>(boundaries.sources.size()),
              "source distribution");
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    const HeatSource& source = boundaries.sources[i];
    const std::string field = "source " + source.name;
    check.not_negative(source.nominal_W, field + " nominal_W");
    check.law(source.law, boundaries.reference_speed_rpm, field);
    check.physics(source.physics, true, -1, network, field);
    check.require(!(source.measured && source.physics), field + " measured", "cannot follow a physical law besides");
    check.require(!(source.friction && source.physics), field + " friction",
                  "cannot be said of a physical law, which follows its temperatures itself");
    const auto column = network.source_distribution.col(static_cast<Eigen::Index>(i));
    check.finite(column, field + " distribution");
    check.sums_to_one(column.sum(), field + " distribution");
  }
}

void check_circuits(const Boundaries& boundaries, const Checker& check) {
  const Eigen::VectorXd& flow_kg_per_s = boundaries.operating.flow_kg_per_s;
  check.require(flow_kg_per_s.size() == static_cast<Eigen::Index>(boundaries.circuits.size()), "circuits",
                "not one operating flow for each");
  check.finite(flow_kg_per_s, "circuits operating flow");
  check.names(boundaries.circuits, "circuit");
  std::set<int> seen;
  for (const CoolantCircuit& circuit : boundaries.circuits) {
    const std::string field = "circuit " + circuit.name;
    check.require(circuit.environment >= 0 && circuit.environment < static_cast<int>(boundaries.environments.size()),
                  field + " environment", "names one that does not exist");
    check.require(std::isfinite(circuit.heat_capacity_J_per_kgK) && circuit.heat_capacity_J_per_kgK > 0.0,
                  field + " heat capacity", "must be finite and positive");
    check.require(!circuit.segments.empty(), field, "has no segment");
    for (const int segment : circuit.segments) {
      check.require(segment >= 0 && segment < static_cast<int>(boundaries.conductances.size()), field + " segment",
                    "names a conductance that does not exist");
      const Conductance& film = boundaries.conductances[static_cast<std::size_t>(segment)];
      check.require(seen.insert(segment).second, field + " segment", film.name + " is in a circuit twice");
      check.require(film.environment == circuit.environment && film.area_m2 > 0.0, field + " segment",
                    film.name + " must be a film with an area to the circuit's own environment");
    }
  }
}

void check_outputs(const Network& network, Eigen::Index nodes, const Checker& check) {
  for (const Node& node : network.nodes) {
    check.require(!node.name.empty(), "node", "one has no name");
    check.finite(node.r_m, "node " + node.name + " r_m");
    check.finite(node.z_m, "node " + node.name + " z_m");
  }
  check.names(network.key_points, "key point");
  for (const KeyPoint& point : network.key_points) {
    const std::string field = "key point " + point.name;
    check.finite(point.r_m, field + " r_m");
    check.finite(point.z_m, field + " z_m");
    check.shape(point.row, nodes, 1, field + " row");
    check.finite(point.row, field + " row");
    check.sums_to_one(point.row.sum(), field + " row");
  }
  check.names(network.parts, "part");
  for (const PartOutput& part : network.parts) {
    const std::string field = "part " + part.name;
    check.shape(part.mean_row, nodes, 1, field + " mean row");
    check.finite(part.mean_row, field + " mean row");
    check.sums_to_one(part.mean_row.sum(), field + " mean row");
    check.require(part.candidate_rows.rows() > 0 && part.candidate_rows.cols() == nodes, field + " candidates",
                  "must have at least one row and one column per node");
    check.finite(part.candidate_rows, field + " candidates");
    for (Eigen::Index i = 0; i < part.candidate_rows.rows(); ++i) {
      check.sums_to_one(part.candidate_rows.row(i).sum(), field + " candidate " + std::to_string(i));
    }
  }
  check.names(network.deformations, "deformation");
  check.require(network.hand_written || !network.deformations.empty(), "deformations", "none; the first is the nose");
  for (const DeformationOutput& output : network.deformations) {
    check.shape(output.row_m_per_K, nodes, 1, "deformation " + output.name + " row");
    check.finite(output.row_m_per_K, "deformation " + output.name + " row");
  }
  check.names(network.contact_pressures, "contact pressure");
  for (const ContactPressureOutput& output : network.contact_pressures) {
    const std::string field = "contact pressure " + output.name;
    check.finite(output.assembly_pressure_Pa, field + " assembly_pressure_Pa");
    check.shape(output.row_Pa_per_K, nodes, 1, field + " row");
    check.finite(output.row_Pa_per_K, field + " row");
  }
  for (const OutlineRing& ring : network.outlines) {
    check.require(ring.points_m.rows() == 2 && ring.points_m.cols() >= 3, "outline of " + ring.part,
                  "must have r and z of at least three points");
    check.finite(ring.points_m, "outline of " + ring.part);
  }
}

void check_certificate(const Network& network, const Checker& check) {
  const Certificate& certificate = network.certificate;
  for (const CertificateErrors& errors :
       {certificate.worst, certificate.median, certificate.limit, certificate.worst_found}) {
    check.not_negative(errors.key_points_K, "certificate key_points_K");
    check.not_negative(errors.nose_um, "certificate nose_um");
    check.not_negative(errors.part_max_K, "certificate part_max_K");
  }
  const CertificateLimit& rule = certificate.limit_rule;
  check.require(rule.content >= 0.0 && rule.content < 1.0 && rule.confidence >= 0.0 && rule.confidence < 1.0,
                "certificate limit", "has a content or a confidence that is no share below 1");
  const CertificateBox& box = certificate.box;
  for (const double edge : {box.contact_low, box.contact_high, box.film_low, box.film_high, box.speed_high_rpm}) {
    check.not_negative(edge, "certificate box");
  }
  check.require(box.contact_low <= box.contact_high && box.film_low <= box.film_high, "certificate box",
                "has a lower edge above the upper one");
  check.not_negative(certificate.mesh_size_m, "certificate mesh_size_m");
  const auto per_output = [&](const std::vector<OutputError>& errors, std::size_t outputs, const std::string& field) {
    check.require(errors.empty() || errors.size() == outputs, "certificate " + field,
                  "has " + std::to_string(errors.size()) + " errors for " + std::to_string(outputs) + " outputs");
    for (const OutputError& error : errors) {
      for (const double value : {error.worst, error.median, error.mesh, error.limit}) {
        check.not_negative(value, "certificate " + field);
      }
      check.require(error.median <= error.worst, "certificate " + field, "has a median above the worst");
      check.require(rule.content > 0.0 || error.limit == 0.0, "certificate " + field,
                    "has a limit without saying which share of the cases keeps it");
    }
  };
  per_output(certificate.key_points_K, network.key_points.size(), "of the key points");
  per_output(certificate.part_means_K, network.parts.size(), "of the part means");
  per_output(certificate.part_maxima_K, network.parts.size(), "of the part maxima");
  per_output(certificate.deformations_m, network.deformations.size(), "of the deformations");
  per_output(certificate.contact_pressures_Pa, network.contact_pressures.size(), "of the contact pressures");
  check.require(!network.hand_written || certificate.cases == 0, "certificate",
                "of a hand-written network, which has no FE model to be compared with");
}

}  // namespace

void check_network(const Network& network, const std::string& file) {
  const Checker check(file);
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  check.require(nodes > 0, "nodes", "none; at least one is needed");
  check.require(network.nodes.size() <= most_nodes, "nodes",
                std::to_string(nodes) + "; at most " + std::to_string(most_nodes) + " are allowed");
  check_matrices(network, nodes, check);
  check_inputs(network, nodes, check);
  check_conductances(network, nodes, check);
  check_circuits(network.boundaries, check);
  check_outputs(network, nodes, check);
  check_certificate(network, check);
}

}  // namespace spindle_twin::rom
