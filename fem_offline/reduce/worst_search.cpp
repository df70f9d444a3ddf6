#include "fem_offline/reduce/worst_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "fem_offline/reduce/analysed_system.hpp"
#include "fem_offline/reduce/dense_model.hpp"
#include "fem_offline/reduce/drive_case.hpp"
#include "fem_offline/reduce/krylov_stepper.hpp"
#include "fem_offline/reduce/parallel.hpp"
#include "fem_offline/reduce/trajectory.hpp"
#include "fem_offline/solve/fe_solver.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/coolant.hpp"
#include "rom/integrate/cvode_stepper.hpp"
#include "rom/units.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr int kinds = 3;
constexpr int children_per_generation = 12;  // whatever the number of threads, so that results do not hang on it
constexpr double drawn_share = 0.25;
constexpr double corner_share = 0.5;
constexpr double uniform_jump_share = 0.25;
constexpr double rest_share = 0.15;
constexpr double standing_share = 1.0 / 6.0;
constexpr double backward_share = 1.0 / 6.0;
/// Outputs are compared so long after the jump, and at each doubling of that time.
constexpr double first_s = 0.5;

/// Coordinates of a jump, each 0 to 1: factors, how far every ambient has drifted in both states, start, then of both
/// states speed, load, surroundings, flows.
class JumpSpace {
 public:
  JumpSpace(const rom::Boundaries& boundaries, const ParameterBox& box) : boundaries_(boundaries), box_(box) {}

  Eigen::Index size() const { return factors() + environments() + 1 + 2 * state_size(); }

  JumpCase at(const Eigen::VectorXd& place) const {
    JumpCase jump;
    jump.factors = rom::no_correction(boundaries_);
    for (Eigen::Index j = 0; j < factors(); ++j) {
      const rom::Range range = factor_range(box_, boundaries_.conductances[static_cast<std::size_t>(j)]);
      jump.factors.conductance[j] = range.min * std::pow(range.max / range.min, place[j]);
    }
    const Eigen::VectorXd drifts = place.segment(factors(), environments());
    if (const double start = place[factors() + environments()]; start < uniform_jump_share) {
      const double datum_K = boundaries_.reference_temperature_K;
      jump.uniform_start_K = datum_K + drive_spread_K * (2.0 * start / uniform_jump_share - 1.0);
    }
    jump.before = state(place.segment(size() - 2 * state_size(), state_size()), drifts, Coolant::flows);
    jump.after = state(place.tail(state_size()), drifts, Coolant::flows_or_stands);
    return jump;
  }

 private:
  Eigen::Index factors() const { return static_cast<Eigen::Index>(boundaries_.conductances.size()); }
  Eigen::Index environments() const { return boundaries_.operating.environment_K.size(); }
  Eigen::Index state_size() const {
    return 2 + environments() + static_cast<Eigen::Index>(boundaries_.circuits.size());
  }

  rom::OperatingState state(const Eigen::VectorXd& place, const Eigen::VectorXd& drifts, Coolant coolant) const {
    rom::OperatingState state = boundaries_.operating;
    const bool rests = place[0] < rest_share;
    state.speed_rpm = rests ? 0.0 : box_.speed_high_rpm * (place[0] - rest_share) / (1.0 - rest_share);
    state.load = rests ? 0.0 : box_.load_high * place[1];
    for (Eigen::Index e = 0; e < environments(); ++e) {
      state.environment_K[e] += drive_spread_K * (2.0 * place[2 + e] - 1.0);
      const auto kind = boundaries_.environments[static_cast<std::size_t>(e)].kind;
      if (kind == rom::EnvironmentKind::ambient) state.environment_K[e] += drive_drift_K * (2.0 * drifts[e] - 1.0);
    }
    for (std::size_t c = 0; c < boundaries_.circuits.size(); ++c) {
      const auto index = static_cast<Eigen::Index>(c);
      state.flow_kg_per_s[index] = flow_kg_per_s(c, place[2 + environments() + index], coolant);
    }
    return state;
  }

