#include "host_tools/inspection/inspection.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <memory>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/file/rom_file.hpp"
#include "rom/integrate/time_constants.hpp"
#include "rom/units.hpp"

namespace spindle_twin::host_tools {
namespace {

constexpr Eigen::Index shown_time_constants = 5;

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

}  // namespace

std::string limit_text(const rom::CertificateLimit& rule) {
  return fmt::format("with {:g} % confidence at most {:g} % of all cases from this box exceed it ({})",
                     100.0 * rule.confidence, 100.0 * (1.0 - rule.content),
                     rule.fitted ? "a log-normal law fitted to the cases" : "whatever their distribution");
}

std::vector<CertifiedOutput> certified_outputs(const rom::Network& network) {
  const rom::Certificate& certificate = network.certificate;
  std::vector<CertifiedOutput> outputs;
  const auto add = [&](const char* kind, const auto& items, const std::vector<rom::OutputError>& errors,
                       const char* unit, double per_SI) {
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const rom::OutputError& error = errors[i];
      outputs.push_back({kind,
                         items[i].name,
                         unit,
                         {per_SI * error.worst, per_SI * error.median, per_SI * error.mesh, per_SI * error.limit}});
    }
  };
  add("key point", network.key_points, certificate.key_points_K, "K", 1.0);
  add("part mean", network.parts, certificate.part_means_K, "K", 1.0);
  add("part maximum", network.parts, certificate.part_maxima_K, "K", 1.0);
  add("deformation", network.deformations, certificate.deformations_m, "um", rom::um_per_m);
  add("contact pressure", network.contact_pressures, certificate.contact_pressures_Pa, "MPa", megapascal_per_pascal);
  return outputs;
}

Inspection inspect(const std::string& path) {
  Inspection result;
  rom::RomFile file = rom::read_rom_file(path);
  result.network = std::move(file.network);
  result.schema_version = file.schema_version;
  result.sha256 = file.sha256;
  if (file.signed_by) result.signed_by = rom::to_hex(*file.signed_by);
  const rom::Boundaries& boundaries = result.network.boundaries;
  result.values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), result.values);
  const auto coordinates = std::make_shared<const rom::NetworkOperator>(result.network);
  if (!coordinates->laws().empty()) {
    const Eigen::VectorXd steady_K = rom::steady_temperatures_K(coordinates, result.values);
    if (steady_K.allFinite()) coordinates->laws().at_temperatures(steady_K, result.values);
  }
  const Eigen::VectorXd all_s = rom::time_constants_s(*coordinates, result.values.conductance_W_per_m2K);
  result.time_constants_s = all_s.head(std::min(shown_time_constants, all_s.size()));
  result.checks = check(result.network);
  if (!boundaries.circuits.empty()) {
    result.coolant =
        rom::coolant_outlets(*coordinates, result.values, rom::steady_temperatures_K(coordinates, result.values));
  }
  return result;
}

}  // namespace spindle_twin::host_tools
