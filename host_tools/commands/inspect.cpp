#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "correction/boundaries/evaluate_boundaries.hpp"
#include "host_tools/commands/commands.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/coolant_outputs.hpp"
#include "rom/integrate/time_constants.hpp"

// spindle-twin inspect reference.rom
namespace spindle_twin::host_tools {
namespace {

constexpr double kelvin_at_0_degC = 273.15;
constexpr double micrometres_per_metre = 1e6;
constexpr double megapascal_per_pascal = 1e-6;
constexpr Eigen::Index shown_time_constants = 5;

const char* kind_name(rom::ConductanceKind kind) {
  switch (kind) {
    case rom::ConductanceKind::contact:
      return "contact";
    case rom::ConductanceKind::gap_film:
      return "gap film";
    case rom::ConductanceKind::air_film:
      return "air film";
    case rom::ConductanceKind::environment_film:
      return "environment film";
  }
  return "unknown";
}

const char* kind_name(rom::EnvironmentKind kind) {
  return kind == rom::EnvironmentKind::coolant ? "coolant" : "ambient";
}

/// What reading has already required, as numbers.
struct Checks {
  double capacity_asymmetry = 0.0;    ///< of the largest entry
  double conduction_asymmetry = 0.0;  ///< of the largest entry
  double row_sum = 0.0;               ///< largest |K₀ 1|, of the largest entry
  double exchange_column_sum = 0.0;   ///< largest column sum of an exchange's factor, of its largest entry
  double smallest_capacity_J_per_K = 0.0;
  double capacity_condition = 0.0;
  double smallest_conduction_W_per_K = 0.0;
};

double asymmetry(const Eigen::MatrixXd& matrix) {
  const double largest = matrix.cwiseAbs().maxCoeff();
  return largest > 0.0 ? (matrix - matrix.transpose()).cwiseAbs().maxCoeff() / largest : 0.0;
}

Checks check(const rom::Network& network) {
  Checks checks;
  checks.capacity_asymmetry = asymmetry(network.capacity_J_per_K);
  checks.conduction_asymmetry = asymmetry(network.conduction_W_per_K);
  const double largest = network.conduction_W_per_K.cwiseAbs().maxCoeff();
  if (largest > 0.0) {
    checks.row_sum = network.conduction_W_per_K.rowwise().sum().cwiseAbs().maxCoeff() / largest;
  }
  for (std::size_t j = 0; j < network.factors_m.size(); ++j) {
    if (network.boundaries.conductances[j].environment >= 0) continue;
    const Eigen::MatrixXd& factor = network.factors_m[j];
    checks.exchange_column_sum = std::max(checks.exchange_column_sum,
                                          factor.colwise().sum().cwiseAbs().maxCoeff() / factor.cwiseAbs().maxCoeff());
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> capacity(network.capacity_J_per_K, Eigen::EigenvaluesOnly);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> conduction(network.conduction_W_per_K, Eigen::EigenvaluesOnly);
  checks.smallest_capacity_J_per_K = capacity.eigenvalues()[0];
  checks.capacity_condition = capacity.eigenvalues().tail(1)[0] / capacity.eigenvalues()[0];
  checks.smallest_conduction_W_per_K = conduction.eigenvalues()[0];
  return checks;
}

struct Inspection {
  rom::Network network;
  rom::BoundaryValues values;  ///< at the operating state, nothing corrected
  Eigen::VectorXd time_constants_s;
  rom::CoolantOutlets coolant;  ///< in the steady state at the operating state
  Checks checks;
};

Inspection inspect(const std::string& path) {
  Inspection result;
  result.network = rom::read_network(path);
  const rom::Boundaries& boundaries = result.network.boundaries;
  result.values = correction::make_boundary_values(boundaries);
  correction::evaluate_boundaries(boundaries, boundaries.operating, correction::no_correction(boundaries),
                                  result.values);
  const Eigen::VectorXd all_s =
      rom::time_constants_s(rom::NetworkOperator(result.network), result.values.conductance_W_per_m2K);
  result.time_constants_s = all_s.head(std::min(shown_time_constants, all_s.size()));
  result.checks = check(result.network);
  if (!boundaries.circuits.empty()) {
    const auto channels = std::make_shared<const rom::NetworkOperator>(result.network);
    result.coolant =
        rom::coolant_outlets(*channels, result.values, rom::steady_temperatures_K(channels, result.values));
  }
  return result;
}

void print_inputs(const Inspection& result) {
  const rom::Boundaries& boundaries = result.network.boundaries;
  std::printf("\n%-24s %12s %12s\n", "heat source", "nominal W", "operating W");
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    std::printf("%-24s %12.2f %12.2f\n", boundaries.sources[i].name.c_str(), boundaries.sources[i].nominal_W,
                result.values.heat_W[static_cast<Eigen::Index>(i)]);
  }
  std::printf("\n%-24s %-10s %12s\n", "environment", "kind", "degC");
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    std::printf("%-24s %-10s %12.2f\n", boundaries.environments[i].name.c_str(),
                kind_name(boundaries.environments[i].kind),
                boundaries.operating.environment_K[static_cast<Eigen::Index>(i)] - kelvin_at_0_degC);
  }
  std::printf("\n%-44s %-17s %12s %12s %5s\n", "conductance", "kind", "W/m2K", "area mm2", "rank");
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[j];
    std::printf("%-44s %-17s %12.1f %12.1f %5ld\n", conductance.name.c_str(), kind_name(conductance.kind),
                conductance.nominal_W_per_m2K, 1e6 * conductance.area_m2,
                static_cast<long>(result.network.factors_m[j].cols()));
  }
}

