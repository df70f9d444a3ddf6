#include "rom/by_hand/read_by_hand.hpp"

#include <algorithm>
#include <fstream>
#include <sstream>

#include "rom/by_hand/draft.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/read/sha256.hpp"
#include "rom/read_laws/read_plausible.hpp"
#include "rom/read_laws/read_speed_law.hpp"
#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  if (!stream || !text) throw InputError({path, 0}, "", "cannot be read as a file");
  return text.str();
}

double read_capacity(const TomlTable& table) {
  // In this order they are listed where a key is unknown.
  const bool has_capacity = table.has("capacity_J_per_K");
  const bool has_mass = table.has("mass_kg");
  if (has_capacity == has_mass) {
    table.fail("capacity_J_per_K", "a node needs either this or mass_kg with heat_capacity_J_per_kgK");
  }
  if (has_capacity) return table.number("capacity_J_per_K", {1e-6, 1e9, false, false});
  return table.number("mass_kg", {1e-9, 1e6, false, false}) *
         table.number("heat_capacity_J_per_kgK", {1.0, 1e5, false, false});
}

template <typename Items>
std::vector<std::string> names_of(const Items& items) {
  std::vector<std::string> names;
  names.reserve(items.size());
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

}  // namespace

void read_nodes(const TomlTable& root, Draft& draft) {
  std::vector<double> capacities_J_per_K;
  for (const TomlTable& table : root.tables("node")) {
    Node node;
    node.name = draft.nodes.add(table);
    if (table.has("part")) node.part = table.name("part");
    if (table.has("at")) {
      const std::vector<double> at_mm = table.numbers("at", 2, between(-1e5, 1e5));
      node.r_m = metre_per_mm * at_mm[0];
      node.z_m = metre_per_mm * at_mm[1];
    }
    capacities_J_per_K.push_back(read_capacity(table));
    if (!node.part.empty() && std::find(draft.parts.begin(), draft.parts.end(), node.part) == draft.parts.end()) {
      draft.parts.push_back(node.part);
    }
    draft.network.nodes.push_back(std::move(node));
    draft.node_tables.push_back(table);
  }
  const auto n = static_cast<Eigen::Index>(capacities_J_per_K.size());
  draft.network.capacity_J_per_K = Eigen::Map<const Eigen::VectorXd>(capacities_J_per_K.data(), n).asDiagonal();
  draft.network.conduction_W_per_K = Eigen::MatrixXd::Zero(n, n);
  draft.linked.resize(capacities_J_per_K.size());
  draft.cooled.resize(capacities_J_per_K.size());
}

void read_operating(const TomlTable& root, Draft& draft) {
  Boundaries& boundaries = draft.network.boundaries;
  for (const TomlTable& table : root.tables("surrounding")) {
    const std::string name = draft.surroundings.add(table);
    const bool coolant = table.choice("kind", {"ambient", "coolant"}) == "coolant";
    boundaries.environments.push_back({name, coolant ? EnvironmentKind::coolant : EnvironmentKind::ambient});
  }
  const TomlTable table = root.table("operating");
  boundaries.reference_speed_rpm = table.number("speed_rpm", positive);
  boundaries.operating.speed_rpm = boundaries.reference_speed_rpm;
  boundaries.operating.load = table.number_or("load", 1.0, not_negative);
  boundaries.reference_temperature_K = table.number("reference_temperature_degC", temperature_degC) + zero_degC_K;
  const TomlTable temperatures = table.table("temperatures_degC");
  for (const std::string& key : temperatures.free_keys()) draft.surroundings.find(temperatures, key, key);
  boundaries.operating.environment_K.resize(static_cast<Eigen::Index>(boundaries.environments.size()));
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    boundaries.operating.environment_K[static_cast<Eigen::Index>(i)] =
        temperatures.number(boundaries.environments[i].name, temperature_degC) + zero_degC_K;
  }
}

void check_connected(const TomlTable& root, const Draft& draft) {
  const std::size_t count = draft.linked.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (draft.linked[i].empty() && count > 1) {
      draft.node_tables[i].fail("name", "no conduction, contact or gap film connects this node with another one");
    }
  }
  std::vector<bool> reached(count);
  std::vector<std::size_t> front = {0};
  reached[0] = true;
  while (!front.empty()) {
    const std::size_t here = front.back();
    front.pop_back();
    for (const std::size_t next : draft.linked[here]) {
      if (reached[next]) continue;
      reached[next] = true;
      front.push_back(next);
    }
  }
  const auto lost = std::find(reached.begin(), reached.end(), false);
  if (lost != reached.end()) {
    draft.node_tables[static_cast<std::size_t>(lost - reached.begin())].fail(
        "name", "no path leads from here to the node \"" + draft.network.nodes[0].name + "\"");
  }
  if (std::none_of(draft.cooled.begin(), draft.cooled.end(), [](bool cooled) { return cooled; })) {
    root.fail("film", "at least one [[film]] or [[coolant_circuit]] must lead heat away");
  }
}

void read_laws(Draft& draft) {
  Boundaries& boundaries = draft.network.boundaries;
  LawPlaces places{draft.parts, {}, {}, {}};
  for (const Environment& environment : boundaries.environments) places.environments.push_back(environment.name);
  for (const auto& output : draft.network.contact_pressures) places.contact_pressures.push_back(output.name);
  for (const DeformationOutput& output : draft.network.deformations) places.deformations.push_back(output.name);
  for (const PendingLaw& pending : draft.laws) {
    const BoundLaw law = read_physical_law(pending, places, boundaries.reference_temperature_K);
    const double nominal = nominal_value(pending.table, law, boundaries.operating);
    if (pending.role == LawRole::heat) {
      boundaries.sources[pending.index].nominal_W = nominal;
      boundaries.sources[pending.index].physics = law;
    } else {
      boundaries.conductances[pending.index].nominal_W_per_m2K = nominal;
      boundaries.conductances[pending.index].physics = law;
    }
  }
}

Network parse_by_hand(const std::string& text, const std::string& file) {
  const TomlTable root = TomlTable::parse(text, file);
  if (!root.has("node") && root.has("material")) {
    throw InputError({file, 0}, "node", "there is none: this is a spindle description, for `spindle-twin build`");
  }
  Draft draft;
  draft.network.spindle = root.name();
  draft.network.description_hash = sha256_hex(text);
  draft.network.hand_written = true;
  read_nodes(root, draft);
  read_operating(root, draft);
  read_exchanges(root, draft);
  read_inputs_and_outputs(root, draft);
  read_laws(draft);
  draft.network.boundaries.plausible = read_plausible(root, names_of(draft.network.boundaries.environments),
                                                      names_of(draft.network.boundaries.circuits));
  root.finish();
  check_connected(root, draft);
  check_network(draft.network, file);
  return std::move(draft.network);
}

Network read_by_hand(const std::string& path) { return parse_by_hand(text_of(path), path); }

bool is_by_hand(const std::string& path) {
  try {
    return TomlTable::read(path).has("node");
  } catch (const InputError&) {
    return false;  // whoever reads it as what it should be says what is wrong
  }
}

}  // namespace spindle_twin::rom
