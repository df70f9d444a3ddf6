#include "fem_offline/reduce/full_histories.hpp"

#include <array>

#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/solve/coolant_coupling.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double history_corner_share = 0.3;
/// Starts with everything at one temperature; the others start from the steady state of another operating state.
constexpr double history_uniform_share = 0.2;
constexpr double history_spread_K = 8.0;
constexpr double history_rest_share = 0.2;
constexpr int jumps_per_history = 2;
/// Implicit steps behind a jump, each up to history_step_spread times longer or shorter.
constexpr std::array<double, 4> history_steps_s = {0.7, 4.0, 25.0, 200.0};
constexpr double history_step_spread = 2.5;
constexpr int fields_per_history = 1 + jumps_per_history * static_cast<int>(history_steps_s.size());

}  // namespace

Eigen::MatrixXd full_history(const AffineModel& model, ThermalSystem& system, const CholeskyFactor& analysed,
                             const ReduceOptions& options, std::uint32_t set) {
  const rom::Boundaries& boundaries = model.boundaries;
  const double datum_K = boundaries.reference_temperature_K;
  RandomStream random(options.seed, StreamPurpose::full_histories, set);
  const bool corner = random.uniform(0.0, 1.0) < history_corner_share;
  rom::CorrectionFactors factors = rom::no_correction(boundaries);
  factors.conductance = random_conductance_factors(boundaries, options.box, corner, random);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  CoolantCoupling coupling(model);
  Eigen::VectorXd load_W;
  const auto jump = [&](Coolant coolant) {
    rom::OperatingState state = random_state(boundaries, options.box, history_spread_K, coolant, random);
    if (random.uniform(0.0, 1.0) < history_rest_share) state.speed_rpm = state.load = 0.0;
    rom::evaluate_boundaries(boundaries, state, factors, values);
    system.set_conductances(values.conductance_W_per_m2K);
    coupling.hold(values);
    load_W = system.load_W(values, datum_K);
    coupling.add_load(datum_K, load_W);
  };

  Eigen::MatrixXd fields(model.capacity_J_per_K.rows(), fields_per_history);
  Eigen::VectorXd rise_K;
  jump(Coolant::flows);
  if (random.uniform(0.0, 1.0) < history_uniform_share) {
    rise_K.setConstant(fields.rows(), random.uniform(-history_spread_K, history_spread_K));
  } else {
    CoupledFactor(CholeskyFactor(analysed, system.conduction_lower()), coupling, 1.0).solve(load_W, coupling, rise_K);
  }
  Eigen::Index column = 0;
  fields.col(column++) = rise_K;
  const auto capacity = system.capacity_lower().selfadjointView<Eigen::Lower>();
  for (int k = 0; k < jumps_per_history; ++k) {
    jump(Coolant::flows_or_stands);
    for (const double middle_s : history_steps_s) {
      const double step_s = middle_s * random.log_uniform(1.0 / history_step_spread, history_step_spread);
      CoupledFactor factor(CholeskyFactor(analysed, system.combined_lower(step_s)), coupling, step_s);
      const Eigen::VectorXd heat_J = step_s * load_W + capacity * rise_K;
      factor.solve(heat_J, coupling, rise_K);
      fields.col(column++) = rise_K;
    }
  }
  return fields;
}

}  // namespace spindle_twin::fem_offline
