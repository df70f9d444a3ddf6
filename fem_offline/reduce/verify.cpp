#include "fem_offline/reduce/verify.hpp"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <stdexcept>
#include <utility>

#include "fem_offline/reduce/analysed_system.hpp"
#include "fem_offline/reduce/error_limit.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

void check_options(const VerifyOptions& options) {
  if (options.cases < 1 || options.threads < 1 || !(options.fe_step_s.value_or(1.0) > 0.0)) {
    throw std::invalid_argument("cases and threads must be at least 1, fe_step_s above 0");
  }
}

void check_same_model(const rom::Network& network, const AffineModel& model) {
  if (network.key_points.size() != model.key_points.size() || network.parts.size() != model.parts.size() ||
      network.deformations.size() != model.deformations.size() ||
      network.contact_pressures.size() != model.contact_pressures.size() ||
      network.boundaries.conductances.size() != model.boundaries.conductances.size() ||
      network.boundaries.sources.size() != model.boundaries.sources.size() ||
      network.boundaries.environments.size() != model.boundaries.environments.size() ||
      network.boundaries.circuits.size() != model.boundaries.circuits.size()) {
    throw std::invalid_argument("network and FE model differ in their outputs or boundaries");
  }
}

FeTrajectory run_fe_case(const AffineModel& model, const CholeskyAnalysis& analysed, const VerifyOptions& options,
                         int index) {
  DriveCase drive = random_case(model.boundaries, options.seed, static_cast<std::uint32_t>(index), options.drive);
  return options.fe_step_s ? run_fe_model_by_steps(model, std::move(drive), *options.fe_step_s, &analysed)
                           : run_fe_model(model, std::move(drive), analysed);
}

double largest_error(const Eigen::VectorXd& values) { return values.size() > 0 ? values.maxCoeff() : 0.0; }

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::vector<rom::OutputError> summaries(const Eigen::MatrixXd& errors) {
  std::vector<rom::OutputError> result;
  for (const auto& row : errors.rowwise()) {
    const std::vector<double> of_cases(row.begin(), row.end());
    result.push_back({row.maxCoeff(), median(of_cases), 0.0, error_limit(of_cases)});
  }
  return result;
}

VerifyReport summarise(const Eigen::MatrixXd& errors, const AffineModel& model, const VerifyOptions& options) {
  const OutputLayout layout = output_layout(model);
  VerifyReport report;
  report.errors = errors;
  for (const auto& column : errors.colwise()) {
    report.cases.push_back({largest_error(column.head(layout.key_points)),
                            layout.deformations > 0 ? column[layout.deformations_at()] * rom::um_per_m : 0.0,
                            largest_error(column.segment(layout.maxima_at(), layout.parts))});
  }
  rom::Certificate& certificate = report.certificate;
  certificate.seed = options.seed;
  certificate.cases = options.cases;
  certificate.limit_rule = limit_rule(static_cast<int>(options.cases));
  const ParameterBox& box = options.drive.box;
  certificate.box = {box.contact_low, box.contact_high, box.film_low, box.film_high, box.speed_high_rpm};
  certificate.fe_unknowns = static_cast<std::uint32_t>(model.capacity_J_per_K.rows());
  using Errors = rom::CertificateErrors;
  for (double Errors::*member : {&Errors::key_points_K, &Errors::nose_um, &Errors::part_max_K}) {
    std::vector<double> values;
    for (const Errors& item : report.cases) values.push_back(item.*member);
    certificate.worst.*member = *std::max_element(values.begin(), values.end());
    certificate.median.*member = median(values);
    certificate.limit.*member = error_limit(values);
  }
  certificate.key_points_K = summaries(errors.topRows(layout.key_points));
  certificate.part_means_K = summaries(errors.middleRows(layout.means_at(), layout.parts));
  certificate.part_maxima_K = summaries(errors.middleRows(layout.maxima_at(), layout.parts));
  certificate.deformations_m = summaries(errors.middleRows(layout.deformations_at(), layout.deformations));
  certificate.contact_pressures_Pa = summaries(errors.middleRows(layout.pressures_at(), layout.pressures));
  return report;
}

}  // namespace

namespace {

/// Errors in the cases from `first` on, a column each.
Eigen::MatrixXd errors_from(const rom::Network& network, const AffineModel& model, const VerifyOptions& options,
                            std::uint32_t first, const Progress& progress) {
  const auto network_operator = std::make_shared<const rom::NetworkOperator>(network);
  const AnalysedSystem matrices(model);
  const auto count = static_cast<int>(options.cases - first);
  Eigen::MatrixXd errors(output_layout(model).total(), count);
  std::atomic<int> finished{0};
  for_each_index(count, options.threads, [&](int index, int worker) {
    errors.col(index) = largest_errors(network, network_operator,
                                       run_fe_case(model, matrices.analysed, options, static_cast<int>(first) + index));
    const int done = ++finished;
    if (worker == 0 && progress) progress("verification", static_cast<double>(done) / count);
  });
  malloc_trim(0);  // factors and spaces of all cases, which the mesh error has other use for
  return errors;
}

}  // namespace

VerifyReport verify_network(const rom::Network& network, const AffineModel& model, const VerifyOptions& options,
                            const Progress& progress) {
  check_options(options);
  check_same_model(network, model);
  return summarise(errors_from(network, model, options, 0, progress), model, options);
}

VerifyReport verify_until(const rom::Network& network, const AffineModel& model, const VerifyOptions& options,
                          const Tolerance& wanted, const Progress& progress) {
  VerifyReport report = verify_network(network, model, options, progress);
  VerifyOptions more = options;
  const auto may_be_kept = [&] { return missed_outputs(model, report.errors.rowwise().maxCoeff(), wanted).empty(); };
  while (more.cases < cases_of_any_distribution && !missed_limits(model, report.certificate, wanted).empty() &&
         may_be_kept()) {
    const std::uint32_t known = more.cases;
    more.cases = std::min(known + cases_more, cases_of_any_distribution);
    Eigen::MatrixXd errors(report.errors.rows(), more.cases);
    errors << report.errors, errors_from(network, model, more, known, progress);
    report = summarise(errors, model, more);
  }
  return report;
}

}  // namespace spindle_twin::fem_offline
