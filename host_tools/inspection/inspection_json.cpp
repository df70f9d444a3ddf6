#include <cstdio>
#include <nlohmann/json.hpp>

#include "host_tools/inspection/certificate_json.hpp"
#include "host_tools/inspection/inspection.hpp"
#include "host_tools/inspection/law_facts.hpp"
#include "rom/kind_names.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

nlohmann::json boundaries_json(const Inspection& result) {
  const rom::Boundaries& boundaries = result.network.boundaries;
  nlohmann::json json{
      {"reference_speed_rpm", boundaries.reference_speed_rpm},
      {"operating", {{"speed_rpm", boundaries.operating.speed_rpm}, {"load", boundaries.operating.load}}},
      {"reference_temperature_degC", boundaries.reference_temperature_K - rom::zero_degC_K},
      {"sources", nlohmann::json::array()},
      {"environments", nlohmann::json::array()},
      {"conductances", nlohmann::json::array()}};
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    json["sources"].push_back({{"name", boundaries.sources[i].name},
                               {"nominal_W", boundaries.sources[i].nominal_W},
                               {"operating_W", result.values.heat_W[static_cast<Eigen::Index>(i)]}});
    if (boundaries.sources[i].measured) json["sources"].back()["measured"] = true;
    if (boundaries.sources[i].friction) json["sources"].back()["friction"] = true;
    if (boundaries.sources[i].physics)
      json["sources"].back()["law"] = law_json(result.network, *boundaries.sources[i].physics);
  }
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    json["environments"].push_back(
        {{"name", boundaries.environments[i].name},
         {"kind", kind_name(boundaries.environments[i].kind)},
         {"operating_degC", boundaries.operating.environment_K[static_cast<Eigen::Index>(i)] - rom::zero_degC_K}});
  }
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[j];
    json["conductances"].push_back(
        {{"name", conductance.name},
         {"kind", kind_name(conductance.kind)},
         {"nominal_W_per_m2K", conductance.nominal_W_per_m2K},
         {"operating_W_per_m2K", result.values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)]},
         {"area_m2", conductance.area_m2},
         {"rank", result.network.factors_m[j].cols()}});
    if (conductance.physics) json["conductances"].back()["law"] = law_json(result.network, *conductance.physics);
  }
  return json;
}

/// Adds key points, parts, deformations and contact pressures.
void add_outputs(const rom::Network& network, nlohmann::json& json) {
  json["key_points"] = json["parts"] = json["deformations"] = nlohmann::json::array();
  for (const rom::KeyPoint& point : network.key_points) {
    json["key_points"].push_back({{"name", point.name}, {"part", point.part}, {"r_m", point.r_m}, {"z_m", point.z_m}});
  }
  for (const rom::PartOutput& part : network.parts) {
    json["parts"].push_back({{"name", part.name}, {"candidates", part.candidate_rows.rows()}});
  }
  for (const rom::DeformationOutput& output : network.deformations) {
    json["deformations"].push_back({{"name", output.name}, {"um_per_K", rom::um_per_m * output.row_m_per_K.sum()}});
  }
  json["contact_pressures"] = nlohmann::json::array();
  for (const rom::ContactPressureOutput& output : network.contact_pressures) {
    json["contact_pressures"].push_back({{"name", output.name},
                                         {"assembly_MPa", megapascal_per_pascal * output.assembly_pressure_Pa},
                                         {"MPa_per_K", megapascal_per_pascal * output.row_Pa_per_K.sum()}});
  }
}

/// Adds the coolant circuits, where there are any.
void add_coolant(const Inspection& result, nlohmann::json& json) {
  const rom::Boundaries& boundaries = result.network.boundaries;
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    nlohmann::json segments = nlohmann::json::array();
    for (const int segment : boundaries.circuits[c].segments) {
      segments.push_back(boundaries.conductances[static_cast<std::size_t>(segment)].name);
    }
    json["coolant"][boundaries.circuits[c].name] = {
        {"flow_kg_per_s", boundaries.operating.flow_kg_per_s[index]},
        {"heat_capacity_J_per_kgK", boundaries.circuits[c].heat_capacity_J_per_kgK},
        {"segments", segments},
        {"outlet_degC", result.coolant.outlet_K[index] - rom::zero_degC_K},
        {"heat_W", result.coolant.heat_W[index]}};
  }
}

}  // namespace

void print_json(const Inspection& result, const nlohmann::json& steady_state) {
  const rom::Network& network = result.network;
  nlohmann::json json = boundaries_json(result);
  json["spindle"] = network.spindle;
  json["description_sha256"] = network.description_hash;
  json["hand_written"] = network.hand_written;
  json["file"] = {{"sha256", result.sha256}, {"schema_version", result.schema_version}};
  json["file"]["signed_by"] = result.signed_by.empty() ? nlohmann::json() : nlohmann::json(result.signed_by);
  json["capacity_J_per_K"] = network.capacity_J_per_K.sum();
  for (const rom::Node& node : network.nodes) {
    json["nodes"].push_back({{"name", node.name}, {"part", node.part}, {"r_m", node.r_m}, {"z_m", node.z_m}});
  }
  add_outputs(network, json);
  add_coolant(result, json);
  json["steady_state"] = steady_state;
  json["certificate"] = certificate_to_json(network);
  json["time_constants_s"] = nlohmann::json::array();
  for (const double constant_s : result.time_constants_s) json["time_constants_s"].push_back(constant_s);
  json["checks"] = {{"capacity_asymmetry", result.checks.capacity_asymmetry},
                    {"conduction_asymmetry", result.checks.conduction_asymmetry},
                    {"conduction_row_sum", result.checks.row_sum},
                    {"exchange_column_sum", result.checks.exchange_column_sum},
                    {"smallest_capacity_J_per_K", result.checks.smallest_capacity_J_per_K},
                    {"capacity_condition", result.checks.capacity_condition},
                    {"smallest_conduction_W_per_K", result.checks.smallest_conduction_W_per_K}};
  std::printf("%s\n", json.dump(1).c_str());
}

}  // namespace spindle_twin::host_tools
