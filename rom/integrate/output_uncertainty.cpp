#include "rom/integrate/output_uncertainty.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// `worst_of_all` stands in where there is no error per output.
Eigen::VectorXd deviations(const std::vector<OutputError>& errors, std::size_t outputs, double worst_of_all) {
  const auto count = static_cast<Eigen::Index>(outputs);
  Eigen::VectorXd deviations = Eigen::VectorXd::Constant(count, certificate_deviation({worst_of_all, 0.0, 0.0}));
  if (errors.size() != outputs) return deviations;
  for (Eigen::Index i = 0; i < count; ++i) {
    deviations[i] = certificate_deviation(errors[static_cast<std::size_t>(i)]);
  }
  return deviations;
}

}  // namespace

double certificate_deviation(const OutputError& error) {
  return std::hypot(0.5 * (error.limit > 0.0 ? error.limit : error.worst), error.mesh);
}

OutputUncertainty output_uncertainty(const Network& network) {
  const Certificate& certificate = network.certificate;
  const auto otherwise = [&](double worst) { return certificate.cases > 0 ? worst : unknown; };
  const double nose_m = otherwise(m_per_um * certificate.worst.nose_um);
  const double key_points_K = otherwise(certificate.worst.key_points_K);
  const double part_maxima_K = otherwise(certificate.worst.part_max_K);
  OutputUncertainty sigma;
  sigma.key_points_K = deviations(certificate.key_points_K, network.key_points.size(), key_points_K);
  sigma.part_means_K = deviations(certificate.part_means_K, network.parts.size(), part_maxima_K);
  sigma.part_maxima_K = deviations(certificate.part_maxima_K, network.parts.size(), part_maxima_K);
  sigma.deformations_m = deviations(certificate.deformations_m, network.deformations.size(), nose_m);
  sigma.contact_pressures_Pa = deviations(certificate.contact_pressures_Pa, network.contact_pressures.size(), unknown);
  return sigma;
}

}  // namespace spindle_twin::rom
