#include "fem_offline/reduce/verify.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "correction/boundaries/evaluate_boundaries.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/integrate/outputs.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Largest error magnitudes of one case, per output.
struct CaseErrors {
  Eigen::ArrayXd key_points_K;
  Eigen::ArrayXd part_max_K;
  Eigen::ArrayXd deformations_m;
};

void check_same_model(const rom::Network& network, const AffineModel& model) {
  if (network.key_points.size() != model.key_points.size() || network.parts.size() != model.parts.size() ||
      network.deformations.size() != model.deformations.size() ||
      network.boundaries.conductances.size() != model.boundaries.conductances.size() ||
      network.boundaries.sources.size() != model.boundaries.sources.size() ||
      network.boundaries.environments.size() != model.boundaries.environments.size() ||
      network.boundaries.circuits.size() != model.boundaries.circuits.size()) {
    throw std::invalid_argument("network and FE model differ in key points, parts, deformations or boundaries");
  }
}

void full_outputs(const AffineModel& model, const Eigen::VectorXd& temperatures_K, rom::NetworkOutputs& outputs) {
  for (std::size_t i = 0; i < model.key_points.size(); ++i) {
    outputs.key_points_K[static_cast<Eigen::Index>(i)] = model.key_points[i].row.dot(temperatures_K);
  }
  for (std::size_t i = 0; i < model.parts.size(); ++i) {
    double maximum_K = temperatures_K[model.parts[i].dofs.front()];
    for (const int unknown : model.parts[i].dofs) maximum_K = std::max(maximum_K, temperatures_K[unknown]);
    outputs.part_maximum_K[static_cast<Eigen::Index>(i)] = maximum_K;
  }
  for (std::size_t i = 0; i < model.deformations.size(); ++i) {
    const Eigen::VectorXd& row = model.deformations[i].row_m_per_K;
    outputs.deformations_m[static_cast<Eigen::Index>(i)] =
        row.dot(temperatures_K) - model.boundaries.reference_temperature_K * row.sum();
  }
}

CaseErrors run_case(const rom::Network& network, const std::shared_ptr<const rom::NetworkOperator>& network_operator,
                    const AffineModel& model, const VerifyCase& drive, double fe_step_s) {
  FeStepper full(model);
  full.set_uniform_temperature(drive.initial_temperature_K);
  rom::CvodeStepper reduced(network_operator);
  reduced.set_temperatures(
      Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network.nodes.size()), drive.initial_temperature_K));
  rom::BoundaryValues values = correction::make_boundary_values(model.boundaries);
  rom::NetworkOutputs is = rom::make_network_outputs(network), should_be = is;
  CaseErrors errors{Eigen::ArrayXd::Zero(is.key_points_K.size()), Eigen::ArrayXd::Zero(is.part_maximum_K.size()),
                    Eigen::ArrayXd::Zero(is.deformations_m.size())};
  for (const HeldInterval& interval : drive.intervals) {
    correction::evaluate_boundaries(model.boundaries, interval.state, drive.factors, values);
    full.advance(interval.duration_s, fe_step_s, values);
    if (reduced.advance(interval.duration_s, values) != rom::StepStatus::ok) {
      throw std::runtime_error("the network's integrator failed");
    }
    full_outputs(model, full.temperatures_K(), should_be);
    rom::evaluate_outputs(network, reduced.temperatures_K(), is);
    errors.key_points_K = errors.key_points_K.max((is.key_points_K - should_be.key_points_K).array().abs());
    errors.part_max_K = errors.part_max_K.max((is.part_maximum_K - should_be.part_maximum_K).array().abs());
    errors.deformations_m = errors.deformations_m.max((is.deformations_m - should_be.deformations_m).array().abs());
  }
  return errors;
}

double largest(const Eigen::ArrayXd& values) { return values.size() > 0 ? values.maxCoeff() : 0.0; }

template <typename Member>
std::pair<double, double> worst_and_median(const std::vector<rom::CertificateErrors>& cases, Member member) {
  std::vector<double> sorted;
  for (const rom::CertificateErrors& item : cases) sorted.push_back(item.*member);
  std::sort(sorted.begin(), sorted.end());
  const std::size_t half = sorted.size() / 2;
  return {sorted.back(), sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half])};
}

}  // namespace

VerifyReport verify_network(const rom::Network& network, const AffineModel& model, const VerifyOptions& options,
                            const Progress& progress) {
  check_same_model(network, model);
  if (options.cases < 1 || options.threads < 1 || !(options.fe_step_s > 0.0)) {
    throw std::invalid_argument("cases and threads must be at least 1, fe_step_s above 0");
  }
  const auto network_operator = std::make_shared<const rom::NetworkOperator>(network);
  std::vector<CaseErrors> errors(options.cases);
  std::atomic<int> finished{0};
  for_each_index(static_cast<int>(options.cases), options.threads, [&](int index, int worker) {
    const VerifyCase drive =
        random_case(model.boundaries, options.seed, static_cast<std::uint32_t>(index), options.box);
    errors[static_cast<std::size_t>(index)] = run_case(network, network_operator, model, drive, options.fe_step_s);
    const int done = ++finished;
    if (worker == 0 && progress) progress("verification", static_cast<double>(done) / options.cases);
  });

  VerifyReport report;
  CaseErrors worst = errors.front();
  for (const CaseErrors& item : errors) {
    worst.key_points_K = worst.key_points_K.max(item.key_points_K);
    worst.part_max_K = worst.part_max_K.max(item.part_max_K);
    worst.deformations_m = worst.deformations_m.max(item.deformations_m);
    const double nose_m = item.deformations_m.size() > 0 ? item.deformations_m[0] : 0.0;
    report.cases.push_back({largest(item.key_points_K), nose_m * 1e6, largest(item.part_max_K)});
  }
  for (std::size_t i = 0; i < network.key_points.size(); ++i) {
    report.key_points_K.push_back({network.key_points[i].name, worst.key_points_K[static_cast<Eigen::Index>(i)]});
  }
  for (std::size_t i = 0; i < network.parts.size(); ++i) {
    report.part_max_K.push_back({network.parts[i].name, worst.part_max_K[static_cast<Eigen::Index>(i)]});
  }
  for (std::size_t i = 0; i < network.deformations.size(); ++i) {
    report.deformations_um.push_back(
        {network.deformations[i].name, worst.deformations_m[static_cast<Eigen::Index>(i)] * 1e6});
  }
  rom::Certificate& certificate = report.certificate;
  certificate.seed = options.seed;
  certificate.cases = options.cases;
  using Errors = rom::CertificateErrors;
  for (double Errors::*member : {&Errors::key_points_K, &Errors::nose_um, &Errors::part_max_K}) {
    const auto [high, median] = worst_and_median(report.cases, member);
    certificate.worst.*member = high;
    certificate.median.*member = median;
  }
  return report;
}

}  // namespace spindle_twin::fem_offline
