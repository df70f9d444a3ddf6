#include "correction/identify/identify.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "correction/estimator/sensitivities.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "rom/read/input_error.hpp"

namespace spindle_twin::correction {
namespace {

constexpr std::size_t most_instants = 120;  // readings between two of them are taken as one of higher weight

/// dT/dθ at a few places, instant after instant, and the variance of what is read there in its name.
struct Instants {
  std::vector<Eigen::MatrixXd> sensitivities;  ///< places x p
  std::vector<double> variance_K2;
};

/// Rows of one place over all instants, each divided by its noise's 1σ.
struct Readings {
  Eigen::MatrixXd rows;    ///< instants x p
  Eigen::VectorXd offset;  ///< instants; what a constant error of 1σ adds
};

Readings readings_of(const Instants& instants, Eigen::Index place, double offset_deviation_K) {
  const auto count = static_cast<Eigen::Index>(instants.sensitivities.size());
  Readings readings{Eigen::MatrixXd(count, instants.sensitivities.front().cols()), Eigen::VectorXd(count)};
  for (Eigen::Index t = 0; t < count; ++t) {
    const auto index = static_cast<std::size_t>(t);
    const double weight = 1.0 / std::sqrt(instants.variance_K2[index]);
    readings.rows.row(t) = weight * instants.sensitivities[index].row(place);
    readings.offset[t] = weight * offset_deviation_K;
  }
  return readings;
}

/// H P Hᵀ + 1 + offset offsetᵀ.
Eigen::LLT<Eigen::MatrixXd> innovation_factor(const Readings& readings, const Eigen::MatrixXd& rows_by_covariance) {
  Eigen::MatrixXd innovation = rows_by_covariance * readings.rows.transpose();
  innovation += readings.offset * readings.offset.transpose();
  innovation.diagonal().array() += 1.0;
  return Eigen::LLT<Eigen::MatrixXd>(innovation);
}

void condition_on(const Readings& readings, Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd rows_by_covariance = readings.rows * covariance;
  const Eigen::MatrixXd half = innovation_factor(readings, rows_by_covariance).matrixL().solve(rows_by_covariance);
  covariance -= half.transpose() * half;
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
}

double variance_with(const Readings& readings, const Eigen::MatrixXd& covariance, const Eigen::VectorXd& wanted) {
  const Eigen::MatrixXd rows_by_covariance = readings.rows * covariance;
  const Eigen::VectorXd half =
      innovation_factor(readings, rows_by_covariance).matrixL().solve((rows_by_covariance * wanted).eval());
  return wanted.dot(covariance * wanted) - half.squaredNorm();
}

double root(double variance) { return std::sqrt(std::max(variance, 0.0)); }

struct Run {
  Instants instants;
  Eigen::VectorXd deformation_m;  ///< dL/dθ at the end
  double growth_m = 0.0;
};

Run run(const rom::Network& network, const ParameterModel& parameters, const rom::Schedule& schedule,
        const std::vector<SensorPlace>& places, const IdentifyOptions& options) {
  const auto coordinates = std::make_shared<const rom::NetworkOperator>(network);
  Sensitivities sensitivities(network, coordinates, parameters);
  sensitivities.start(parameters);
  const auto stepper = rom::make_runtime_stepper(network);
  rom::CorrectionFactors factors = rom::no_correction(network.boundaries);
  rom::BoundaryValues values = rom::make_boundary_values(network.boundaries);
  rom::OperatingState state = network.boundaries.operating;
  Eigen::VectorXd bias_K = Eigen::VectorXd::Zero(state.environment_K.size());
  Eigen::VectorXd rises_K = Eigen::VectorXd::Zero(factors.heat.size());
  // The spindle as it is described, or as a test has found it.
  Eigen::VectorXd theta = options.priors.calibrated ? parameters.mean() : parameters.neutral();
  if (parameters.bearing() >= 0) theta[parameters.bearing()] = parameters.mean()[parameters.bearing()];

  const auto samples = static_cast<std::size_t>(std::ceil(schedule.end_s / options.sample_s - 1e-9));
  const std::size_t stride = samples / most_instants + 1;
  const double shared = options.correlation_s > 0.0 ? std::max(1.0, options.correlation_s / options.sample_s) : 1.0;
  const double variance_K2 = (options.noise_K * options.noise_K + options.floor_K * options.floor_K) * shared;
  Run result;
  Eigen::VectorXd start_K = stepper->temperatures_K();
  std::size_t gathered = 0;
  for (std::size_t k = 0; k < samples; ++k) {
    const double begin_s = static_cast<double>(k) * options.sample_s;
    const double period_s = std::min(options.sample_s, schedule.end_s - begin_s);
    state_at(schedule, begin_s + 0.5 * period_s, state);
    sensitivities.source_rises(start_K, rises_K);
    parameters.apply(theta, state.speed_rpm, rises_K, factors, bias_K);
    rom::evaluate_boundaries(network.boundaries, state, factors, values);
    if (stepper->advance(period_s, values) != rom::StepStatus::ok) {
      throw std::runtime_error("the network has no solution at " + std::to_string(begin_s) + " s");
    }
    coordinates->laws().at_temperatures(stepper->temperatures_K(), values);
    if (!sensitivities.advance({period_s, state.speed_rpm, start_K, stepper->temperatures_K(), values, theta},
                               parameters)) {
      throw std::runtime_error("the network has no solution at " + std::to_string(begin_s) + " s");
    }
    start_K = stepper->temperatures_K();
    ++gathered;
    if (gathered < stride && k + 1 < samples) continue;
    const Eigen::MatrixXd per_node = sensitivities.in_kelvin();
    Eigen::MatrixXd here(static_cast<Eigen::Index>(places.size()), per_node.cols());
    for (std::size_t p = 0; p < places.size(); ++p) {
      here.row(static_cast<Eigen::Index>(p)) = places[p].row.transpose() * per_node;
    }
    result.instants.sensitivities.push_back(std::move(here));
    result.instants.variance_K2.push_back(variance_K2 / static_cast<double>(gathered));
    gathered = 0;
    if (k + 1 < samples) continue;
    const Eigen::VectorXd& row = network.deformations.front().row_m_per_K;
    result.deformation_m = per_node.transpose() * row;
    result.growth_m = row.dot(start_K) - row.sum() * network.boundaries.reference_temperature_K;
    parameters.expand(theta, result.growth_m, result.deformation_m);
  }
  return result;
}

rom::InputError unknown_place(const rom::Network& network, const std::vector<SensorPlace>& all, const std::string& name,
                              const std::string& field) {
  std::string list;
  for (std::size_t i = 0; i < network.key_points.size() + network.parts.size(); ++i) {
    list.append(list.empty() ? "" : ", ").append(all[i].name);
  }
  return {{}, field, "'" + name + "' does not exist; allowed: " + list + ", or the name of a node"};
}

}  // namespace

EstimatorPriors constant_priors() {
  EstimatorPriors priors;
  priors.environment_K = 0.0;
  priors.bearing_mean_per_K = 0.0;
  priors.bearing_per_K = 0.0;
  priors.speed_exponent = priors.expansion = 0.0;
  priors.start_K = priors.disturbance = priors.disturbance_by_hand = 0.0;
  priors.heat_walk_per_root_min = priors.contact_walk_per_root_min = priors.film_walk_per_root_min = 0.0;
  priors.centred = false;
  return priors;
}

std::vector<SensorPlace> sensor_places(const rom::Network& network) {
  std::vector<SensorPlace> places;
  for (const rom::KeyPoint& point : network.key_points) {
    places.push_back({point.name, point.part, point.r_m, point.z_m, point.row});
  }
  for (const rom::PartOutput& part : network.parts) places.push_back({part.name, part.name, 0.0, 0.0, part.mean_row});
  const auto nodes = static_cast<Eigen::Index>(network.nodes.size());
  for (Eigen::Index i = 0; i < nodes; ++i) {
    const rom::Node& node = network.nodes[static_cast<std::size_t>(i)];
    places.push_back({node.name, node.part, node.r_m, node.z_m, Eigen::VectorXd::Unit(nodes, i)});
  }
  return places;
}

std::vector<SensorPlace> find_places(const rom::Network& network, const std::vector<std::string>& names,
                                     const std::string& field) {
  const std::vector<SensorPlace> all = sensor_places(network);
  std::vector<SensorPlace> found;
  for (const std::string& name : names) {
    const auto place = std::find_if(all.begin(), all.end(), [&](const SensorPlace& one) { return one.name == name; });
    if (place == all.end()) throw unknown_place(network, all, name, field);
    if (std::count(names.begin(), names.end(), name) > 1) {
      throw rom::InputError({}, field, "\"" + name + "\" stands there twice; one place has one sensor");
    }
    found.push_back(*place);
  }
  return found;
}

Identification identify(const rom::Network& network, const std::vector<SensorPlace>& sensors,
                        const rom::Schedule& schedule, const IdentifyOptions& options) {
  if (network.deformations.empty()) throw rom::InputError({}, "deformations", "the network has none to be sure of");
  const ParameterModel parameters(network, options.priors);
  std::vector<SensorPlace> places = sensor_places(network);
  std::erase_if(places, [&](const SensorPlace& place) {
    const auto& closed = options.closed_parts;
    return std::find(closed.begin(), closed.end(), place.part) != closed.end();
  });
  const auto candidates = static_cast<Eigen::Index>(places.size());
  places.insert(places.end(), sensors.begin(), sensors.end());
  const Run done = run(network, parameters, schedule, places, options);

  Eigen::MatrixXd covariance = parameters.covariance();
  Identification result;
  result.growth_m = done.growth_m;
  result.prior_m = root(done.deformation_m.dot(covariance * done.deformation_m));
  for (Eigen::Index s = candidates; s < static_cast<Eigen::Index>(places.size()); ++s) {
    condition_on(readings_of(done.instants, s, options.offset_deviation_K), covariance);
  }
  result.posterior_m = root(done.deformation_m.dot(covariance * done.deformation_m));
  for (std::size_t left_out = 0; left_out < sensors.size(); ++left_out) {
    Eigen::MatrixXd others = parameters.covariance();
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      const auto place = candidates + static_cast<Eigen::Index>(s);
      if (s != left_out) condition_on(readings_of(done.instants, place, options.offset_deviation_K), others);
    }
    result.without_m.push_back(root(done.deformation_m.dot(others * done.deformation_m)));
  }
  for (Eigen::Index i = 0; i < parameters.count(); ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    result.parameters.push_back({parameter.name, parameter.kind, {0.0, root(covariance(i, i)), parameter.deviation}});
  }

  for (int placed = 0; placed < options.placements && candidates > 0; ++placed) {
    std::vector<Placement> all;
    for (Eigen::Index c = 0; c < candidates; ++c) {
      all.push_back({places[static_cast<std::size_t>(c)],
                     root(variance_with(readings_of(done.instants, c, options.offset_deviation_K), covariance,
                                        done.deformation_m))});
    }
    const auto best = std::min_element(all.begin(), all.end(), [](const Placement& a, const Placement& b) {
      return a.deformation_m < b.deformation_m;
    });
    result.placements.push_back(*best);
    condition_on(readings_of(done.instants, best - all.begin(), options.offset_deviation_K), covariance);
    if (placed > 0) continue;
    std::stable_sort(all.begin(), all.end(),
                     [](const Placement& a, const Placement& b) { return a.deformation_m < b.deformation_m; });
    result.first_placement = std::move(all);
  }
  return result;
}

}  // namespace spindle_twin::correction