  /// Stands, runs backwards, or forwards, on a logarithmic scale each.
  double flow_kg_per_s(std::size_t circuit, double place, Coolant coolant) const {
    const double scale_kg_per_s = flow_scale_kg_per_s(boundaries_, circuit);
    const auto flow = [&](double share) { return box_.flow_low * std::pow(box_.flow_high / box_.flow_low, share); };
    if (place < standing_share) return coolant == Coolant::flows ? box_.flow_low * scale_kg_per_s : 0.0;
    if (place < standing_share + backward_share)
      return -flow((place - standing_share) / backward_share) * scale_kg_per_s;
    return flow((place - standing_share - backward_share) / (1.0 - standing_share - backward_share)) * scale_kg_per_s;
  }

  const rom::Boundaries& boundaries_;
  const ParameterBox& box_;
};

/// Runs network and FE model through jumps.
class JumpComparison {
 public:
  JumpComparison(const rom::Network& network, const AffineModel& model)
      : network_(network),
        model_(model),
        dense_(dense_model_of(network)),
        segments_(rom::coolant_segments(network.boundaries)),
        operator_(std::make_shared<const rom::NetworkOperator>(network)),
        matrices_(model) {}

  /// Largest |network - FE model| of every output at the start and behind the jump, SI.
  Eigen::VectorXd errors(const JumpCase& jump) const {
    const rom::Boundaries& boundaries = network_.boundaries;
    rom::BoundaryValues values = rom::make_boundary_values(boundaries);
    const auto hold = [&](const rom::OperatingState& state) {
      rom::evaluate_boundaries(boundaries, state, jump.factors, values);
      values.laws.follow = false;  // as in trajectory.cpp: the basis is what is judged
    };
    hold(jump.before);
    KrylovStepper fe(model_, matrices_.analysed, tolerance_in_time_K);
    rom::CvodeStepper stepper(operator_);
    if (jump.uniform_start_K) {
      fe.set_temperatures(Eigen::VectorXd::Constant(model_.capacity_J_per_K.rows(), *jump.uniform_start_K));
      stepper.set_temperatures(Eigen::VectorXd::Constant(dense_.capacity.rows(), *jump.uniform_start_K));
    } else {
      fe.set_temperatures(solve_steady(model_, values));
      stepper.set_temperatures(steady_K(values));
    }
    rom::NetworkOutputs now = rom::make_network_outputs(network_);
    Eigen::VectorXd worst = difference(stepper, fe.temperatures_K(), now);
    hold(jump.after);
    std::vector<StretchPart> parts = {{first_s, values}};
    double at_s = first_s;
    while (at_s < worst_search_s) parts.push_back({std::exchange(at_s, 2.0 * at_s), values});
    fe.advance(parts, [&](std::size_t part, const Eigen::VectorXd& temperatures_K) {
      if (stepper.advance(parts[part].duration_s, values) != rom::StepStatus::ok) {
        throw std::runtime_error("the network's integrator failed");
      }
      worst = worst.cwiseMax(difference(stepper, temperatures_K, now));
    });
    return worst;
  }

 private:
  Eigen::VectorXd steady_K(const rom::BoundaryValues& values) const {
    HeldModel held;
    hold_inputs(dense_, network_.boundaries, segments_, values, 0.0, held);
    return ShiftedModel(dense_, held, 0.0).solve(held.drive);
  }

  Eigen::VectorXd difference(const rom::CvodeStepper& stepper, const Eigen::VectorXd& fe_K,
                             rom::NetworkOutputs& now) const {
    rom::evaluate_outputs(network_, stepper.temperatures_K(), now);
    return (network_outputs(now) - fe_outputs(model_, fe_K)).cwiseAbs();
  }

  const rom::Network& network_;
  const AffineModel& model_;
  DenseModel dense_;
  rom::CoolantSegments segments_;
  std::shared_ptr<const rom::NetworkOperator> operator_;
  AnalysedSystem matrices_;
};

/// An error of one kind and the row of the output that has it.
struct LargestOfKind {
  double error = 0.0;  // SI
  Eigen::Index row = 0;
};

std::array<LargestOfKind, kinds> largest_of_kinds(const Eigen::VectorXd& errors, const OutputLayout& layout) {
  const auto of = [&](Eigen::Index first, Eigen::Index count) {
    LargestOfKind largest;
    if (count == 0) return largest;
    largest.error = errors.segment(first, count).maxCoeff(&largest.row);
    return largest;
  };
  return {of(0, layout.key_points), of(layout.deformations_at(), std::min<Eigen::Index>(1, layout.deformations)),
          of(layout.maxima_at(), layout.parts)};
}

