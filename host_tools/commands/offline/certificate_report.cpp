#include "host_tools/commands/offline/certificate_report.hpp"

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "host_tools/inspection/certificate_json.hpp"
#include "host_tools/inspection/inspection.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

template <typename Items>
void print_group(const char* title, const Items& items, const std::vector<rom::OutputError>& errors, double unit,
                 int digits, CertificateColumns columns) {
  for (std::size_t i = 0; i < std::min(items.size(), errors.size()); ++i) {
    std::printf("  %-24s %-32s %11.*f %11.*f", i == 0 ? title : "", items[i].name.c_str(), digits,
                errors[i].worst / unit, digits, errors[i].median / unit);
    if (columns.limit) std::printf(" %11.*f", digits, errors[i].limit / unit);
    if (columns.mesh) std::printf(" %11.*f", digits, errors[i].mesh / unit);
    std::printf("\n");
  }
}

}  // namespace

void print_certificate(const rom::Network& network) {
  const rom::Certificate& certificate = network.certificate;
  const rom::CertificateBox& box = certificate.box;
  std::printf("  network minus FE model, %u random cases of 1 to 2 h, seed %llu\n", certificate.cases,
              static_cast<unsigned long long>(certificate.seed));
  std::printf("  contacts %gx to %gx, films %gx to %gx, up to %g rpm; elements of %g mm, %u unknowns\n",
              box.contact_low, box.contact_high, box.film_low, box.film_high, box.speed_high_rpm,
              certificate.mesh_size_m * 1e3, certificate.fe_unknowns);
  const CertificateColumns columns = certificate_columns(certificate);
  if (columns.limit) std::printf("  limit: %s\n", limit_text(certificate.limit_rule).c_str());
  std::printf("  %-57s %11s %11s%s%s\n", "", "worst", "median", columns.limit ? "       limit" : "",
              columns.mesh ? "        mesh" : "");
  const auto line = [&](const char* what, double rom::CertificateErrors::*error) {
    std::printf("  %-57s %11.4f %11.4f", what, certificate.worst.*error, certificate.median.*error);
    if (columns.limit) std::printf(" %11.4f", certificate.limit.*error);
    std::printf("\n");
  };
  line("all key points, K", &rom::CertificateErrors::key_points_K);
  line((network.deformations.front().name + ", um").c_str(), &rom::CertificateErrors::nose_um);
  line("all part maxima, K", &rom::CertificateErrors::part_max_K);
  print_group("key point, K", network.key_points, certificate.key_points_K, 1.0, 4, columns);
  print_group("deformation, um", network.deformations, certificate.deformations_m, rom::m_per_um, 4, columns);
  print_group("contact pressure, MPa", network.contact_pressures, certificate.contact_pressures_Pa,
              1.0 / megapascal_per_pascal, 4, columns);
  print_group("part maximum, K", network.parts, certificate.part_maxima_K, 1.0, 4, columns);
  print_group("part mean, K", network.parts, certificate.part_means_K, 1.0, 4, columns);
}

}  // namespace spindle_twin::host_tools
