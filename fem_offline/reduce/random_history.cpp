#include "fem_offline/reduce/random_history.hpp"

#include <array>

#include "fem_offline/reduce/dense_model.hpp"
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

}  // namespace

History random_history(const rom::Boundaries& boundaries, const ReduceOptions& options, StreamPurpose purpose,
                       std::uint32_t set) {
  RandomStream random(options.seed, purpose, set);
  const bool corner = random.uniform(0.0, 1.0) < history_corner_share;
  rom::CorrectionFactors factors = rom::no_correction(boundaries);
  factors.conductance = random_conductance_factors(boundaries, options.box, corner, random);
  History history;
  const auto jump = [&](Coolant coolant) {
    const rom::OperatingState state =
        random_state(boundaries, options.box, {history_spread_K, history_rest_share, coolant}, random);
    history.states.push_back(rom::make_boundary_values(boundaries));
    rom::evaluate_boundaries(boundaries, state, factors, history.states.back());
  };
  jump(Coolant::flows);
  if (random.uniform(0.0, 1.0) < history_uniform_share) {
    history.uniform_rise_K = random.uniform(-history_spread_K, history_spread_K);
  }
  for (int k = 0; k < jumps_per_history; ++k) {
    jump(Coolant::flows_or_stands);
    for (const double middle_s : history_steps_s) {
      history.steps.push_back(
          {history.states.size() - 1, middle_s * random.log_uniform(1.0 / history_step_spread, history_step_spread)});
    }
  }
  return history;
}

}  // namespace spindle_twin::fem_offline
