#include <cmath>
#include <sstream>

#include "rom/boundary_values/held_law.hpp"
#include "rom/by_hand/draft.hpp"
#include "rom/read_laws/read_speed_law.hpp"
#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

void check_sum_is_one(const TomlTable& table, const std::string& key, double sum) {
  if (std::abs(sum - 1.0) <= 1e-9) return;
  std::ostringstream text;
  text << "the weights must add up to 1, they make " << sum;
  table.fail(key, text.str());
}

/// A table of numbers, one per named node; nodes that are not named have 0.
Eigen::VectorXd read_row(const TomlTable& owner, const std::string& key, Range range, const Draft& draft) {
  const TomlTable table = owner.table(key);
  Eigen::VectorXd row = Eigen::VectorXd::Zero(draft.size());
  const std::vector<std::string> names = table.free_keys();
  if (names.empty()) owner.fail(key, "must give at least one node its number");
  for (const std::string& name : names) {
    row[static_cast<Eigen::Index>(draft.nodes.find(table, name, name))] = table.number(name, range);
  }
  return row;
}

/// `node`, or `weights` of several nodes.
Eigen::VectorXd read_weights(const TomlTable& table, const Draft& draft) {
  const bool has_node = table.has("node");
  const bool has_weights = table.has("weights");
  if (has_node == has_weights) table.fail("node", "either this or weights is needed");
  if (has_node) {
    return Eigen::VectorXd::Unit(draft.size(), static_cast<Eigen::Index>(draft.nodes.find(table, "node")));
  }
  Eigen::VectorXd row = read_row(table, "weights", not_negative, draft);
  check_sum_is_one(table, "weights", row.sum());
  return row;
}

void read_heat(const TomlTable& table, Names& names, Draft& draft) {
  HeatSource source;
  source.name = names.add(table);
  source.measured = table.boolean_or("measured", false);
  if (const auto law = optional_law(table, {"heat_W", "speed_law", "friction"})) {
    if (source.measured) table.fail("measured", "cannot stand beside a law: the heat is one or the other");
    draft.laws.push_back({*law, LawRole::heat, draft.network.boundaries.sources.size(), {}});
  } else {
    source.nominal_W = table.number("heat_W", not_negative);
    source.law = read_speed_law(table);
    source.friction = read_friction(table, source.law);
  }
  Eigen::MatrixXd& distribution = draft.network.source_distribution;
  distribution.conservativeResize(draft.size(), distribution.cols() + 1);
  distribution.rightCols(1) = read_weights(table, draft);
  draft.network.boundaries.sources.push_back(std::move(source));
}

/// Place and part of a key point follow from its nodes; a place of its own may be given.
void read_key_point(const TomlTable& table, Names& names, Draft& draft) {
  KeyPoint point;
  point.name = names.add(table);
  point.row = read_weights(table, draft);
  Eigen::Index heaviest = 0;
  point.row.maxCoeff(&heaviest);
  point.part = draft.network.nodes[static_cast<std::size_t>(heaviest)].part;
  for (Eigen::Index i = 0; i < draft.size(); ++i) {
    const Node& node = draft.network.nodes[static_cast<std::size_t>(i)];
    point.r_m += point.row[i] * node.r_m;
    point.z_m += point.row[i] * node.z_m;
  }
  if (table.has("at")) {
    const std::vector<double> at_mm = table.numbers("at", 2, between(-1e5, 1e5));
    point.r_m = metre_per_mm * at_mm[0];
    point.z_m = metre_per_mm * at_mm[1];
  }
  draft.network.key_points.push_back(std::move(point));
}

/// Mean over a part by capacity, extremes over its nodes.
PartOutput part_output(const std::string& name, const Draft& draft) {
  PartOutput part{name, Eigen::VectorXd::Zero(draft.size()), {}};
  std::vector<Eigen::Index> own;
  for (Eigen::Index i = 0; i < draft.size(); ++i) {
    if (draft.network.nodes[static_cast<std::size_t>(i)].part != name) continue;
    own.push_back(i);
    part.mean_row[i] = draft.network.capacity_J_per_K(i, i);
  }
  part.mean_row /= part.mean_row.sum();
  part.candidate_rows = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(own.size()), draft.size());
  for (std::size_t k = 0; k < own.size(); ++k) part.candidate_rows(static_cast<Eigen::Index>(k), own[k]) = 1.0;
  return part;
}

}  // namespace

void read_inputs_and_outputs(const TomlTable& root, Draft& draft) {
  Network& network = draft.network;
  network.source_distribution.resize(draft.size(), 0);
  Names heats("heat"), key_points("key point"), deformations("deformation output"), pressures("contact pressure");
  for (const TomlTable& table : root.tables_or_empty("heat")) read_heat(table, heats, draft);
  network.boundaries.operating.heat_W = unread_heats_W(network.boundaries);
  for (const TomlTable& table : root.tables_or_empty("key_point")) read_key_point(table, key_points, draft);
  for (const std::string& name : draft.parts) network.parts.push_back(part_output(name, draft));
  for (const TomlTable& table : root.tables_or_empty("deformation")) {
    const std::string name = deformations.add(table);
    network.deformations.push_back({name, m_per_um * read_row(table, "um_per_K", between(-1e6, 1e6), draft)});
  }
  for (const TomlTable& table : root.tables_or_empty("contact_pressure")) {
    const std::string name = pressures.add(table);
    const double assembly_pressure_Pa = table.number("assembly_pressure_Pa", between(-1e12, 1e12));
    network.contact_pressures.push_back(
        {name, assembly_pressure_Pa, read_row(table, "Pa_per_K", between(-1e12, 1e12), draft)});
  }
}

}  // namespace spindle_twin::rom
