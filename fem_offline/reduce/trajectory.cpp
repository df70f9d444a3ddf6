#include "fem_offline/reduce/trajectory.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

#include "fem_offline/reduce/krylov_stepper.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/cvode_stepper.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Three factors of a stretch pay from so many parts on: where a film follows a surrounding that drifts, or contacts
/// and films drift themselves, every part is a stretch of its own. A small model, whose network costs more, affords
/// them.
constexpr std::size_t least_projected_parts = 4;
constexpr Eigen::Index small_model = 3000;
/// FE steps elsewhere: the first behind a jump, and the longest.
constexpr double first_fe_step_s = 0.5, usual_fe_step_s = 32.0;
constexpr std::size_t latest_factors = 2;  // behind a jump steps only grow, and no state comes back

/// Short behind a jump, where the balls and the air follow within seconds; by powers of four, as FeStepper's.
double fe_step_for_s(const HeldInterval& interval, double longest_s) {
  double step_s = first_fe_step_s;
  while (4.0 * step_s <= interval.since_jump_s) step_s *= 4.0;
  return std::min(step_s, longest_s);
}

/// Inputs of every interval in turn.
template <typename Visit>
void follow(const rom::Boundaries& boundaries, const DriveCase& drive, const Visit& visit) {
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::CorrectionFactors factors = drive.factors;
  for (std::size_t i = 0; i < drive.intervals.size(); ++i) {
    const HeldInterval& interval = drive.intervals[i];
    if (interval.conductance_factors.size() > 0) factors.conductance = interval.conductance_factors;
    rom::evaluate_boundaries(boundaries, interval.state, factors, values);
    values.laws.follow =
        false;  // the FE model holds them at their nominal temperatures, and the basis is what is judged
    visit(static_cast<Eigen::Index>(i), interval, values);
  }
}

}  // namespace

Eigen::VectorXd fe_outputs(const AffineModel& model, const Eigen::VectorXd& temperatures_K) {
  const OutputLayout layout = output_layout(model);
  Eigen::VectorXd outputs(layout.total());
  Eigen::Index at = 0;
  for (const FeKeyPoint& point : model.key_points) outputs[at++] = point.row.dot(temperatures_K);
  for (const FePart& part : model.parts) outputs[at++] = part.mean_row.dot(temperatures_K);
  for (const FePart& part : model.parts) {
    double maximum_K = temperatures_K[part.dofs.front()];
    for (const int unknown : part.dofs) maximum_K = std::max(maximum_K, temperatures_K[unknown]);
    outputs[at++] = maximum_K;
  }
  const Eigen::VectorXd rises_K = temperatures_K.array() - model.boundaries.reference_temperature_K;
  for (const FeDeformation& item : model.deformations) outputs[at++] = item.row_m_per_K.dot(rises_K);
  for (const FeContactPressure& item : model.contact_pressures) {
    outputs[at++] = item.assembly_pressure_Pa + item.row_Pa_per_K.dot(rises_K);
  }
  return outputs;
}

Eigen::VectorXd steady_outputs(const AffineModel& model) {
  const rom::Boundaries& boundaries = model.boundaries;
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  rom::evaluate_boundaries(boundaries, boundaries.operating, rom::no_correction(boundaries), values);
  return fe_outputs(model, solve_steady(model, values));
}

Eigen::VectorXd network_outputs(const rom::NetworkOutputs& outputs) {
  Eigen::VectorXd column(outputs.key_points_K.size() + outputs.part_mean_K.size() + outputs.part_maximum_K.size() +
                         outputs.deformations_m.size() + outputs.contact_pressures_Pa.size());
  column << outputs.key_points_K, outputs.part_mean_K, outputs.part_maximum_K, outputs.deformations_m,
      outputs.contact_pressures_Pa;
  return column;
}

