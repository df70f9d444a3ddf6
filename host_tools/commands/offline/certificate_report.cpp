#include "host_tools/commands/offline/certificate_report.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

nlohmann::ordered_json errors_json(const rom::CertificateErrors& errors) {
  return {{"key_points_K", errors.key_points_K}, {"nose_um", errors.nose_um}, {"part_max_K", errors.part_max_K}};
}

template <typename Items>
nlohmann::ordered_json by_name(const Items& items, const std::vector<rom::OutputError>& errors, double unit) {
  nlohmann::ordered_json result = nlohmann::ordered_json::object();
  for (std::size_t i = 0; i < std::min(items.size(), errors.size()); ++i) {
    result[items[i].name] = {
        {"worst", errors[i].worst / unit}, {"median", errors[i].median / unit}, {"mesh", errors[i].mesh / unit}};
  }
  return result;
}

template <typename Items>
void print_group(const char* title, const Items& items, const std::vector<rom::OutputError>& errors, double unit,
                 int digits, bool with_mesh) {
  for (std::size_t i = 0; i < std::min(items.size(), errors.size()); ++i) {
    std::printf("  %-24s %-32s %11.*f %11.*f", i == 0 ? title : "", items[i].name.c_str(), digits,
                errors[i].worst / unit, digits, errors[i].median / unit);
    if (with_mesh) std::printf(" %11.*f", digits, errors[i].mesh / unit);
    std::printf("\n");
  }
}

}  // namespace

nlohmann::ordered_json to_json(const rom::Network& network) {
  const rom::Certificate& certificate = network.certificate;
  nlohmann::ordered_json result = {{"cases", certificate.cases}, {"seed", certificate.seed}};
  result["worst"] = errors_json(certificate.worst);
  result["median"] = errors_json(certificate.median);
  result["box"] = {{"contacts", {certificate.box.contact_low, certificate.box.contact_high}},
                   {"films", {certificate.box.film_low, certificate.box.film_high}},
                   {"speed_high_rpm", certificate.box.speed_high_rpm}};
  result["mesh"] = {{"element_size_mm", certificate.mesh_size_m * 1e3}, {"fe_unknowns", certificate.fe_unknowns}};
  result["outputs"] = {
      {"key_points_K", by_name(network.key_points, certificate.key_points_K, 1.0)},
      {"part_mean_K", by_name(network.parts, certificate.part_means_K, 1.0)},
      {"part_max_K", by_name(network.parts, certificate.part_maxima_K, 1.0)},
      {"deformations_um", by_name(network.deformations, certificate.deformations_m, rom::m_per_um)},
      {"contact_pressures_Pa", by_name(network.contact_pressures, certificate.contact_pressures_Pa, 1.0)}};
  return result;
}

void print_certificate(const rom::Network& network) {
  const rom::Certificate& certificate = network.certificate;
  const rom::CertificateBox& box = certificate.box;
  std::printf("  network minus FE model, %u random cases of 1 to 2 h, seed %llu\n", certificate.cases,
              static_cast<unsigned long long>(certificate.seed));
  std::printf("  contacts %gx to %gx, films %gx to %gx, up to %g rpm; elements of %g mm, %u unknowns\n",
              box.contact_low, box.contact_high, box.film_low, box.film_high, box.speed_high_rpm,
              certificate.mesh_size_m * 1e3, certificate.fe_unknowns);
  const auto has_mesh = [](const std::vector<rom::OutputError>& errors) {
    return std::any_of(errors.begin(), errors.end(), [](const rom::OutputError& error) { return error.mesh != 0.0; });
  };
  const bool with_mesh = has_mesh(certificate.part_maxima_K);
  std::printf("  %-57s %11s %11s%s\n", "", "worst", "median", with_mesh ? "        mesh" : "");
  std::printf("  %-57s %11.4f %11.4f\n", "all key points, K", certificate.worst.key_points_K,
              certificate.median.key_points_K);
  std::printf("  %-57s %11.4f %11.4f\n", "nose, um", certificate.worst.nose_um, certificate.median.nose_um);
  std::printf("  %-57s %11.4f %11.4f\n", "all part maxima, K", certificate.worst.part_max_K,
              certificate.median.part_max_K);
  print_group("key point, K", network.key_points, certificate.key_points_K, 1.0, 4, with_mesh);
  print_group("deformation, um", network.deformations, certificate.deformations_m, rom::m_per_um, 4, with_mesh);
  print_group("contact pressure, Pa", network.contact_pressures, certificate.contact_pressures_Pa, 1.0, 0, with_mesh);
  print_group("part maximum, K", network.parts, certificate.part_maxima_K, 1.0, 4, with_mesh);
  print_group("part mean, K", network.parts, certificate.part_means_K, 1.0, 4, with_mesh);
}

}  // namespace spindle_twin::host_tools
