#include <cstdio>

#include "host_tools/inspection/inspection.hpp"
#include "host_tools/inspection/law_facts.hpp"
#include "rom/kind_names.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

void print_inputs(const Inspection& result) {
  const rom::Boundaries& boundaries = result.network.boundaries;
  std::printf("\n%-24s %12s %12s\n", "heat source", "nominal W", "operating W");
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    const rom::HeatSource& source = boundaries.sources[i];
    const std::string from = source.physics    ? "  " + law_words(result.network, *source.physics)
                             : source.measured ? "  measured"
                             : source.friction ? "  friction"
                                               : "";
    std::printf("%-24s %12.2f %12.2f%s\n", source.name.c_str(), source.nominal_W,
                result.values.heat_W[static_cast<Eigen::Index>(i)], from.c_str());
  }
  std::printf("\n%-24s %-10s %12s\n", "environment", "kind", "degC");
  for (std::size_t i = 0; i < boundaries.environments.size(); ++i) {
    std::printf("%-24s %-10s %12.2f\n", boundaries.environments[i].name.c_str(),
                kind_name(boundaries.environments[i].kind),
                boundaries.operating.environment_K[static_cast<Eigen::Index>(i)] - rom::zero_degC_K);
  }
  std::printf("\n%-44s %-17s %12s %12s %5s\n", "conductance", "kind", "W/m2K", "area mm2", "rank");
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[j];
    std::printf("%-44s %-17s %12.1f %12.1f %5ld%s%s\n", conductance.name.c_str(), kind_name(conductance.kind),
                conductance.nominal_W_per_m2K, 1e6 * conductance.area_m2,
                static_cast<long>(result.network.factors_m[j].cols()), conductance.physics ? "  " : "",
                conductance.physics ? law_words(result.network, *conductance.physics).c_str() : "");
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
                boundaries.circuits[c].heat_capacity_J_per_kgK, result.coolant.outlet_K[index] - rom::zero_degC_K,
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
    std::printf("%-24s %14.4f\n", output.name.c_str(), rom::um_per_m * output.row_m_per_K.sum());
  }
  if (network.contact_pressures.empty()) return;
  std::printf("\n%-32s %14s %14s\n", "contact pressure", "assembly MPa", "MPa per K");
  for (const rom::ContactPressureOutput& output : network.contact_pressures) {
    std::printf("%-32s %14.4f %14.4f\n", output.name.c_str(), megapascal_per_pascal * output.assembly_pressure_Pa,
                megapascal_per_pascal * output.row_Pa_per_K.sum());
  }
}

