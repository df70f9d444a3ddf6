#include "fem_offline/reduce/mesh_error.hpp"

#include <malloc.h>

#include <algorithm>

#include "fem_offline/mesh/error_left.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double longest_warm_up_interval_s = 64.0;
/// Two cuts make sixteen times as many, which take 10 kB each while the growth is assembled. A certificate asks for it
/// with every network; there the largest models go with one cut and order 1.
constexpr std::size_t most_unknowns_for_two_cuts = 30000;
constexpr std::size_t most_unknowns_in_a_certificate = 4000;

/// Outputs through the warm-up, and in the last column at its steady end.
Eigen::MatrixXd warm_up(const AffineModel& model) {
  const rom::Boundaries& boundaries = model.boundaries;
  DriveCase drive;
  drive.factors = rom::no_correction(boundaries);
  drive.initial_temperature_K = boundaries.reference_temperature_K;
  for (double at_s = 0.0; at_s < longest_warm_up_interval_s;) {
    drive.intervals.push_back({std::max(1.0, at_s), boundaries.operating, Eigen::VectorXd(), at_s});
    at_s += drive.intervals.back().duration_s;
  }
  Eigen::MatrixXd outputs = run_fe_model_by_steps(model, drive, longest_warm_up_interval_s).outputs;
  outputs.conservativeResize(Eigen::NoChange, outputs.cols() + 1);
  outputs.rightCols(1) = steady_outputs(model);
  return outputs;
}

/// `answer` of the model and of those on its mesh cut once and, as far as unknowns allow, twice. One finer model at a
/// time: the finest fills gigabytes.
template <typename Answer>
std::vector<Eigen::MatrixXd> answers_of_cuts(const FeModel& model, std::size_t most_unknowns, const Answer& answer) {
  const int cuts = model.affine().places.size() > most_unknowns ? 1 : 2;
  std::vector<Eigen::MatrixXd> answers = {answer(model.affine())};
  for (int times = 1; times <= cuts; ++times) {
    const AffineModel finer = FeModel(with_halved_elements(model.description(), times), model.section()).affine();
    malloc_trim(0);  // the elastic factor's pages, for those of the thermal ones may come to lie elsewhere
    answers.push_back(answer(finer));
  }
  return answers;
}

/// Errors of the first of two or three answers of the same size.
Eigen::MatrixXd errors_of_first(const std::vector<Eigen::MatrixXd>& answers, int degree) {
  const Eigen::MatrixXd first = answers[1] - answers[0];
  if (answers.size() == 2) return first.unaryExpr([](double change) { return error_left(change); });
  const Eigen::MatrixXd second = answers[2] - answers[1];
  return first.binaryExpr(second, [degree](double a, double b) { return error_left(a, b, degree); });
}

}  // namespace

Spindle with_halved_elements(Spindle spindle, int times) {
  spindle.mesh.halvings += times;
  return spindle;
}

void measure_mesh_error(const FeModel& model, const Progress& progress, rom::Certificate& certificate) {
  double done = 0.0;
  const auto followed = [&](const AffineModel& affine) -> Eigen::MatrixXd {
    Eigen::MatrixXd outputs = warm_up(affine);
    if (progress) progress("mesh error", done += 0.2);
    return outputs;
  };
  const Eigen::MatrixXd errors = errors_of_first(answers_of_cuts(model, most_unknowns_in_a_certificate, followed),
                                                 model.description().mesh.degree);
  const Eigen::VectorXd largest = errors.cwiseAbs().rowwise().maxCoeff();
  Eigen::Index at = 0;
  for (auto* errors_of_kind : {&certificate.key_points_K, &certificate.part_means_K, &certificate.part_maxima_K,
                               &certificate.deformations_m, &certificate.contact_pressures_Pa}) {
    for (rom::OutputError& error : *errors_of_kind) error.mesh = largest[at++];
  }
}

Eigen::VectorXd steady_mesh_error(const FeModel& model) {
  const auto steady = [](const AffineModel& affine) -> Eigen::MatrixXd { return steady_outputs(affine); };
  return errors_of_first(answers_of_cuts(model, most_unknowns_for_two_cuts, steady), model.description().mesh.degree);
}

}  // namespace spindle_twin::fem_offline