void print_circuits(const Inspection& result) {
  const rom::Boundaries& boundaries = result.network.boundaries;
  if (boundaries.circuits.empty()) return;
  std::printf("\n%-24s %8s %10s %12s %12s %12s\n", "coolant circuit", "segments", "kg/s", "J/kgK", "steady degC",
              "steady W");
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const auto index = static_cast<Eigen::Index>(c);
    std::printf("%-24s %8zu %10.4f %12.1f %12.2f %12.2f\n", boundaries.circuits[c].name.c_str(),
                boundaries.circuits[c].segments.size(), boundaries.operating.flow_kg_per_s[index],
                boundaries.circuits[c].heat_capacity_J_per_kgK, result.coolant.outlet_K[index] - kelvin_at_0_degC,
                result.coolant.heat_W[index]);
  }
}

void print_outputs(const Inspection& result) {
  const rom::Network& network = result.network;
  std::printf("\n%-24s %-24s %9s %9s\n", "key point", "part", "r mm", "z mm");
  for (const rom::KeyPoint& point : network.key_points) {
    std::printf("%-24s %-24s %9.2f %9.2f\n", point.name.c_str(), point.part.c_str(), 1e3 * point.r_m, 1e3 * point.z_m);
  }
  std::printf("\n%-24s %11s\n", "part", "candidates");
  for (const rom::PartOutput& part : network.parts) {
    std::printf("%-24s %11ld\n", part.name.c_str(), static_cast<long>(part.candidate_rows.rows()));
  }
  std::printf("\n%-24s %14s\n", "deformation", "um per K");
  for (const rom::DeformationOutput& output : network.deformations) {
    std::printf("%-24s %14.4f\n", output.name.c_str(), micrometres_per_metre * output.row_m_per_K.sum());
  }
  if (network.contact_pressures.empty()) return;
  std::printf("\n%-24s %14s %14s\n", "contact pressure", "assembly MPa", "MPa per K");
  for (const rom::ContactPressureOutput& output : network.contact_pressures) {
    std::printf("%-24s %14.4f %14.4f\n", output.name.c_str(), megapascal_per_pascal * output.assembly_pressure_Pa,
                megapascal_per_pascal * output.row_Pa_per_K.sum());
  }
}

void print_quality(const Inspection& result) {
  const rom::Certificate& certificate = result.network.certificate;
  if (certificate.cases == 0) {
    std::printf("\nNo certificate: this network was not compared with its FE model.\n");
  } else {
    std::printf("\nCertificate: %u random cases, seed %llu, network minus FE model\n", certificate.cases,
                static_cast<unsigned long long>(certificate.seed));
    std::printf("%-10s %14s %10s %16s\n", "", "key points K", "nose um", "part maxima K");
    std::printf("%-10s %14.4f %10.4f %16.4f\n", "worst", certificate.worst.key_points_K, certificate.worst.nose_um,
                certificate.worst.part_max_K);
    std::printf("%-10s %14.4f %10.4f %16.4f\n", "median", certificate.median.key_points_K, certificate.median.nose_um,
                certificate.median.part_max_K);
  }
  std::printf("\nSlowest time constants at the operating state, s:");
  for (const double constant_s : result.time_constants_s) std::printf(" %.1f", constant_s);
  const Checks& checks = result.checks;
  std::printf("\n\nChecks\n");
  std::printf("  C asymmetry, of its largest entry             %10.1e\n", checks.capacity_asymmetry);
  std::printf("  K0 asymmetry, of its largest entry            %10.1e\n", checks.conduction_asymmetry);
  std::printf("  K0 row sums, of its largest entry             %10.1e\n", checks.row_sum);
  std::printf("  column sums of exchanges, of largest entry    %10.1e\n", checks.exchange_column_sum);
  std::printf("  smallest eigenvalue of C, J/K                 %10.2e (condition %.1e)\n",
              checks.smallest_capacity_J_per_K, checks.capacity_condition);
  std::printf("  smallest eigenvalue of K0, W/K                %10.1e\n", checks.smallest_conduction_W_per_K);
}

