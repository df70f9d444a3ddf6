#include <algorithm>
#include <array>
#include <vector>

#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/nodal.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr int sets = 1200;
/// Seldom reached: a long shaft takes 270. Each is one more row to multiply per cycle.
constexpr std::size_t most_candidates = 400;
constexpr double good_enough_K = 0.003;
/// Maxima are what the certificate, the displays and the alarms use.
constexpr double weight_of_minimum = 0.3;
constexpr double candidate_spread_K = 10.0;
/// Every so many sets begin with everything at one temperature; the others in the steady state of some inputs.
constexpr int uniform_start_every = 4;
/// Before the last change none, one or two other states are held, each for a time between these. Coolant may stand
/// there, and the walls that it meets afterwards are warm.
constexpr int most_held_states = 2;
constexpr double shortest_held_s = 60.0, longest_held_s = 1800.0;
/// Of the last changes: the spindle stops. What was hottest at a contact then cools there first, and the place of the
/// maximum moves into the part within seconds.
constexpr double candidate_rest_share = 0.35;
/// Times after the last change of the operating state at which fields are taken.
constexpr std::array<double, 7> times_s = {0.5, 2.0, 6.0, 20.0, 80.0, 300.0, 1500.0};

/// Fields in the model's coordinates, one column each: steady ones, and those at times_s behind the last of several
/// changes of the operating state, from one to the next by a step (K + C/t) T = Bq + Σ gKⱼ1 T_env + C/t T_before of the
/// implicit Euler rule. Single precision (0.03 mK) is enough to tell where a part is hottest.
Eigen::MatrixXf physical_fields(const DenseModel& model, const rom::Boundaries& boundaries,
                                const ReduceOptions& options) {
  const Eigen::Index per_set = 2 + static_cast<Eigen::Index>(times_s.size());
  Eigen::MatrixXf fields(model.capacity.rows(), sets * per_set);
  const rom::CoolantSegments segments = rom::coolant_segments(boundaries);
  for_each_index(sets, options.threads, [&](int set, int) {
    RandomStream random(options.seed, StreamPurpose::candidates, static_cast<std::uint32_t>(set));
    rom::CorrectionFactors factors = rom::no_correction(boundaries);
    factors.conductance = random_conductance_factors(boundaries, options.box, set % 5 < 2, random);
    rom::BoundaryValues values = rom::make_boundary_values(boundaries);
    HeldModel held;
    const auto hold_random_state = [&](double rest_share, Coolant coolant) {
      const rom::OperatingState state =
          random_state(boundaries, options.box, {candidate_spread_K, rest_share, coolant}, random);
      rom::evaluate_boundaries(boundaries, state, factors, values);
      hold_inputs(model, boundaries, segments, values, 0.0, held);
    };
    const auto solve = [&](double rate_per_s, const Eigen::VectorXd& before_K) {
      const Eigen::VectorXd heat_W = held.drive + rate_per_s * (model.capacity * before_K);
      return ShiftedModel(model, held, rate_per_s).solve(heat_W);
    };
    const Eigen::VectorXd uniform_K = boundaries.reference_temperature_K * model.uniform;
    Eigen::Index column = set * per_set;
    hold_random_state(0.0, Coolant::flows);
    fields.col(column++) = solve(0.0, uniform_K).cast<float>();
    hold_random_state(0.0, Coolant::flows);
    Eigen::VectorXd before_K = solve(0.0, uniform_K);
    fields.col(column++) = before_K.cast<float>();
    if (set % uniform_start_every == 0) before_K = uniform_K;
    for (int state = 0; state < set % (most_held_states + 1); ++state) {
      hold_random_state(0.0, Coolant::flows_or_stands);
      before_K = solve(1.0 / random.log_uniform(shortest_held_s, longest_held_s), before_K);
    }
    hold_random_state(candidate_rest_share, Coolant::flows_or_stands);
    double since_jump_s = 0.0;
    for (const double time_s : times_s) {
      before_K = solve(1.0 / (time_s - since_jump_s), before_K);
      fields.col(column++) = before_K.cast<float>();
      since_jump_s = time_s;
    }
  });
  return fields;
}

/// Where each field has its extremes on a part.
struct Extremes {
  std::vector<Eigen::Index> hottest, coldest;  ///< by field: rows
};

