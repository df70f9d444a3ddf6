#include "host_tools/inspection/certificate_json.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "host_tools/inspection/inspection.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

nlohmann::ordered_json errors_json(const rom::CertificateErrors& errors) {
  return {{"key_points_K", errors.key_points_K}, {"nose_um", errors.nose_um}, {"part_max_K", errors.part_max_K}};
}

template <typename Items>
nlohmann::ordered_json by_name(const Items& items, const std::vector<rom::OutputError>& errors, double unit,
                               CertificateColumns columns) {
  nlohmann::ordered_json result = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < std::min(items.size(), errors.size()); ++i) {
    nlohmann::ordered_json& error = result[items[i].name];
    error = {{"worst", errors[i].worst / unit}, {"median", errors[i].median / unit}};
    if (columns.limit) error["limit"] = errors[i].limit / unit;
    if (columns.mesh) error["mesh"] = errors[i].mesh / unit;
  }
  return result;
}

}  // namespace

CertificateColumns certificate_columns(const rom::Certificate& certificate) {
  const bool mesh = std::any_of(certificate.part_maxima_K.begin(), certificate.part_maxima_K.end(),
                                [](const rom::OutputError& error) { return error.mesh != 0.0; });
  return {certificate.limit_rule.content > 0.0, mesh};
}

nlohmann::ordered_json certificate_to_json(const rom::Network& network) {
  const rom::Certificate& certificate = network.certificate;
  nlohmann::ordered_json result = {{"cases", certificate.cases}, {"seed", certificate.seed}};
  result["worst"] = errors_json(certificate.worst);
  result["median"] = errors_json(certificate.median);
  if (const rom::CertificateLimit& rule = certificate.limit_rule; rule.content > 0.0) {
    result["limit"] = errors_json(certificate.limit);
    result["limit"].update({{"content", rule.content},
                            {"confidence", rule.confidence},
                            {"distribution", rule.fitted ? "log-normal" : "any"}});
  }
  if (certificate.searched > 0) {
    result["worst_found"] = errors_json(certificate.worst_found);
    result["worst_found"]["searched"] = certificate.searched;
  }
  result["box"] = {{"contacts", {certificate.box.contact_low, certificate.box.contact_high}},
                   {"films", {certificate.box.film_low, certificate.box.film_high}},
                   {"speed_high_rpm", certificate.box.speed_high_rpm}};
  result["mesh"] = {{"element_size_mm", certificate.mesh_size_m * 1e3}, {"fe_unknowns", certificate.fe_unknowns}};
  const CertificateColumns columns = certificate_columns(certificate);
  result["outputs"] = {
      {"key_points_K", by_name(network.key_points, certificate.key_points_K, 1.0, columns)},
      {"part_mean_K", by_name(network.parts, certificate.part_means_K, 1.0, columns)},
      {"part_max_K", by_name(network.parts, certificate.part_maxima_K, 1.0, columns)},
      {"deformations_um", by_name(network.deformations, certificate.deformations_m, rom::m_per_um, columns)},
      {"contact_pressures_MPa",
       by_name(network.contact_pressures, certificate.contact_pressures_Pa, 1.0 / megapascal_per_pascal, columns)}};
  return result;
}

}  // namespace spindle_twin::host_tools