void print_certificate(const rom::Network& network) {
  const rom::Certificate& certificate = network.certificate;
  if (certificate.cases == 0) {
    std::printf(network.hand_written ? "\nNo certificate: this network was written by hand, its error is unknown.\n"
                                     : "\nNo certificate: this network was not compared with its FE model.\n");
    return;
  }
  std::printf("\nCertificate: %u random cases, seed %llu, network minus FE model\n", certificate.cases,
              static_cast<unsigned long long>(certificate.seed));
  const rom::CertificateBox& box = certificate.box;
  if (box.contact_high > 0.0) {
    std::printf("  box: contacts %g to %g, films %g to %g of nominal, up to %.0f rpm\n", box.contact_low,
                box.contact_high, box.film_low, box.film_high, box.speed_high_rpm);
  }
  if (certificate.fe_unknowns > 0) {
    std::printf("  FE model: %u unknowns, elements of %.2f mm\n", certificate.fe_unknowns,
                1e3 * certificate.mesh_size_m);
  }
  std::printf("%-10s %14s %10s %16s\n", "", "key points K", "nose um", "part maxima K");
  std::printf("%-10s %14.4f %10.4f %16.4f\n", "worst", certificate.worst.key_points_K, certificate.worst.nose_um,
              certificate.worst.part_max_K);
  std::printf("%-10s %14.4f %10.4f %16.4f\n", "median", certificate.median.key_points_K, certificate.median.nose_um,
              certificate.median.part_max_K);
  if (certificate.searched > 0) {
    std::printf("%-10s %14.4f %10.4f %16.4f  the worst of %u jumps searched through\n", "found",
                certificate.worst_found.key_points_K, certificate.worst_found.nose_um,
                certificate.worst_found.part_max_K, certificate.searched);
  }
  const bool limits = certificate.limit_rule.content > 0.0;
  if (limits) {
    std::printf("%-10s %14.4f %10.4f %16.4f\n", "limit", certificate.limit.key_points_K, certificate.limit.nose_um,
                certificate.limit.part_max_K);
    std::printf("limit: %s\n", limit_text(certificate.limit_rule).c_str());
  }
  const std::vector<CertifiedOutput> outputs = certified_outputs(network);
  if (outputs.empty()) return;
  std::printf("\n%-17s %-32s %-4s %10s %10s %10s%s\n", "error of", "", "unit", "worst", "median", "mesh",
              limits ? "      limit" : "");
  for (const CertifiedOutput& output : outputs) {
    std::printf("%-17s %-32s %-4s %10.4f %10.4f %10.4f", output.kind.c_str(), output.name.c_str(), output.unit.c_str(),
                output.error.worst, output.error.median, output.error.mesh);
    if (limits) std::printf(" %10.4f", output.error.limit);
    std::printf("\n");
  }
}

void print_nodes(const rom::Network& network) {
  std::printf("\n%-32s %-24s %9s %9s %14s\n", "node", "part", "r mm", "z mm", "row of C J/K");
  for (std::size_t i = 0; i < network.nodes.size(); ++i) {
    const rom::Node& node = network.nodes[i];
    const double row_J_per_K = network.capacity_J_per_K.row(static_cast<Eigen::Index>(i)).sum();
    std::printf("%-32s %-24s ", node.name.c_str(), node.part.c_str());
    if (node.part.empty() && node.r_m == 0.0 && node.z_m == 0.0) {  // a volume of air without a place
      std::printf("%9s %9s %14.2f\n", "", "", row_J_per_K);
    } else {
      std::printf("%9.2f %9.2f %14.2f\n", 1e3 * node.r_m, 1e3 * node.z_m, row_J_per_K);
    }
  }
  if ((network.capacity_J_per_K.rowwise().sum().array() < 0.0).any()) {
    std::printf(
        "row of C: heat that a node takes up when all nodes warm by 1 K. A single one may be below zero, since\n"
        "nodes are points of shared shapes; those of a part add up to the part's own capacity.\n");
  }
}

void print_quality(const Inspection& result) {
  print_certificate(result.network);
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

}  // namespace

void print_table(const Inspection& result) {
  const rom::Network& network = result.network;
  const rom::Boundaries& boundaries = network.boundaries;
  std::printf("spindle      %s\n", network.spindle.c_str());
  std::printf("description  SHA-256 %s%s\n", network.description_hash.c_str(),
              network.hand_written ? ", hand-written" : "");
  std::printf("file         SHA-256 %s, schema version %u\n", result.sha256.c_str(), result.schema_version);
  std::printf("signature    %s\n", result.signed_by.empty() ? "none" : result.signed_by.c_str());
  std::printf("network      %zu nodes, %zu conductances, %zu heat sources, %zu parts, %.0f J/K\n", network.nodes.size(),
              boundaries.conductances.size(), boundaries.sources.size(), network.parts.size(),
              network.capacity_J_per_K.sum());
  std::printf("operating    %.0f rpm, load %.2f; reference %.0f rpm, %.2f degC\n", boundaries.operating.speed_rpm,
              boundaries.operating.load, boundaries.reference_speed_rpm,
              boundaries.reference_temperature_K - rom::zero_degC_K);
  print_nodes(network);
  print_inputs(result);
  print_circuits(result);
  print_outputs(result);
  print_quality(result);
}

}  // namespace spindle_twin::host_tools