void print_table(const Inspection& result) {
  const rom::Network& network = result.network;
  const rom::Boundaries& boundaries = network.boundaries;
  std::printf("spindle      %s\n", network.spindle.c_str());
  std::printf("description  SHA-256 %s\n", network.description_hash.c_str());
  std::printf("network      %zu nodes, %zu conductances, %zu heat sources, %zu parts, %.0f J/K\n", network.nodes.size(),
              boundaries.conductances.size(), boundaries.sources.size(), network.parts.size(),
              network.capacity_J_per_K.sum());
  std::printf("operating    %.0f rpm, load %.2f; reference %.0f rpm, %.2f degC\n", boundaries.operating.speed_rpm,
              boundaries.operating.load, boundaries.reference_speed_rpm,
              boundaries.reference_temperature_K - kelvin_at_0_degC);
  print_inputs(result);
  print_circuits(result);
  print_outputs(result);
  print_quality(result);
}

nlohmann::json errors_json(const rom::CertificateErrors& errors) {
  return {{"key_points_K", errors.key_points_K}, {"nose_um", errors.nose_um}, {"part_max_K", errors.part_max_K}};
}

nlohmann::json boundaries_json(const Inspection& result) {
  const rom::Boundaries& boundaries = result.network.boundaries;
  nlohmann::json json{
      {"reference_speed_rpm", boundaries.reference_speed_rpm},
      {"operating", {{"speed_rpm", boundaries.operating.speed_rpm}, {"load", boundaries.operating.load}}},
      {"reference_temperature_degC", boundaries.reference_temperature_K - kelvin_at_0_degC},
      {"sources", nlohmann::json::array()},
      {"environments", nlohmann::json::array()},
      {"conductances", nlohmann::json::array()}};
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    json["sources"].push_back({{"name", boundaries.sources[i].name},
                               {"nominal_W", boundaries.sources[i].nominal_W},
                               {"operating_W", result.values.heat_W[static_cast<Eigen::Index>(i)]}});
  }
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    json["environments"].push_back(
        {{"name", boundaries.environments[i].name},
         {"kind", kind_name(boundaries.environments[i].kind)},
         {"operating_degC", boundaries.operating.environment_K[static_cast<Eigen::Index>(i)] - kelvin_at_0_degC}});
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
  }
  return json;
}

void print_json(const Inspection& result) {
  const rom::Network& network = result.network;
  nlohmann::json json = boundaries_json(result);
  json["spindle"] = network.spindle;
  json["description_sha256"] = network.description_hash;
  json["capacity_J_per_K"] = network.capacity_J_per_K.sum();
  for (const rom::Node& node : network.nodes) {
    json["nodes"].push_back({{"name", node.name}, {"part", node.part}, {"r_m", node.r_m}, {"z_m", node.z_m}});
  }
  json["key_points"] = json["parts"] = json["deformations"] = nlohmann::json::array();
  for (const rom::KeyPoint& point : network.key_points) {
    json["key_points"].push_back({{"name", point.name}, {"part", point.part}, {"r_m", point.r_m}, {"z_m", point.z_m}});
  }
  for (const rom::PartOutput& part : network.parts) {
    json["parts"].push_back({{"name", part.name}, {"candidates", part.candidate_rows.rows()}});
  }
  for (const rom::DeformationOutput& output : network.deformations) {
    json["deformations"].push_back(
        {{"name", output.name}, {"um_per_K", micrometres_per_metre * output.row_m_per_K.sum()}});
  }
  json["contact_pressures"] = nlohmann::json::array();
  for (const rom::ContactPressureOutput& output : network.contact_pressures) {
    json["contact_pressures"].push_back({{"name", output.name},
                                         {"assembly_MPa", megapascal_per_pascal * output.assembly_pressure_Pa},
                                         {"MPa_per_K", megapascal_per_pascal * output.row_Pa_per_K.sum()}});
  }
  const rom::Boundaries& boundaries = network.boundaries;
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
        {"outlet_degC", result.coolant.outlet_K[index] - kelvin_at_0_degC},
        {"heat_W", result.coolant.heat_W[index]}};
  }
  json["certificate"] = {{"cases", network.certificate.cases},
                         {"seed", network.certificate.seed},
                         {"worst", errors_json(network.certificate.worst)},
                         {"median", errors_json(network.certificate.median)}};
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

struct Options {
  std::string network;
  bool json = false;
};

}  // namespace

void add_inspect(CLI::App& app) {
  CLI::App* command = app.add_subcommand("inspect", "Show what a network file holds and check it");
  const auto options = std::make_shared<Options>();
  command->add_option("network", options->network, "network file, .rom")->required();
  command->add_flag("--json", options->json, "as JSON");
  command->callback([options] {
    const Inspection result = inspect(options->network);
    if (options->json) {
      print_json(result);
    } else {
      print_table(result);
    }
  });
}

}  // namespace spindle_twin::host_tools