FeTrajectory run_fe_model(const AffineModel& model, DriveCase drive, const CholeskyAnalysis& analysed) {
  KrylovStepper by_projection(model, analysed, tolerance_in_time_K);
  FeStepper by_steps(model, FeScheme::order_4, &analysed);
  by_steps.keep_factors(latest_factors);
  by_steps.set_uniform_temperature(drive.initial_temperature_K);
  bool of_steps = true;  // who has the field
  Eigen::MatrixXd outputs(output_layout(model).total(), static_cast<Eigen::Index>(drive.intervals.size()));
  std::vector<StretchPart> stretch;
  Eigen::Index next = 0;
  const auto run = [&] {
    const bool projects = stretch.size() >= least_projected_parts || model.capacity_J_per_K.rows() < small_model;
    if (projects && of_steps) by_projection.set_temperatures(by_steps.temperatures_K());
    if (!projects && !of_steps) by_steps.set_temperatures(by_projection.temperatures_K());
    of_steps = !projects;
    if (projects) {
      by_projection.advance(stretch, [&](std::size_t, const Eigen::VectorXd& temperatures_K) {
        outputs.col(next++) = fe_outputs(model, temperatures_K);
      });
    } else {
      for (const StretchPart& part : stretch) {
        const HeldInterval& interval = drive.intervals[static_cast<std::size_t>(next)];
        by_steps.advance(part.duration_s, fe_step_for_s(interval, usual_fe_step_s), part.values);
        outputs.col(next++) = fe_outputs(model, by_steps.temperatures_K());
      }
    }
    stretch.clear();
  };
  follow(model.boundaries, drive, [&](Eigen::Index, const HeldInterval& interval, const rom::BoundaryValues& values) {
    if (!stretch.empty() && !of_one_stretch(stretch.front().values, values)) run();
    stretch.push_back({interval.duration_s, values});
  });
  if (!stretch.empty()) run();
  return {std::move(drive), std::move(outputs)};
}

FeTrajectory run_fe_model_by_steps(const AffineModel& model, DriveCase drive, double fe_step_s,
                                   const CholeskyAnalysis* analysed) {
  FeStepper stepper(model, FeScheme::order_4, analysed);
  stepper.keep_factors(latest_factors);
  stepper.set_uniform_temperature(drive.initial_temperature_K);
  Eigen::MatrixXd outputs(output_layout(model).total(), static_cast<Eigen::Index>(drive.intervals.size()));
  follow(model.boundaries, drive, [&](Eigen::Index i, const HeldInterval& interval, const rom::BoundaryValues& values) {
    stepper.advance(interval.duration_s, fe_step_for_s(interval, fe_step_s), values);
    outputs.col(i) = fe_outputs(model, stepper.temperatures_K());
  });
  return {std::move(drive), std::move(outputs)};
}

Eigen::VectorXd largest_errors(const rom::Network& network,
                               const std::shared_ptr<const rom::NetworkOperator>& network_operator,
                               const FeTrajectory& trajectory) {
  const double reference_K = network.boundaries.reference_temperature_K;
  rom::CvodeStepper stepper(network_operator);
  stepper.set_temperatures(Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network.nodes.size()),
                                                     trajectory.drive.initial_temperature_K));
  Eigen::MatrixXd rises_K(stepper.temperatures_K().size(), trajectory.outputs.cols());
  follow(network.boundaries, trajectory.drive,
         [&](Eigen::Index i, const HeldInterval& interval, const rom::BoundaryValues& values) {
           if (stepper.advance(interval.duration_s, values) != rom::StepStatus::ok) {
             throw std::runtime_error("the network's integrator failed");
           }
           rises_K.col(i) = stepper.temperatures_K().array() - reference_K;
         });
  // All at once: points of part extremes are thousands of rows.
  return (outputs_of(output_rows_of(network), rises_K) - trajectory.outputs).cwiseAbs().rowwise().maxCoeff();
}

}  // namespace spindle_twin::fem_offline
