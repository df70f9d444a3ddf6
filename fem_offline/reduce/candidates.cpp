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
/// How long a state is held in which coolant may stand: the walls that it meets afterwards are warm.
constexpr double standing_s = 900.0;
/// Times after a change of the operating state at which fields are taken.
constexpr std::array<double, 7> times_s = {0.5, 2.0, 6.0, 20.0, 80.0, 300.0, 1500.0};

/// Node temperatures, one column per field: steady ones, and one step of the implicit Euler rule
/// (K + C/t) T = Bq + Σ gKⱼ1 T_env + C/t T_before of length t from the steady state of another operating state.
Eigen::MatrixXd physical_fields(const rom::Network& network, const ReduceOptions& options) {
  const Eigen::Index count = network.capacity_J_per_K.rows();
  const Eigen::Index per_set = 2 + static_cast<Eigen::Index>(times_s.size());
  Eigen::MatrixXd fields(count, sets * per_set);
  const rom::Boundaries& boundaries = network.boundaries;
  const DenseModel model = dense_model_of(network);
  const rom::CoolantSegments segments = rom::coolant_segments(boundaries);
  for_each_index(sets, options.threads, [&](int set, int) {
    RandomStream random(options.seed, StreamPurpose::candidates, static_cast<std::uint32_t>(set));
    rom::CorrectionFactors factors = rom::no_correction(boundaries);
    factors.conductance = random_conductance_factors(boundaries, options.box, set % 5 < 2, random);
    rom::BoundaryValues values = rom::make_boundary_values(boundaries);
    HeldModel held;
    const auto apply = [&](const rom::OperatingState& state) {
      rom::evaluate_boundaries(boundaries, state, factors, values);
      hold_inputs(model, boundaries, segments, values, 0.0, held);
    };
    const auto solve = [&](double rate_per_s, const Eigen::VectorXd& before_K) {
      const Eigen::VectorXd heat_W = held.drive + rate_per_s * (model.capacity * before_K);
      return ShiftedModel(model, held, rate_per_s).solve(heat_W);
    };
    const Eigen::VectorXd uniform_K = Eigen::VectorXd::Constant(count, boundaries.reference_temperature_K);
    Eigen::Index column = set * per_set;
    apply(random_state(boundaries, options.box, candidate_spread_K, Coolant::flows, random));
    fields.col(column++) = solve(0.0, uniform_K);
    apply(random_state(boundaries, options.box, candidate_spread_K, Coolant::flows, random));
    Eigen::VectorXd before_K = solve(0.0, uniform_K);
    fields.col(column++) = before_K;
    if (set % 3 == 0) before_K = uniform_K;
    if (set % 3 == 1) {
      apply(random_state(boundaries, options.box, candidate_spread_K, Coolant::flows_or_stands, random));
      before_K = solve(1.0 / standing_s, before_K);
    }
    apply(random_state(boundaries, options.box, candidate_spread_K, Coolant::flows_or_stands, random));
    double since_jump_s = 0.0;
    for (const double time_s : times_s) {
      before_K = solve(1.0 / (time_s - since_jump_s), before_K);
      fields.col(column++) = before_K;
      since_jump_s = time_s;
    }
  });
  return fields;
}

/// Adds, as long as it helps, the point at which the field with the largest shortfall has its extreme.
std::vector<int> greedy_extremes(const Eigen::MatrixXf& part_fields) {
  const Eigen::Index count = part_fields.cols();
  Eigen::VectorXi hottest(count), coldest(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    part_fields.col(i).maxCoeff(&hottest[i]);
    part_fields.col(i).minCoeff(&coldest[i]);
  }
  std::vector<int> chosen;
  constexpr float beyond_K = 1e30F;
  Eigen::VectorXf high = Eigen::VectorXf::Constant(count, -beyond_K), low = Eigen::VectorXf::Constant(count, beyond_K);
  while (chosen.size() < most_candidates) {
    double worst_K = good_enough_K;
    int next = -1;
    for (Eigen::Index i = 0; i < count; ++i) {
      const double above_K = static_cast<double>(part_fields(hottest[i], i)) - high[i];
      const double below_K = weight_of_minimum * (static_cast<double>(low[i]) - part_fields(coldest[i], i));
      if (above_K > worst_K) worst_K = above_K, next = hottest[i];
      if (below_K > worst_K) worst_K = below_K, next = coldest[i];
    }
    if (next < 0) break;
    chosen.push_back(next);
    high = high.cwiseMax(part_fields.row(next).transpose());
    low = low.cwiseMin(part_fields.row(next).transpose());
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

/// Temperatures of a part's unknowns in every field, to 0.03 mK: half the memory, of which this takes the most.
Eigen::MatrixXf fields_of_part(const Eigen::MatrixXd& rows, const Eigen::MatrixXd& fields) {
  constexpr Eigen::Index columns_per_block = 128;
  Eigen::MatrixXf of_part(rows.rows(), fields.cols());
  for (Eigen::Index first = 0; first < fields.cols(); first += columns_per_block) {
    const Eigen::Index width = std::min(columns_per_block, fields.cols() - first);
    of_part.middleCols(first, width) = product(rows, fields.middleCols(first, width)).cast<float>();
  }
  return of_part;
}

}  // namespace

PartExtremes find_part_extremes(const AffineModel& model, const NodalCoordinates& nodal, const ReduceOptions& options,
                                const rom::Network& network) {
  const Eigen::MatrixXd fields = physical_fields(network, options);
  PartExtremes extremes(model.parts.size());
  for_each_index(static_cast<int>(model.parts.size()), options.threads, [&](int index, int) {
    const auto part = static_cast<std::size_t>(index);
    const Eigen::MatrixXd rows = nodal.interpolant(model.parts[part].dofs, Eigen::all);
    extremes[part] = greedy_extremes(fields_of_part(rows, fields));
  });
  return extremes;
}

void add_part_extremes(const AffineModel& model, const NodalCoordinates& nodal, const PartExtremes& extremes,
                       rom::Network& network) {
  for (std::size_t part = 0; part < model.parts.size(); ++part) {
    std::vector<int> unknowns;
    for (const int point : extremes[part]) unknowns.push_back(model.parts[part].dofs[static_cast<std::size_t>(point)]);
    network.parts[part].candidate_rows = nodal.interpolant(unknowns, Eigen::all);
  }
}

}  // namespace spindle_twin::fem_offline
