#include "host_tools/inspection/network_facts.hpp"

#include <map>
#include <optional>
#include <sstream>

#include "host_tools/inspection/law_facts.hpp"
#include "rom/kind_names.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

class Facts {
 public:
  std::vector<Fact> list;

  void start(const std::string& section, const std::string& name) {
    section_ = section;
    name_ = name;
  }
  void add(const std::string& field, double value) { list.push_back({section_, name_, field, value}); }
  void add(const std::string& field, const std::string& value) { list.push_back({section_, name_, field, value}); }
  void add(const std::string& field, const Eigen::MatrixXd& value) { list.push_back({section_, name_, field, value}); }

 private:
  std::string section_, name_;
};

std::string text_of(const rom::SpeedLaw& law) {
  std::ostringstream text;
  text.precision(10);
  text << law.constant;
  for (const rom::PowerTerm& term : law.speed_terms) text << " + " << term.coefficient << " x^" << term.exponent;
  if (law.load_squared != 0.0) text << " + " << law.load_squared << " load^2";
  if (law.zero_at_standstill) text << ", 0 at standstill";
  return text.str();
}

template <class Named>
std::string name_at(const std::vector<Named>& items, int index) {
  return index < 0 ? "none" : items[static_cast<std::size_t>(index)].name;
}

void add_network(const Inspection& inspection, Facts& facts) {
  const rom::Network& network = inspection.network;
  facts.start("file", "");
  facts.add("schema_version", std::to_string(inspection.schema_version));
  facts.add("signed_by", inspection.signed_by.empty() ? "nobody" : inspection.signed_by);
  facts.start("network", "");
  facts.add("spindle", network.spindle);
  facts.add("description_sha256", network.description_hash);
  facts.add("hand_written", std::string(network.hand_written ? "yes" : "no"));
  facts.add("nodes", static_cast<double>(network.nodes.size()));
  facts.add("total_capacity_J_per_K", network.capacity_J_per_K.sum());
  facts.add("capacity_J_per_K", network.capacity_J_per_K);
  facts.add("conduction_W_per_K", network.conduction_W_per_K);
  const rom::Boundaries& boundaries = network.boundaries;
  facts.start("operating", "");
  facts.add("speed_rpm", boundaries.operating.speed_rpm);
  facts.add("load", boundaries.operating.load);
  facts.add("reference_speed_rpm", boundaries.reference_speed_rpm);
  facts.add("reference_temperature_degC", boundaries.reference_temperature_K - rom::zero_degC_K);
  for (const rom::Node& node : network.nodes) {
    facts.start("node", node.name);
    facts.add("part", node.part);
    facts.add("r_mm", 1e3 * node.r_m);
    facts.add("z_mm", 1e3 * node.z_m);
  }
}

/// A law's own facts, each with a name of its own; a network without laws has none of them.
void add_law(const rom::Network& network, const std::optional<rom::BoundLaw>& law, Facts& facts) {
  if (!law) return;
  const nlohmann::json json = law_json(network, *law);
  for (const auto& [key, value] : json.items()) {
    if (value.is_string()) facts.add("law " + key, value.get<std::string>());
    if (value.is_number()) facts.add("law " + key, value.get<double>());
  }
  for (const auto& [key, value] : json["numbers"].items()) facts.add("law " + key, value.get<double>());
}

void add_boundaries(const rom::Network& network, Facts& facts) {
  const rom::Boundaries& boundaries = network.boundaries;
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    facts.start("environment", boundaries.environments[i].name);
    facts.add("kind", std::string(kind_name(boundaries.environments[i].kind)));
    facts.add("operating_degC", boundaries.operating.environment_K[static_cast<Eigen::Index>(i)] - rom::zero_degC_K);
  }
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    facts.start("source", boundaries.sources[i].name);
    facts.add("nominal_W", boundaries.sources[i].nominal_W);
    facts.add("law", text_of(boundaries.sources[i].law));
    if (boundaries.sources[i].measured) facts.add("measured", std::string("yes"));
    if (boundaries.sources[i].friction) facts.add("friction", std::string("yes"));
    add_law(network, boundaries.sources[i].physics, facts);
    facts.add("distribution", network.source_distribution.col(static_cast<Eigen::Index>(i)));
  }
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[j];
    facts.start("conductance", conductance.name);
    facts.add("kind", std::string(kind_name(conductance.kind)));
    facts.add("nominal_W_per_m2K", conductance.nominal_W_per_m2K);
    facts.add("area_mm2", 1e6 * conductance.area_m2);
    facts.add("environment", name_at(boundaries.environments, conductance.environment));
    facts.add("part_a", name_at(network.parts, conductance.part_a));
    facts.add("part_b", name_at(network.parts, conductance.part_b));
    facts.add("law", text_of(conductance.law));
    add_law(network, conductance.physics, facts);
    if (conductance.fit) {
      facts.add("assembly_pressure_Pa", conductance.fit->assembly_pressure_Pa);
      facts.add("pressure_per_inner_rise_Pa_per_K", conductance.fit->pressure_per_inner_rise_Pa_per_K);
      facts.add("pressure_per_outer_rise_Pa_per_K", conductance.fit->pressure_per_outer_rise_Pa_per_K);
    }
    // F is one of many with the same F Fᵀ, which is what acts.
    facts.add("exchange_m2", network.factors_m[j] * network.factors_m[j].transpose());
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const rom::CoolantCircuit& circuit = boundaries.circuits[c];
    facts.start("circuit", circuit.name);
    facts.add("inlet", name_at(boundaries.environments, circuit.environment));
    facts.add("heat_capacity_J_per_kgK", circuit.heat_capacity_J_per_kgK);
    facts.add("operating_kg_per_s", boundaries.operating.flow_kg_per_s[static_cast<Eigen::Index>(c)]);
    std::string segments;
    for (const int segment : circuit.segments) {
      segments += (segments.empty() ? "" : ", ") + name_at(boundaries.conductances, segment);
    }
    facts.add("segments", segments);
  }
}

