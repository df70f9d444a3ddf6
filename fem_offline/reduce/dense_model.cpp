#include "fem_offline/reduce/dense_model.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// What the liquid carries from segment to segment: conduction −= S Γ U A⁻¹ Sᵀ, drive −= S Γ U T_inlet.
void couple(const DenseModel& model, const rom::CoolantSegments& segments, const rom::BoundaryValues& values,
            double zero_K, HeldModel& held) {
  const Eigen::Index count = segments.count();
  Eigen::MatrixXd upstream(count, count);
  Eigen::VectorXd inlet_K(count), film_W_per_m2K(count);
  rom::coolant_upstream(segments, values, upstream);
  for (Eigen::Index s = 0; s < count; ++s) {
    const auto segment = static_cast<std::size_t>(s);
    film_W_per_m2K[s] = values.conductance_W_per_m2K[segments.conductance[segment]];
    inlet_K[s] = values.environment_K[segments.inlet[segment]] - zero_K;
  }
  const Eigen::MatrixXd walls_m2 = model.walls_m2(Eigen::all, segments.conductance);
  const Eigen::MatrixXd heat = walls_m2 * film_W_per_m2K.asDiagonal() * upstream;
  held.drive -= heat * inlet_K;
  held.conduction -= heat * segments.area_m2.cwiseInverse().asDiagonal() * walls_m2.transpose();
}

}  // namespace

void hold_inputs(const DenseModel& model, const rom::Boundaries& boundaries, const rom::CoolantSegments& segments,
                 const rom::BoundaryValues& values, double zero_K, HeldModel& held) {
  held.conduction = model.conduction;
  held.drive = model.source_distribution * values.heat_W;
  for (std::size_t j = 0; j < model.conductance_terms.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    const double g = values.conductance_W_per_m2K[column];
    const int environment = boundaries.conductances[j].environment;
    held.conduction += g * model.conductance_terms[j];
    if (environment >= 0) held.drive += g * (values.environment_K[environment] - zero_K) * model.walls_m2.col(column);
  }
  if (segments.count() > 0) couple(model, segments, values, zero_K, held);
}

rom::OperatingState random_state(const rom::Boundaries& boundaries, const ParameterBox& box, double spread_K,
                                 RandomStream& random) {
  rom::OperatingState state = boundaries.operating;
  state.speed_rpm = random.uniform(0.0, box.speed_high_rpm);
  state.load = random.uniform(0.0, box.load_high);
  for (double& environment_K : state.environment_K) environment_K += random.uniform(-spread_K, spread_K);
  state.flow_kg_per_s = random_flow_kg_per_s(boundaries, box, random);
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    double& flow_kg_per_s = state.flow_kg_per_s[static_cast<Eigen::Index>(c)];
    if (flow_kg_per_s == 0.0) flow_kg_per_s = box.flow_low * flow_scale_kg_per_s(boundaries, c);
  }
  return state;
}

}  // namespace spindle_twin::fem_offline
