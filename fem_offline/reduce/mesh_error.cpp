#include "fem_offline/reduce/mesh_error.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "fem_offline/reduce/parallel.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double longest_warm_up_interval_s = 64.0;

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
  Eigen::MatrixXd outputs = run_fe_model(model, drive, longest_warm_up_interval_s).outputs;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, drive.factors, values);
  outputs.conservativeResize(Eigen::NoChange, outputs.cols() + 1);
  outputs.rightCols(1) = fe_outputs(model, solve_steady(model, values));
  return outputs;
}

}  // namespace

Spindle with_half_elements(Spindle spindle) {
  MeshSettings& mesh = spindle.mesh;
  mesh.element_size_m *= 0.5;
  mesh.cells_across *= 2;
  if (mesh.contact_size_m) *mesh.contact_size_m *= 0.5;
  for (Part& part : spindle.parts) {
    if (part.element_size_m) *part.element_size_m *= 0.5;
  }
  return spindle;
}

void measure_mesh_error(const AffineModel& model, const AffineModel& finer, int threads, const Progress& progress,
                        rom::Certificate& certificate) {
  const OutputLayout layout = output_layout(model);
  if (output_layout(finer).total() != layout.total()) {
    throw std::invalid_argument("the finer FE model has other outputs");
  }
  std::array<Eigen::MatrixXd, 2> outputs;
  for_each_index(2, threads, [&](int index, int worker) {
    outputs[static_cast<std::size_t>(index)] = warm_up(index == 0 ? finer : model);
    if (worker == 0 && progress) progress("mesh error", 0.5);
  });
  const Eigen::VectorXd change = (outputs[1] - outputs[0]).cwiseAbs().rowwise().maxCoeff();
  Eigen::Index at = 0;
  for (auto* errors : {&certificate.key_points_K, &certificate.part_means_K, &certificate.part_maxima_K,
                       &certificate.deformations_m, &certificate.contact_pressures_Pa}) {
    for (rom::OutputError& error : *errors) error.mesh = change[at++];
  }
}

}  // namespace spindle_twin::fem_offline
