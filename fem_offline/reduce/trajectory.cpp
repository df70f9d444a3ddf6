#include "fem_offline/reduce/trajectory.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/cvode_stepper.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// FE steps of a case: the first one behind a jump, and none longer than the last.
struct FeSteps {
  double first_s = 0.5;
  double last_s = 32.0;
};

/// For an error in time well below that of the network (README.md has the command that shows it). A small model takes
/// steps a quarter as long, which cost it less than the network's own integration: one whose coolant may stand rises by
/// hundreds of kelvin, and then the usual ones leave half of a tolerance.
FeSteps fe_steps(Eigen::Index unknowns, double longest_s) {
  constexpr Eigen::Index small_model = 3000;
  const double share = unknowns < small_model ? 0.25 : 1.0;
  const FeSteps usual;
  return {share * usual.first_s, std::min(share * usual.last_s, longest_s)};
}

/// Short behind a jump, where the balls and the air follow within seconds; by powers of four, as FeStepper's.
double fe_step_for_s(const HeldInterval& interval, const FeSteps& steps) {
  double step_s = steps.first_s;
  while (4.0 * step_s <= interval.since_jump_s) step_s *= 4.0;
  return std::min(step_s, steps.last_s);
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

OutputLayout output_layout(const AffineModel& model) {
  return {static_cast<Eigen::Index>(model.key_points.size()), static_cast<Eigen::Index>(model.parts.size()),
          static_cast<Eigen::Index>(model.deformations.size()),
          static_cast<Eigen::Index>(model.contact_pressures.size())};
}

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

FeTrajectory run_fe_model(const AffineModel& model, DriveCase drive, double fe_step_s, const CholeskyFactor* analysed) {
  FeStepper stepper(model, FeScheme::order_4, analysed);
  // Behind a jump steps only grow, and no state comes back.
  constexpr std::size_t latest_factors = 2;
  stepper.keep_factors(latest_factors);
  stepper.set_uniform_temperature(drive.initial_temperature_K);
  Eigen::MatrixXd outputs(output_layout(model).total(), static_cast<Eigen::Index>(drive.intervals.size()));
  const FeSteps steps = fe_steps(model.capacity_J_per_K.rows(), fe_step_s);
  follow(model.boundaries, drive, [&](Eigen::Index i, const HeldInterval& interval, const rom::BoundaryValues& values) {
    stepper.advance(interval.duration_s, fe_step_for_s(interval, steps), values);
    outputs.col(i) = fe_outputs(model, stepper.temperatures_K());
  });
  return {std::move(drive), std::move(outputs)};
}

Eigen::VectorXd largest_errors(const rom::Network& network,
                               const std::shared_ptr<const rom::NetworkOperator>& network_operator,
                               const FeTrajectory& trajectory) {
  rom::CvodeStepper stepper(network_operator);
  stepper.set_temperatures(Eigen::VectorXd::Constant(static_cast<Eigen::Index>(network.nodes.size()),
                                                     trajectory.drive.initial_temperature_K));
  rom::NetworkOutputs now = rom::make_network_outputs(network);
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(trajectory.outputs.rows());
  follow(network.boundaries, trajectory.drive,
         [&](Eigen::Index i, const HeldInterval& interval, const rom::BoundaryValues& values) {
           if (stepper.advance(interval.duration_s, values) != rom::StepStatus::ok) {
             throw std::runtime_error("the network's integrator failed");
           }
           rom::evaluate_outputs(network, stepper.temperatures_K(), now);
           errors = errors.cwiseMax((network_outputs(now) - trajectory.outputs.col(i)).cwiseAbs());
         });
  return errors;
}

}  // namespace spindle_twin::fem_offline
