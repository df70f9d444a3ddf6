#include "rom/integrate/output_uncertainty.hpp"

#include <limits>
#include <vector>

namespace spindle_twin::rom {
namespace {

constexpr double sigmas_of_the_worst = 2.0;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double metre_per_um = 1e-6;

/// `worst_of_all` stands in where there is no error per output.
Eigen::VectorXd deviations(const std::vector<OutputError>& errors, std::size_t outputs, double worst_of_all) {
  const auto count = static_cast<Eigen::Index>(outputs);
  Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(count, worst_of_all / sigmas_of_the_worst);
  if (errors.size() != outputs) return sigmas;
  for (Eigen::Index i = 0; i < count; ++i) {
    const OutputError& error = errors[static_cast<std::size_t>(i)];
    sigmas[i] = (error.worst + error.mesh) / sigmas_of_the_worst;
  }
  return sigmas;
}

}  // namespace

OutputUncertainty output_uncertainty(const Network& network) {
  const Certificate& certificate = network.certificate;
  const bool measured = certificate.cases > 0;
  const auto otherwise = [&](double worst) { return measured ? worst : unknown; };
  OutputUncertainty sigma;
  sigma.key_points_K =
      deviations(certificate.key_points_K, network.key_points.size(), otherwise(certificate.worst.key_points_K));
  sigma.part_means_K = deviations(certificate.part_means_K, network.parts.size(), unknown);
  sigma.part_maxima_K =
      deviations(certificate.part_maxima_K, network.parts.size(), otherwise(certificate.worst.part_max_K));
  sigma.deformations_m = deviations(certificate.deformations_m, network.deformations.size(), unknown);
  if (certificate.deformations_m.empty() && !network.deformations.empty()) {
    sigma.deformations_m[0] = otherwise(metre_per_um * certificate.worst.nose_um) / sigmas_of_the_worst;
  }
  sigma.contact_pressures_Pa = deviations(certificate.contact_pressures_Pa, network.contact_pressures.size(), unknown);
  return sigma;
}

}  // namespace spindle_twin::rom
