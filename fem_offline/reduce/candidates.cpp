#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "correction/boundaries/evaluate_boundaries.hpp"
#include "fem_offline/reduce/nodal.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "rom/integrate/coolant.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr int sets = 1200;
/// Seldom reached: a long shaft takes 270. Each is one more row to multiply per cycle.
constexpr std::size_t most_candidates = 400;
constexpr double good_enough_K = 0.003;
/// Maxima are what the certificate, the displays and the alarms use.
constexpr double weight_of_minimum = 0.3;
/// Times after a change of the operating state at which fields are taken.
constexpr std::array<double, 7> times_s = {0.5, 2.0, 6.0, 20.0, 80.0, 300.0, 1500.0};

rom::OperatingState random_state(const rom::Boundaries& boundaries, const ParameterBox& box, RandomStream& random) {
  rom::OperatingState state = boundaries.operating;
  state.speed_rpm = random.uniform(0.0, box.speed_high_rpm);
  state.load = random.uniform(0.0, box.load_high);
  for (double& environment_K : state.environment_K) environment_K += random.uniform(-10.0, 10.0);
  state.flow_kg_per_s = random_flow_kg_per_s(boundaries, box, random);
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    // Steady fields are asked for, and without flow there may be none.
    double& flow_kg_per_s = state.flow_kg_per_s[static_cast<Eigen::Index>(c)];
    if (flow_kg_per_s == 0.0) flow_kg_per_s = box.flow_low * flow_scale_kg_per_s(boundaries, c);
  }
  return state;
}

/// What the liquid carries from segment to segment: conduction −= S Γ U A⁻¹ Sᵀ, drive −= S Γ U T_inlet.
void couple(const rom::CoolantSegments& segments, const std::vector<Eigen::MatrixXd>& terms,
            const rom::BoundaryValues& values, Eigen::MatrixXd& conduction, Eigen::VectorXd& drive) {
  const Eigen::Index count = segments.count();
  Eigen::MatrixXd upstream(count, count), walls(drive.size(), count);
  Eigen::VectorXd inlet_K(count), film_W_per_m2K(count);
  rom::coolant_upstream(segments, values, upstream);
  for (Eigen::Index s = 0; s < count; ++s) {
    const auto segment = static_cast<std::size_t>(s);
    walls.col(s) = terms[static_cast<std::size_t>(segments.conductance[segment])].rowwise().sum();
    film_W_per_m2K[s] = values.conductance_W_per_m2K[segments.conductance[segment]];
    inlet_K[s] = values.environment_K[segments.inlet[segment]];
  }
  const Eigen::MatrixXd heat = walls * film_W_per_m2K.asDiagonal() * upstream;
  drive -= heat * inlet_K;
  conduction -= heat * segments.area_m2.cwiseInverse().asDiagonal() * walls.transpose();
}

/// Node temperatures, one column per field: steady ones, and one step of the implicit Euler rule
/// (K + C/t) T = Bq + Σ gKⱼ1 T_env + C/t T_before of length t from the steady state of another operating state.
Eigen::MatrixXd physical_fields(const rom::Network& network, const ReduceOptions& options) {
  const Eigen::Index count = network.capacity_J_per_K.rows();
  const Eigen::Index per_set = 2 + static_cast<Eigen::Index>(times_s.size());
  Eigen::MatrixXd fields(count, sets * per_set);
  const rom::Boundaries& boundaries = network.boundaries;
  std::vector<Eigen::MatrixXd> terms;
  for (const Eigen::MatrixXd& factor : network.factors_m) terms.emplace_back(factor * factor.transpose());
  const rom::CoolantSegments segments = rom::coolant_segments(boundaries);
  for_each_index(sets, options.threads, [&](int set, int) {
    RandomStream random(options.seed, StreamPurpose::candidates, static_cast<std::uint32_t>(set));
    rom::CorrectionFactors factors = correction::no_correction(boundaries);
    factors.conductance = random_conductance_factors(boundaries, options.box, set % 5 < 2, random);
    rom::BoundaryValues values = correction::make_boundary_values(boundaries);
    Eigen::MatrixXd conduction;
    Eigen::VectorXd drive;
    const auto apply = [&](const rom::OperatingState& state) {
      correction::evaluate_boundaries(boundaries, state, factors, values);
      conduction = network.conduction_W_per_K;
      drive = network.source_distribution * values.heat_W;
      for (std::size_t j = 0; j < terms.size(); ++j) {
        const double g = values.conductance_W_per_m2K[static_cast<Eigen::Index>(j)];
        const int environment = boundaries.conductances[j].environment;
        conduction += g * terms[j];
        if (environment >= 0) drive += g * values.environment_K[environment] * terms[j].rowwise().sum();
      }
      if (segments.count() > 0) couple(segments, terms, values, conduction, drive);
    };
    const auto solve = [&](double rate_per_s, const Eigen::VectorXd& before_K) {
      const Eigen::VectorXd held = drive + rate_per_s * (network.capacity_J_per_K * before_K);
      const Eigen::MatrixXd matrix = conduction + rate_per_s * network.capacity_J_per_K;
      if (segments.count() > 0) return Eigen::VectorXd(matrix.partialPivLu().solve(held));
      const Eigen::LLT<Eigen::MatrixXd> factor(matrix);
      if (factor.info() != Eigen::Success) throw std::runtime_error("the network is not positive definite");
      return Eigen::VectorXd(factor.solve(held));
    };
    const Eigen::VectorXd uniform_K = Eigen::VectorXd::Constant(count, boundaries.reference_temperature_K);
    Eigen::Index column = set * per_set;
    apply(random_state(boundaries, options.box, random));
    Eigen::VectorXd before_K = solve(0.0, uniform_K);
    fields.col(column++) = before_K;
    if (set % 3 == 0) before_K = uniform_K;
    apply(random_state(boundaries, options.box, random));
    fields.col(column++) = solve(0.0, uniform_K);
    for (const double time_s : times_s) fields.col(column++) = solve(1.0 / time_s, before_K);
  });
  return fields;
}

/// Adds, as long as it helps, the point at which the field with the largest shortfall has its extreme.
std::vector<int> greedy_extremes(const Eigen::MatrixXd& part_fields) {
  const Eigen::Index count = part_fields.cols();
  Eigen::VectorXi hottest(count), coldest(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    part_fields.col(i).maxCoeff(&hottest[i]);
    part_fields.col(i).minCoeff(&coldest[i]);
  }
  std::vector<int> chosen;
  Eigen::VectorXd high = Eigen::VectorXd::Constant(count, -1e300), low = Eigen::VectorXd::Constant(count, 1e300);
  while (chosen.size() < most_candidates) {
    double worst_K = good_enough_K;
    int next = -1;
    for (Eigen::Index i = 0; i < count; ++i) {
      const double above_K = part_fields(hottest[i], i) - high[i];
      const double below_K = weight_of_minimum * (low[i] - part_fields(coldest[i], i));
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

}  // namespace

void choose_candidates(const AffineModel& model, const NodalCoordinates& nodal, const ReduceOptions& options,
                       rom::Network& network) {
  const Eigen::MatrixXd fields = physical_fields(network, options);
  for_each_index(static_cast<int>(model.parts.size()), options.threads, [&](int index, int) {
    const std::size_t part = static_cast<std::size_t>(index);
    const Eigen::MatrixXd rows = nodal.interpolant(model.parts[part].dofs, Eigen::all);
    const std::vector<int> chosen = greedy_extremes(rows * fields);
    network.parts[part].candidate_rows = rows(chosen, Eigen::all);
  });
}

}  // namespace spindle_twin::fem_offline