void add_outputs(const rom::Network& network, Facts& facts) {
  for (const rom::KeyPoint& point : network.key_points) {
    facts.start("key point", point.name);
    facts.add("part", point.part);
    facts.add("r_mm", 1e3 * point.r_m);
    facts.add("z_mm", 1e3 * point.z_m);
    facts.add("row", point.row);
  }
  for (const rom::PartOutput& part : network.parts) {
    facts.start("part", part.name);
    facts.add("mean_row", part.mean_row);
    facts.add("candidate_rows", part.candidate_rows);
  }
  for (const rom::DeformationOutput& output : network.deformations) {
    facts.start("deformation", output.name);
    facts.add("um_per_K", rom::um_per_m * output.row_m_per_K.sum());
    facts.add("row_m_per_K", output.row_m_per_K);
  }
  for (const rom::ContactPressureOutput& output : network.contact_pressures) {
    facts.start("contact pressure", output.name);
    facts.add("assembly_pressure_Pa", output.assembly_pressure_Pa);
    facts.add("row_Pa_per_K", output.row_Pa_per_K);
  }
}

/// The k-th ring of a part is "part", "part 2", ...
void add_outlines(const rom::Network& network, Facts& facts) {
  std::map<std::string, int> rings;
  for (const rom::OutlineRing& ring : network.outlines) {
    const int count = ++rings[ring.part];
    facts.start("outline", count == 1 ? ring.part : ring.part + " " + std::to_string(count));
    facts.add("points_m", ring.points_m);
  }
}

void add_certificate(const rom::Network& network, Facts& facts) {
  const rom::Certificate& certificate = network.certificate;
  facts.start("certificate", "");
  facts.add("cases", certificate.cases);
  facts.add("seed", std::to_string(certificate.seed));
  facts.add("mesh_size_mm", 1e3 * certificate.mesh_size_m);
  facts.add("fe_unknowns", certificate.fe_unknowns);
  facts.add("box_contact_low", certificate.box.contact_low);
  facts.add("box_contact_high", certificate.box.contact_high);
  facts.add("box_film_low", certificate.box.film_low);
  facts.add("box_film_high", certificate.box.film_high);
  facts.add("box_speed_high_rpm", certificate.box.speed_high_rpm);
  facts.add("worst_key_points_K", certificate.worst.key_points_K);
  facts.add("worst_nose_um", certificate.worst.nose_um);
  facts.add("worst_part_max_K", certificate.worst.part_max_K);
  facts.add("median_key_points_K", certificate.median.key_points_K);
  facts.add("median_nose_um", certificate.median.nose_um);
  facts.add("median_part_max_K", certificate.median.part_max_K);
  facts.add("limit_key_points_K", certificate.limit.key_points_K);
  facts.add("limit_nose_um", certificate.limit.nose_um);
  facts.add("limit_part_max_K", certificate.limit.part_max_K);
  facts.add("limit_content", certificate.limit_rule.content);
  facts.add("limit_confidence", certificate.limit_rule.confidence);
  facts.add("limit_fitted", certificate.limit_rule.fitted ? 1.0 : 0.0);
  facts.add("searched", certificate.searched);
  facts.add("found_key_points_K", certificate.worst_found.key_points_K);
  facts.add("found_nose_um", certificate.worst_found.nose_um);
  facts.add("found_part_max_K", certificate.worst_found.part_max_K);
  for (const CertifiedOutput& output : certified_outputs(network)) {
    facts.start("certificate", output.kind + " " + output.name);
    facts.add("worst_" + output.unit, output.error.worst);
    facts.add("median_" + output.unit, output.error.median);
    facts.add("mesh_" + output.unit, output.error.mesh);
    facts.add("limit_" + output.unit, output.error.limit);
  }
}

}  // namespace

std::vector<Fact> network_facts(const Inspection& inspection) {
  Facts facts;
  add_network(inspection, facts);
  add_boundaries(inspection.network, facts);
  add_outputs(inspection.network, facts);
  add_outlines(inspection.network, facts);
  add_certificate(inspection.network, facts);
  for (Eigen::Index i = 0; i < inspection.time_constants_s.size(); ++i) {
    facts.start("time constant", std::to_string(i + 1));
    facts.add("s", inspection.time_constants_s[i]);
  }
  return std::move(facts.list);
}

}  // namespace spindle_twin::host_tools
