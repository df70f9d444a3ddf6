#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Sets at corners of the box: there errors are largest, but a drive cycle is seldom near one in all directions.
constexpr double rich_corner_share = 0.1;
/// Starts with everything at one temperature; the others start from the steady state of another operating state.
constexpr double uniform_start_share = 0.3;
constexpr double uniform_spread_K = 5.0;
constexpr double rich_spread_K = 8.0;
constexpr double rich_rest_share = 0.2;
constexpr int jumps_per_set = 2;
/// Of sets: the coolant stands behind the first jump and comes back at the next. Cold coolant on warm walls errs most,
/// within the first seconds, and among random jumps it is seldom.
constexpr double coolant_returns_share = 0.35;
using CoolantOfStates = std::array<Coolant, 1 + jumps_per_set>;
constexpr CoolantOfStates coolant_that_returns = {Coolant::flows, Coolant::stands, Coolant::flows};
constexpr CoolantOfStates any_coolant = {Coolant::flows, Coolant::flows_or_stands, Coolant::flows_or_stands};
/// Implicit steps behind a jump, each up to step_spread times longer or shorter.
constexpr std::array<double, 3> steps_s = {0.8, 6.0, 100.0};
constexpr double step_spread = 3.7;
constexpr int fields_per_set = 1 + jumps_per_set * static_cast<int>(steps_s.size());
constexpr int dual_shifts = static_cast<int>(steps_s.size());
constexpr double dual_steady_share = 0.4;

/// Sets whose terms are summed and whose dual solutions are multiplied at once, and sums of such products that are kept
/// until they are added up.
constexpr int sets_at_once = 8;
constexpr int sums_at_once = 2;

struct Snapshots {
  Eigen::MatrixXd fields, duals;  ///< a column each
};

/// A random parameter set and the inputs along its history: first ones, then those behind each jump.
class ParameterSet {
 public:
  ParameterSet(const RichModel& rich, const rom::Boundaries& boundaries, const ReduceOptions& options,
               std::uint32_t set)
      : rich_(rich), boundaries_(boundaries), random_(options.seed, StreamPurpose::rich_snapshots, set) {
    const bool corner = random_.uniform(0.0, 1.0) < rich_corner_share;
    rom::CorrectionFactors factors = rom::no_correction(boundaries);
    factors.conductance = random_conductance_factors(boundaries, options.box, corner, random_);
    const bool coolant_returns = random_.uniform(0.0, 1.0) < coolant_returns_share;
    const CoolantOfStates& coolant = coolant_returns ? coolant_that_returns : any_coolant;
    for (std::size_t i = 0; i < inputs_.size(); ++i) {
      const rom::OperatingState state =
          random_state(boundaries, options.box, {rich_spread_K, rich_rest_share, coolant[i]}, random_);
      inputs_[i] = rom::make_boundary_values(boundaries);
      rom::evaluate_boundaries(boundaries, state, factors, inputs_[i]);
    }
  }

  const rom::BoundaryValues& inputs(std::size_t state) const { return inputs_[state]; }

  /// Fields along the history, and dual solutions behind its last jump. `held_by(state)`: a model that holds the
  /// conductances of these inputs.
  template <typename HeldBy>
  Snapshots solve(const rom::CoolantSegments& segments, const HeldBy& held_by) {
    const DenseModel& model = rich_.dense;
    const auto hold = [&](std::size_t state) {
      HeldModel held = held_by(state);
      hold_inputs(model, boundaries_, segments, inputs_[state], boundaries_.reference_temperature_K, held);
      return held;
    };
    Snapshots snapshots;
    snapshots.fields.resize(model.capacity.rows(), fields_per_set);
    Eigen::Index next_field = 0, next_dual = 0;
    const Eigen::Index rows = rich_.outputs.cols();
    snapshots.duals.resize(model.capacity.rows(), dual_shifts * rows);
    const auto add_duals = [&](const ShiftedModel& shifted) {
      snapshots.duals.middleCols(next_dual++ * rows, rows) = shifted.solve_transposed(rich_.outputs);
    };

    Eigen::VectorXd rise_K;
    if (random_.uniform(0.0, 1.0) < uniform_start_share) {
      rise_K = random_.uniform(-uniform_spread_K, uniform_spread_K) * model.uniform;
    } else {
      const HeldModel held = hold(0);
      rise_K = ShiftedModel(model, held, 0.0).solve(held.drive);
    }
    snapshots.fields.col(next_field++) = rise_K;
    // Short, middle and long shifts of the dual solutions: those of the last steps, or in place of the longest none.
    const bool steady_duals = random_.uniform(0.0, 1.0) < dual_steady_share;
    for (std::size_t state = 1; state < inputs_.size(); ++state) {
      const HeldModel held = hold(state);
      const bool last = state + 1 == inputs_.size();
      for (std::size_t step = 0; step < steps_s.size(); ++step) {
        const double rate_per_s = 1.0 / (steps_s[step] * random_.log_uniform(1.0 / step_spread, step_spread));
        const ShiftedModel shifted(model, held, rate_per_s);
        rise_K = shifted.solve(held.drive + rate_per_s * (model.capacity * rise_K));
        snapshots.fields.col(next_field++) = rise_K;
        if (last && !(steady_duals && step + 1 == steps_s.size())) add_duals(shifted);
      }
      if (last && steady_duals) add_duals(ShiftedModel(model, held, 0.0));
    }
    return snapshots;
  }

