#include "correction/boundaries/evaluate_boundaries.hpp"

#include "correction/laws/speed_law.hpp"

namespace spindle_twin::correction {

rom::CorrectionFactors no_correction(const rom::Boundaries& boundaries) {
  rom::CorrectionFactors factors;
  factors.heat = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(boundaries.sources.size()));
  factors.conductance = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(boundaries.conductances.size()));
  return factors;
}

rom::BoundaryValues make_boundary_values(const rom::Boundaries& boundaries) {
  rom::BoundaryValues values;
  values.conductance_W_per_m2K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.conductances.size()));
  values.heat_W = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.sources.size()));
  values.environment_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.environments.size()));
  return values;
}

void evaluate_boundaries(const rom::Boundaries& boundaries, const rom::OperatingState& state,
                         const rom::CorrectionFactors& factors, rom::BoundaryValues& values) {
  for (Eigen::Index j = 0; j < values.conductance_W_per_m2K.size(); ++j) {
    const rom::Conductance& conductance = boundaries.conductances[static_cast<std::size_t>(j)];
    values.conductance_W_per_m2K[j] =
        factors.conductance[j] * conductance.nominal_W_per_m2K *
        evaluate_speed_law(conductance.law, state.speed_rpm, boundaries.reference_speed_rpm, state.load);
  }
  for (Eigen::Index i = 0; i < values.heat_W.size(); ++i) {
    const rom::HeatSource& source = boundaries.sources[static_cast<std::size_t>(i)];
    values.heat_W[i] = factors.heat[i] * source.nominal_W *
                       evaluate_speed_law(source.law, state.speed_rpm, boundaries.reference_speed_rpm, state.load);
  }
  values.environment_K = state.environment_K;
}

}  // namespace spindle_twin::correction
