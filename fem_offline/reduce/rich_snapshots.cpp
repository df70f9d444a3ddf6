#include <algorithm>
#include <array>
#include <cmath>

#include "fem_offline/reduce/basis.hpp"
#include "fem_offline/reduce/dense_blas.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

/// Sets at corners of the box: there errors are largest, but a drive cycle is seldom near one in all directions.
constexpr double rich_corner_share = 0.2;
/// Starts with everything at one temperature; the others start from the steady state of another operating state.
constexpr double uniform_start_share = 0.3;
constexpr double uniform_spread_K = 5.0;
constexpr double rich_spread_K = 8.0;
constexpr double rich_rest_share = 0.2;
constexpr int jumps_per_set = 2;
/// Implicit steps behind a jump, each up to step_spread times longer or shorter.
constexpr std::array<double, 6> steps_s = {0.7, 2.5, 8.0, 30.0, 120.0, 600.0};
constexpr double step_spread = 1.6;
constexpr int fields_per_set = 1 + jumps_per_set * static_cast<int>(steps_s.size());
constexpr int dual_shifts = 3;
constexpr double dual_shift_low_per_s = 2e-4;
constexpr double dual_shift_high_per_s = 3.0;
constexpr double dual_steady_share = 0.4;

/// Sets whose dual solutions are multiplied at once, and sums of such products that are kept until they are added up.
constexpr int sets_at_once = 5;
constexpr int sums_at_once = 4;

struct Snapshots {
  Eigen::MatrixXd fields, duals;  ///< a column each
};

/// Snapshots of one parameter set.
Snapshots solve_set(const RichModel& rich, const rom::Boundaries& boundaries, const rom::CoolantSegments& segments,
                    const ReduceOptions& options, std::uint32_t set) {
  const DenseModel& model = rich.dense;
  RandomStream random(options.seed, StreamPurpose::rich_snapshots, set);
  const bool corner = random.uniform(0.0, 1.0) < rich_corner_share;
  rom::CorrectionFactors factors = rom::no_correction(boundaries);
  factors.conductance = random_conductance_factors(boundaries, options.box, corner, random);
  rom::BoundaryValues values = rom::make_boundary_values(boundaries);
  HeldModel held;
  const auto jump = [&](Coolant coolant) {
    rom::OperatingState state = random_state(boundaries, options.box, rich_spread_K, coolant, random);
    if (random.uniform(0.0, 1.0) < rich_rest_share) state.speed_rpm = state.load = 0.0;
    rom::evaluate_boundaries(boundaries, state, factors, values);
    hold_inputs(model, boundaries, segments, values, boundaries.reference_temperature_K, held);
  };

  Snapshots snapshots;
  snapshots.fields.resize(model.capacity.rows(), fields_per_set);
  Eigen::VectorXd rise_K;
  jump(Coolant::flows);
  if (random.uniform(0.0, 1.0) < uniform_start_share) {
    rise_K = random.uniform(-uniform_spread_K, uniform_spread_K) * model.uniform;
  } else {
    rise_K = ShiftedModel(model, held, 0.0).solve(held.drive);
  }
  Eigen::Index column = 0;
  snapshots.fields.col(column++) = rise_K;
  for (int k = 0; k < jumps_per_set; ++k) {
    jump(Coolant::flows_or_stands);
    for (const double middle_s : steps_s) {
      const double rate_per_s = 1.0 / (middle_s * random.log_uniform(1.0 / step_spread, step_spread));
      rise_K = ShiftedModel(model, held, rate_per_s).solve(held.drive + rate_per_s * (model.capacity * rise_K));
      snapshots.fields.col(column++) = rise_K;
    }
  }

  const Eigen::Index rows = rich.outputs.cols();
  snapshots.duals.resize(model.capacity.rows(), dual_shifts * rows);
  const double ratio = std::pow(dual_shift_high_per_s / dual_shift_low_per_s, 1.0 / dual_shifts);
  for (int k = 0; k < dual_shifts; ++k) {
    const double low_per_s = dual_shift_low_per_s * std::pow(ratio, k);
    double shift_per_s = random.log_uniform(low_per_s, ratio * low_per_s);
    if (k == 0 && random.uniform(0.0, 1.0) < dual_steady_share) shift_per_s = 0.0;
    snapshots.duals.middleCols(k * rows, rows) = ShiftedModel(model, held, shift_per_s).solve_transposed(rich.outputs);
  }
  return snapshots;
}

}  // namespace

RichSnapshots rich_snapshots(const RichModel& rich, const rom::Boundaries& boundaries, const ReduceOptions& options,
                             const Progress& progress) {
  const Eigen::Index states = rich.dense.capacity.rows();
  const Eigen::Index duals_per_set = dual_shifts * rich.outputs.cols();
  const rom::CoolantSegments segments = rom::coolant_segments(boundaries);
  RichSnapshots all;
  all.fields.resize(states, options.rich_sets * fields_per_set);
  all.dual_moments.setZero(states, states);
  // Sums of products are added up in the order of the sets, whatever the number of threads.
  constexpr int sets_per_round = sets_at_once * sums_at_once;
  for (int first = 0; first < options.rich_sets; first += sets_per_round) {
    const int sets = std::min(sets_per_round, options.rich_sets - first);
    std::array<Eigen::MatrixXd, sums_at_once> sums;
    for_each_index((sets + sets_at_once - 1) / sets_at_once, options.threads, [&](int sum, int) {
      const int begin = sum * sets_at_once, end = std::min(begin + sets_at_once, sets);
      Eigen::MatrixXd duals(states, (end - begin) * duals_per_set);
      for (int i = begin; i < end; ++i) {
        const int set = first + i;
        const Snapshots own = solve_set(rich, boundaries, segments, options, static_cast<std::uint32_t>(set));
        all.fields.middleCols(set * fields_per_set, fields_per_set) = own.fields;
        duals.middleCols((i - begin) * duals_per_set, duals_per_set) = own.duals;
      }
      sums[static_cast<std::size_t>(sum)] = product(duals, Eigen::MatrixXd(duals.transpose()));
    });
    for (const Eigen::MatrixXd& sum : sums) {
      if (sum.size() > 0) all.dual_moments += sum;
    }
    if (progress) progress("network snapshots", static_cast<double>(first + sets) / options.rich_sets);
  }
  return all;
}

}  // namespace spindle_twin::fem_offline
