#include "rom/boundary_values/evaluate_boundaries.hpp"

#include <cmath>
#include <limits>

#include "rom/boundary_values/held_law.hpp"
#include "rom/laws/channel_law.hpp"

namespace spindle_twin::rom {
namespace {

constexpr double not_read_W = std::numeric_limits<double>::quiet_NaN();

/// Film coefficients of the circuits' segments become those of the channel law.
void apply_channel_law(const Boundaries& boundaries, const OperatingState& state, BoundaryValues& values) {
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const CoolantCircuit& circuit = boundaries.circuits[c];
    const auto index = static_cast<Eigen::Index>(c);
    values.coolant_W_per_K[index] = state.flow_kg_per_s[index] * circuit.heat_capacity_J_per_kgK;
    const double flow_W_per_K = std::abs(values.coolant_W_per_K[index]);
    for (const int segment : circuit.segments) {
      double& film_W_per_m2K = values.conductance_W_per_m2K[segment];
      const double area_m2 = boundaries.conductances[static_cast<std::size_t>(segment)].area_m2;
      film_W_per_m2K = channel_W_per_m2K(film_W_per_m2K, area_m2, flow_W_per_K);
    }
  }
}

/// Empty means `neutral` for every node; what is sized once stays so, as the cycle may not call the heap.
void copy_per_node(const Eigen::VectorXd& from, double neutral, Eigen::VectorXd& to) {
  if (from.size() > 0) {
    to = from;
  } else {
    to.setConstant(neutral);
  }
}

}  // namespace

CorrectionFactors no_correction(const Boundaries& boundaries) {
  CorrectionFactors factors;
  factors.heat = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(boundaries.sources.size()));
  factors.conductance = Eigen::VectorXd::Ones(static_cast<Eigen::Index>(boundaries.conductances.size()));
  return factors;
}

BoundaryValues make_boundary_values(const Boundaries& boundaries) {
  BoundaryValues values;
  values.conductance_W_per_m2K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.conductances.size()));
  values.heat_W = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.sources.size()));
  values.environment_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.environments.size()));
  values.coolant_W_per_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(boundaries.circuits.size()));
  values.laws.flow_kg_per_s = values.coolant_W_per_K;
  values.laws.heat_factor = values.heat_W;
  values.laws.conductance_factor = values.conductance_W_per_m2K;
  return values;
}

void evaluate_boundaries(const Boundaries& boundaries, const OperatingState& state, const CorrectionFactors& factors,
                         BoundaryValues& values) {
  values.environment_K = state.environment_K;
  set_machine(state, values.laws);
  values.laws.heat_factor = factors.heat;
  values.laws.conductance_factor = factors.conductance;
  values.laws.follow = true;
  const double reference_rpm = boundaries.reference_speed_rpm;
  for (Eigen::Index j = 0; j < values.conductance_W_per_m2K.size(); ++j) {
    values.conductance_W_per_m2K[j] =
        held_conductance_W_per_m2K(boundaries.conductances[static_cast<std::size_t>(j)], reference_rpm,
                                   factors.conductance[j], values.laws, values.environment_K);
  }
  Eigen::Index measured = 0;
  for (Eigen::Index i = 0; i < values.heat_W.size(); ++i) {
    const HeatSource& source = boundaries.sources[static_cast<std::size_t>(i)];
    values.heat_W[i] = held_heat_W(source, reference_rpm, factors.heat[i], values.laws, values.environment_K);
    if (!source.measured) continue;
    const double read_W = measured < state.heat_W.size() ? state.heat_W[measured] : not_read_W;
    if (!std::isnan(read_W)) values.heat_W[i] = factors.heat[i] * read_W;
    ++measured;
  }
  apply_channel_law(boundaries, state, values);
  copy_per_node(factors.node_heat_W, 0.0, values.node_heat_W);
  copy_per_node(factors.capacity_factor, 1.0, values.capacity_factor);
}

}  // namespace spindle_twin::rom