 private:
  const RichModel& rich_;
  const rom::Boundaries& boundaries_;
  RandomStream random_;
  std::array<rom::BoundaryValues, 1 + jumps_per_set> inputs_;
};

/// The parameter sets from `begin` to `end`: fields to their places in `fields`; gives the sum of XXᵀ of their dual
/// solutions X.
Eigen::MatrixXd solve_sets(const RichModel& rich, const rom::Boundaries& boundaries, const ReduceOptions& options,
                           int begin, int end, Eigen::MatrixXd& fields) {
  constexpr int states_per_set = 1 + jumps_per_set;
  const rom::CoolantSegments segments = rom::coolant_segments(boundaries);
  std::vector<ParameterSet> sets;
  Eigen::MatrixXd conductances(rich.dense.conductance_terms.count(), (end - begin) * states_per_set);
  for (int set = begin; set < end; ++set) {
    sets.emplace_back(rich, boundaries, options, static_cast<std::uint32_t>(set));
    for (int state = 0; state < states_per_set; ++state) {
      conductances.col((set - begin) * states_per_set + state) =
          sets.back().inputs(static_cast<std::size_t>(state)).conductance_W_per_m2K;
    }
  }
  const PackedTerms sums = rich.dense.conductance_terms.sums(conductances);
  const Eigen::Index duals_per_set = dual_shifts * rich.outputs.cols();
  Eigen::MatrixXd duals(rich.dense.capacity.rows(), (end - begin) * duals_per_set);
  for (int i = 0; i < end - begin; ++i) {
    const auto held_by = [&](std::size_t state) {
      const Eigen::Index sum = i * states_per_set + static_cast<Eigen::Index>(state);
      return hold_conductances(rich.dense, sums, sum, conductances.col(sum));
    };
    const Snapshots own = sets[static_cast<std::size_t>(i)].solve(segments, held_by);
    fields.middleCols((begin + i) * fields_per_set, fields_per_set) = own.fields;
    duals.middleCols(i * duals_per_set, duals_per_set) = own.duals;
  }
  return product_with_transposed(duals);
}

}  // namespace

RichSnapshots rich_snapshots(const RichModel& rich, const rom::Boundaries& boundaries, const ReduceOptions& options,
                             const Progress& progress) {
  const Eigen::Index states = rich.dense.capacity.rows();
  RichSnapshots all;
  all.fields.resize(states, options.rich_sets * fields_per_set);
  all.dual_moments.setZero(states, states);
  // Sums of products are added up in the order of the sets, whatever the number of threads.
  constexpr int sets_per_round = sets_at_once * sums_at_once;
  for (int first = 0; first < options.rich_sets; first += sets_per_round) {
    const int sets = std::min(sets_per_round, options.rich_sets - first);
    std::array<Eigen::MatrixXd, sums_at_once> sums;
    for_each_index((sets + sets_at_once - 1) / sets_at_once, options.threads, [&](int sum, int) {
      const int begin = first + sum * sets_at_once, end = std::min(begin + sets_at_once, first + sets);
      sums[static_cast<std::size_t>(sum)] = solve_sets(rich, boundaries, options, begin, end, all.fields);
    });
    for (const Eigen::MatrixXd& sum : sums) {
      if (sum.size() > 0) all.dual_moments += sum;
    }
    if (progress) progress("network snapshots", static_cast<double>(first + sets) / options.rich_sets);
  }
  return all;
}

}  // namespace spindle_twin::fem_offline
