#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "rom/by_hand/draft.hpp"
#include "rom/read_laws/read_speed_law.hpp"

namespace spindle_twin::rom {
namespace {

using Pair = std::pair<std::size_t, std::size_t>;

struct Face {
  Pair nodes;  ///< of a film only the first
  double area_m2 = 0.0;
};

void link(Draft& draft, Pair nodes) {
  draft.linked[nodes.first].push_back(nodes.second);
  draft.linked[nodes.second].push_back(nodes.first);
}

/// `faces`, or one face in the table itself.
std::vector<TomlTable> face_tables(const TomlTable& table, const char* key) {
  if (!table.has("faces")) return {table};
  for (const char* own : {key, "area_mm2"}) {
    if (table.has(own)) table.fail(own, "stands in each of the faces, not beside them");
  }
  return table.tables("faces");
}

/// With `area_m2` for each face where the table gives its value in W/K; areas of their own are refused there.
std::vector<Face> read_pairs(const TomlTable& table, const Draft& draft, std::optional<double> area_m2 = {}) {
  std::vector<Face> faces;
  for (const TomlTable& face : face_tables(table, "between")) {
    if (area_m2 && face.has("area_mm2")) face.fail("area_mm2", "cannot stand beside conductance_W_per_K of a face");
    const Pair nodes = draft.nodes.find_pair(face, "between");
    faces.push_back({nodes, area_m2 ? *area_m2 : square_metre_per_mm2 * face.number("area_mm2", area_mm2)});
  }
  return faces;
}

std::vector<Face> read_walls(const TomlTable& table, const Draft& draft) {
  std::vector<Face> faces;
  std::set<std::size_t> seen;
  for (const TomlTable& face : face_tables(table, "node")) {
    const std::size_t node = draft.nodes.find(face, "node");
    if (!seen.insert(node).second) face.fail("node", "is in this film twice");
    faces.push_back({{node, node}, square_metre_per_mm2 * face.number("area_mm2", area_mm2)});
  }
  return faces;
}

/// The index of the part that all of these nodes are in; -1 if there is no such part.
int common_part(const Draft& draft, const std::vector<Face>& faces, std::size_t Pair::*side) {
  const std::string& part = draft.network.nodes[faces[0].nodes.*side].part;
  for (const Face& face : faces) {
    if (draft.network.nodes[face.nodes.*side].part != part) return -1;
  }
  const auto found = std::find(draft.parts.begin(), draft.parts.end(), part);
  return found == draft.parts.end() ? -1 : static_cast<int>(found - draft.parts.begin());
}

double total_area_m2(const std::vector<Face>& faces) {
  double sum_m2 = 0.0;
  for (const Face& face : faces) sum_m2 += face.area_m2;
  return sum_m2;
}

void add_between_nodes(Conductance conductance, const std::vector<Face>& faces, Draft& draft) {
  conductance.area_m2 = total_area_m2(faces);
  conductance.part_a = common_part(draft, faces, &Pair::first);
  conductance.part_b = common_part(draft, faces, &Pair::second);
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(draft.size(), static_cast<Eigen::Index>(faces.size()));
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const double root_area_m = std::sqrt(faces[i].area_m2);
    factor(static_cast<Eigen::Index>(faces[i].nodes.first), static_cast<Eigen::Index>(i)) = root_area_m;
    factor(static_cast<Eigen::Index>(faces[i].nodes.second), static_cast<Eigen::Index>(i)) = -root_area_m;
    link(draft, faces[i].nodes);
  }
  draft.network.boundaries.conductances.push_back(std::move(conductance));
  draft.network.factors_m.push_back(std::move(factor));
}

constexpr Range conductance_range_W_per_K{1e-9, 1e9, false, false};

/// A path in the material. One that may be corrected is a conductance like any other, of kind contact.
void read_conduction(const TomlTable& table, Draft& draft, std::set<Pair>& seen) {
  const auto [a, b] = draft.nodes.find_pair(table, "between");
  if (!seen.insert(std::minmax(a, b)).second) table.fail("between", "these two nodes have a conduction already");
  const double conductance_W_per_K = table.number("conductance_W_per_K", conductance_range_W_per_K);
  if (table.boolean_or("correctable", false)) {
    Conductance path;
    path.name = draft.conductances.add(table);
    path.kind = ConductanceKind::contact;
    path.nominal_W_per_m2K = conductance_W_per_K / area_of_W_per_K_m2;
    add_between_nodes(std::move(path), {{{a, b}, area_of_W_per_K_m2}}, draft);
    return;
  }
  if (table.has("name")) table.fail("name", "is only of use, and then needed, with correctable = true");
  const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
  Eigen::MatrixXd& conduction = draft.network.conduction_W_per_K;
  conduction(i, i) += conductance_W_per_K;
  conduction(j, j) += conductance_W_per_K;
  conduction(i, j) -= conductance_W_per_K;
  conduction(j, i) -= conductance_W_per_K;
  link(draft, {a, b});
}

void add_film(Conductance conductance, const std::vector<Face>& faces, Draft& draft) {
  conductance.kind = ConductanceKind::environment_film;
  conductance.area_m2 = total_area_m2(faces);
  conductance.part_a = common_part(draft, faces, &Pair::first);
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(draft.size(), static_cast<Eigen::Index>(faces.size()));
  for (std::size_t i = 0; i < faces.size(); ++i) {
    factor(static_cast<Eigen::Index>(faces[i].nodes.first), static_cast<Eigen::Index>(i)) = std::sqrt(faces[i].area_m2);
    draft.cooled[faces[i].nodes.first] = true;
  }
  draft.network.boundaries.conductances.push_back(std::move(conductance));
  draft.network.factors_m.push_back(std::move(factor));
}

/// Nominal value and speed law, or the table of a physical law, which is returned.
std::optional<TomlTable> read_value_or_law(const TomlTable& table, const char* key, Conductance& conductance) {
  auto law = optional_law(table, {key, "speed_law"});
  if (law) return law;
  conductance.nominal_W_per_m2K = table.number(key, positive);
  conductance.law = read_speed_law(table);
  return std::nullopt;
}

/// For the conductance added last.
void await_law(const TomlTable& law, LawRole role, Draft& draft, int circuit = -1) {
  const std::size_t index = draft.network.boundaries.conductances.size() - 1;
  const Conductance& conductance = draft.network.boundaries.conductances[index];
  draft.laws.push_back({law, role, index, {conductance.part_a, conductance.part_b, conductance.environment, circuit}});
}

void read_contact(const TomlTable& table, Draft& draft) {
  Conductance contact;
  contact.name = draft.conductances.add(table);
  contact.kind = ConductanceKind::contact;
  std::optional<TomlTable> law;
  std::optional<double> area_m2;
  if (table.has("conductance_W_per_K")) {
    for (const char* other : {"conductance_W_per_m2K", "law"}) {
      if (table.has(other)) table.fail(other, "cannot stand beside conductance_W_per_K");
    }
    area_m2 = area_of_W_per_K_m2;
    contact.nominal_W_per_m2K = table.number("conductance_W_per_K", conductance_range_W_per_K) / *area_m2;
    contact.law = read_speed_law(table);
  } else {
    law = read_value_or_law(table, "conductance_W_per_m2K", contact);
  }
  if (const auto fit = table.optional_table("joint_fit")) {
    contact.fit = JointFit{fit->number("assembly_pressure_Pa", not_negative),
                           fit->number("pressure_per_inner_rise_Pa_per_K", not_negative),
                           fit->number("pressure_per_outer_rise_Pa_per_K", not_negative)};
  }
  add_between_nodes(std::move(contact), read_pairs(table, draft, area_m2), draft);
  const Conductance& added = draft.network.boundaries.conductances.back();
  if (law) await_law(*law, LawRole::conductance, draft);
  if (added.fit && (added.part_a < 0 || added.part_b < 0)) {
    table.fail("joint_fit",
               "needs an inner and an outer part: all first nodes of one part, all second ones of another");
  }
}

void read_gap_film(const TomlTable& table, Draft& draft) {
  Conductance gap;
  gap.name = draft.conductances.add(table);
  const auto law = read_value_or_law(table, "coefficient_W_per_m2K", gap);
  const std::vector<Face> faces = read_pairs(table, draft);
  const bool to_air = std::any_of(faces.begin(), faces.end(), [&](const Face& face) {
    return draft.network.nodes[face.nodes.first].part.empty() || draft.network.nodes[face.nodes.second].part.empty();
  });
  gap.kind = to_air ? ConductanceKind::air_film : ConductanceKind::gap_film;
  add_between_nodes(std::move(gap), faces, draft);
  if (law) await_law(*law, LawRole::conductance, draft);
}

void read_film(const TomlTable& table, Draft& draft) {
  Conductance film;
  film.name = draft.conductances.add(table);
  film.environment = static_cast<int>(draft.surroundings.find(table, "surrounding"));
  const auto law = read_value_or_law(table, "coefficient_W_per_m2K", film);
  add_film(std::move(film), read_walls(table, draft), draft);
  if (law) await_law(*law, LawRole::conductance, draft);
}

void read_circuit(const TomlTable& table, Names& names, Draft& draft, std::vector<double>& flows_kg_per_s) {
  Boundaries& boundaries = draft.network.boundaries;
  CoolantCircuit circuit;
  circuit.name = names.add(table);
  circuit.environment = static_cast<int>(draft.surroundings.find(table, "inlet"));
  if (boundaries.environments[static_cast<std::size_t>(circuit.environment)].kind != EnvironmentKind::coolant) {
    table.fail("inlet", "must be a surrounding of kind coolant");
  }
  flows_kg_per_s.push_back(table.number("flow_kg_per_s"));
  circuit.heat_capacity_J_per_kgK = table.number("heat_capacity_J_per_kgK", positive);
  Conductance shared;
  const auto law = read_value_or_law(table, "coefficient_W_per_m2K", shared);
  for (const TomlTable& segment : table.tables("segments")) {
    Conductance film;
    film.name = draft.conductances.add(segment);
    film.environment = circuit.environment;
    if (law && segment.has("coefficient_W_per_m2K")) {
      segment.fail("coefficient_W_per_m2K", "cannot stand beside the circuit's law, which gives the value");
    }
    if (!law) film.nominal_W_per_m2K = segment.number_or("coefficient_W_per_m2K", shared.nominal_W_per_m2K, positive);
    film.law = shared.law;
    circuit.segments.push_back(static_cast<int>(boundaries.conductances.size()));
    add_film(std::move(film), read_walls(segment, draft), draft);
    if (law) await_law(*law, LawRole::channel, draft, static_cast<int>(boundaries.circuits.size()));
  }
  boundaries.circuits.push_back(std::move(circuit));
}

}  // namespace

void read_exchanges(const TomlTable& root, Draft& draft) {
  std::set<Pair> conducting;
  for (const TomlTable& table : root.tables_or_empty("conduction")) read_conduction(table, draft, conducting);
  for (const TomlTable& table : root.tables_or_empty("contact")) read_contact(table, draft);
  for (const TomlTable& table : root.tables_or_empty("gap_film")) read_gap_film(table, draft);
  for (const TomlTable& table : root.tables_or_empty("film")) read_film(table, draft);
  Names circuits("coolant circuit");
  std::vector<double> flows_kg_per_s;
  for (const TomlTable& table : root.tables_or_empty("coolant_circuit")) {
    read_circuit(table, circuits, draft, flows_kg_per_s);
  }
  draft.network.boundaries.operating.flow_kg_per_s =
      Eigen::Map<const Eigen::VectorXd>(flows_kg_per_s.data(), static_cast<Eigen::Index>(flows_kg_per_s.size()));
}

}  // namespace spindle_twin::rom