Eigen::VectorXd drawn(const WorstSearchOptions& options, Eigen::Index size, std::uint32_t index) {
  RandomStream random(options.seed, StreamPurpose::worst_search, index);
  const bool corner = random.uniform(0.0, 1.0) < corner_share;
  Eigen::VectorXd place(size);
  for (double& each : place) {
    each = random.uniform(0.0, 1.0);
    if (corner) each = each < 0.5 ? 0.0 : 1.0;
  }
  return place;
}

/// Some coordinates of `parent` at an end of their range, anywhere, or a little off.
Eigen::VectorXd changed(const WorstSearchOptions& options, const Eigen::VectorXd& parent, std::uint32_t index) {
  RandomStream random(options.seed, StreamPurpose::worst_search, index);
  Eigen::VectorXd place = parent;
  const double changes = random.log_uniform(1.0, 0.4 * static_cast<double>(place.size()) + 2.0);
  for (double& each : place) {
    const double how = random.uniform(0.0, 1.0), by = random.uniform(0.0, 1.0);
    if (random.uniform(0.0, static_cast<double>(place.size())) > changes) continue;
    if (how < 0.5) {
      each = each < 0.5 ? 1.0 : 0.0;
    } else if (how < 0.75) {
      each = by;
    } else {
      each = std::clamp(each + 0.6 * (by - 0.5), 0.0, 1.0);
    }
  }
  return place;
}

struct Tried {
  Eigen::VectorXd place;
  std::array<LargestOfKind, kinds> largest;
};

void keep_worse(const Tried& tried, std::array<Tried, kinds>& worst) {
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    if (tried.largest[kind].error > worst[kind].largest[kind].error) worst[kind] = tried;
  }
}

}  // namespace

WorstFound search_worst(const rom::Network& network, const AffineModel& model, const WorstSearchOptions& options,
                        const Progress& progress) {
  if (options.cases < 1 || options.threads < 1) throw std::invalid_argument("cases and threads must be at least 1");
  const JumpSpace space(network.boundaries, options.box);
  const JumpComparison comparison(network, model);
  const OutputLayout layout = output_layout(model);
  std::array<Tried, kinds> worst;
  const int generations = (options.cases + children_per_generation - 1) / children_per_generation;
  const int drawn_generations = std::max(1, static_cast<int>(drawn_share * generations));
  for (int generation = 0; generation < generations; ++generation) {
    std::array<Tried, children_per_generation> children;
    for_each_index(children_per_generation, options.threads, [&](int child, int) {
      Tried& tried = children[static_cast<std::size_t>(child)];
      const auto index = static_cast<std::uint32_t>(generation * children_per_generation + child);
      tried.place = generation < drawn_generations
                        ? drawn(options, space.size(), index)
                        : changed(options, worst[static_cast<std::size_t>(child % kinds)].place, index);
      tried.largest = largest_of_kinds(comparison.errors(space.at(tried.place)), layout);
    });
    for (const Tried& tried : children) keep_worse(tried, worst);
    if (progress) progress("search for the worst", static_cast<double>(generation + 1) / generations);
  }

  WorstFound found;
  found.cases = generations * children_per_generation;
  const std::array<WorstFound::Kind*, kinds> results = {&found.key_points, &found.nose, &found.part_maxima};
  for (std::size_t kind = 0; kind < kinds; ++kind) {
    if (worst[kind].place.size() == 0) continue;  // there is no output of this kind
    WorstFound::Kind& result = *results[kind];
    result.jump = space.at(worst[kind].place);
    const LargestOfKind& largest = worst[kind].largest[kind];
    result.error = largest.error * (kind == 1 ? rom::um_per_m : 1.0);
    const auto row = static_cast<std::size_t>(largest.row);
    result.output = kind == 0   ? network.key_points[row].name
                    : kind == 1 ? network.deformations[row].name
                                : network.parts[row].name;
  }
  return found;
}

}  // namespace spindle_twin::fem_offline