/// Gives the temperatures of these rows to `visit(first field, temperatures_K)` by blocks of fields: all of them would
/// take more memory than anything else of a build.
template <typename Visit>
void for_each_block_of_fields(const Eigen::MatrixXf& rows, const Eigen::MatrixXf& fields, const Visit& visit) {
  constexpr Eigen::Index columns_per_block = 128;
  for (Eigen::Index first = 0; first < fields.cols(); first += columns_per_block) {
    const Eigen::Index width = std::min(columns_per_block, fields.cols() - first);
    visit(first, product(rows, fields.middleCols(first, width)));
  }
}

Extremes extremes_of(const Eigen::MatrixXf& rows, const Eigen::MatrixXf& fields) {
  const auto count = static_cast<std::size_t>(fields.cols());
  Extremes extremes{std::vector<Eigen::Index>(count), std::vector<Eigen::Index>(count)};
  for_each_block_of_fields(rows, fields, [&](Eigen::Index first, const Eigen::MatrixXf& block_K) {
    for (Eigen::Index i = 0; i < block_K.cols(); ++i) {
      const auto field = static_cast<std::size_t>(first + i);
      block_K.col(i).maxCoeff(&extremes.hottest[field]);
      block_K.col(i).minCoeff(&extremes.coldest[field]);
    }
  });
  return extremes;
}

/// The rows in which some field has an extreme, in order; `extremes` then counts in them.
std::vector<Eigen::Index> keep_rows(Extremes& extremes) {
  std::vector<Eigen::Index> kept = extremes.hottest;
  kept.insert(kept.end(), extremes.coldest.begin(), extremes.coldest.end());
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  for (auto* rows : {&extremes.hottest, &extremes.coldest}) {
    for (Eigen::Index& row : *rows) row = std::lower_bound(kept.begin(), kept.end(), row) - kept.begin();
  }
  return kept;
}

/// Adds, as long as it helps, the point at which the field with the largest shortfall has its extreme. Only points that
/// are one somewhere can be chosen: their temperatures are kept alone.
std::vector<int> greedy_extremes(const Eigen::MatrixXf& rows, const Eigen::MatrixXf& fields) {
  Extremes extremes = extremes_of(rows, fields);
  const std::vector<Eigen::Index> kept = keep_rows(extremes);
  const Eigen::Index count = fields.cols();
  Eigen::MatrixXf at_points_K(static_cast<Eigen::Index>(kept.size()), count);
  for_each_block_of_fields(rows(kept, Eigen::all), fields, [&](Eigen::Index first, const Eigen::MatrixXf& block_K) {
    at_points_K.middleCols(first, block_K.cols()) = block_K;
  });

  std::vector<int> chosen;
  constexpr float beyond_K = 1e30F;
  Eigen::VectorXf high = Eigen::VectorXf::Constant(count, -beyond_K), low = Eigen::VectorXf::Constant(count, beyond_K);
  while (chosen.size() < most_candidates) {
    double worst_K = good_enough_K;
    Eigen::Index next = -1;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::Index hottest = extremes.hottest[static_cast<std::size_t>(i)];
      const Eigen::Index coldest = extremes.coldest[static_cast<std::size_t>(i)];
      const double above_K = static_cast<double>(at_points_K(hottest, i)) - high[i];
      const double below_K = weight_of_minimum * (static_cast<double>(low[i]) - at_points_K(coldest, i));
      if (above_K > worst_K) worst_K = above_K, next = hottest;
      if (below_K > worst_K) worst_K = below_K, next = coldest;
    }
    if (next < 0) break;
    chosen.push_back(static_cast<int>(kept[static_cast<std::size_t>(next)]));
    high = high.cwiseMax(at_points_K.row(next).transpose());
    low = low.cwiseMin(at_points_K.row(next).transpose());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

PartExtremes find_part_extremes(const AffineModel& model, const Eigen::MatrixXd& basis, const DenseModel& dense,
                                const ReduceOptions& options) {
  const Eigen::MatrixXf fields = physical_fields(dense, model.boundaries, options);
  PartExtremes extremes(model.parts.size());
  for_each_index(static_cast<int>(model.parts.size()), options.threads, [&](int index, int) {
    const auto part = static_cast<std::size_t>(index);
    extremes[part] = greedy_extremes(basis(model.parts[part].dofs, Eigen::all).cast<float>(), fields);
  });
  return extremes;
}

void add_part_extremes(const AffineModel& model, const NodalCoordinates& nodal, const PartExtremes& extremes,
                       rom::Network& network) {
  for (std::size_t part = 0; part < model.parts.size(); ++part) {
    network.parts[part].candidate_rows = extreme_rows(model.parts[part], extremes[part], nodal.interpolant);
  }
}

}  // namespace spindle_twin::fem_offline
