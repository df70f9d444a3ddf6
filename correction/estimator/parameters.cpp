#include "correction/estimator/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "correction/estimator/operating_heat.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/read/input_error.hpp"
#include "rom/read/options.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double seconds_per_minute = 60.0;
const double per_root_s = 1.0 / std::sqrt(seconds_per_minute);  // of what walks per root minute
// The box that a network's basis is made for reaches a factor of ten for contacts and five for films.
constexpr double largest_contact = 2.302585092994046;
constexpr double largest_film = 1.6094379124341003;
constexpr double largest_heat = 1.6094379124341003;
constexpr double widest = 4.0;  // deviations, for everything else
constexpr double widest_environment_K = 20.0;
constexpr double slowest_speed = 0.05;
constexpr double largest_expansion = 0.5;
constexpr double largest_start_K = 500.0;
constexpr double largest_capacity = 1.6094379124341003;
constexpr double most_disturbance = 1.0;  // of all nominal heats together
constexpr std::size_t most_groups = 8;
constexpr double least_flow = 0.01;  // of all nominal heats, through a node that leads nowhere

/// Its pressure is that of a fit, by the published law or by a law of physics.
bool has_fit(const rom::Conductance& conductance) {
  return conductance.fit.has_value() || (conductance.physics && conductance.physics->pressure >= 0);
}

/// Own and shared causes together.
double heat_deviation(const rom::HeatSource& source, const EstimatorPriors& priors) {
  const bool electric = priors.heat_by_current > 0.0 && rom::reads_electricity(source);
  const double shared = std::hypot(priors.heat_common, source.friction ? priors.friction_common : 0.0);
  return std::hypot(electric ? priors.heat_by_current : priors.heat, shared);
}

double contact_deviation(const rom::Conductance& contact, const EstimatorPriors& priors) {
  return has_fit(contact) ? std::hypot(priors.contact, priors.fit_common) : priors.contact;
}

}  // namespace

const char* name_of(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::heat:
      return "heat";
    case ParameterKind::contact:
      return "contact";
    case ParameterKind::film:
      return "film";
    case ParameterKind::environment:
      return "environment";
    case ParameterKind::bearing_temperature:
      return "bearing temperature";
    case ParameterKind::speed_exponent:
      return "speed exponent";
    case ParameterKind::expansion:
      return "expansion";
    case ParameterKind::capacity:
      return "capacity";
    case ParameterKind::disturbance:
      return "unexplained heat";
    case ParameterKind::start:
      return "start";
  }
  return "unknown";
}

void expand_by(double factor, Eigen::Index slot, double& length_m, Eigen::Ref<Eigen::VectorXd> slope) {
  length_m *= factor;
  slope *= factor;
  slope[slot] = length_m;
}

bool bends_the_state(ParameterKind kind) {
  return kind == ParameterKind::heat || kind == ParameterKind::contact || kind == ParameterKind::film ||
         kind == ParameterKind::capacity;
}

bool is_of_the_machine(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::heat:
    case ParameterKind::contact:
    case ParameterKind::film:
    case ParameterKind::bearing_temperature:
    case ParameterKind::speed_exponent:
    case ParameterKind::expansion:
    case ParameterKind::capacity:
      return true;
    case ParameterKind::environment:
    case ParameterKind::disturbance:
    case ParameterKind::start:
      break;
  }
  return false;
}

double nominal_shift(double nominal, double own) {
  return nominal > 0.0 && own > 0.0 && nominal != own ? std::log(nominal / own) : 0.0;
}

ParameterModel::ParameterModel(const rom::Network& network, const EstimatorPriors& priors)
    : reference_speed_rpm_(network.boundaries.reference_speed_rpm),
      all_heats_{{}, priors.heat_common},
      frictions_{{}, priors.friction_common},
      fits_{{}, priors.fit_common} {
  EstimatorPriors::each(priors, rom::CheckOptions("prior."));

  const rom::Boundaries& boundaries = network.boundaries;
  heat_.assign(boundaries.sources.size(), -1);
  exponent_.assign(boundaries.sources.size(), -1);
  conductance_.assign(boundaries.conductances.size(), -1);
  environment_.assign(boundaries.environments.size(), -1);
  for (std::size_t i = 0; i < boundaries.sources.size(); ++i) {
    const rom::HeatSource& source = boundaries.sources[i];
    friction_.push_back(source.friction);
    const double deviation = heat_deviation(source, priors);
    const double mean = priors.centred ? 0.5 * deviation * deviation : 0.0;
    add({"heat " + source.name, ParameterKind::heat, static_cast<int>(i), mean, deviation,
         priors.heat_walk_per_root_min * per_root_s, 0.0, -largest_heat, largest_heat, std::abs(source.nominal_W)},
        heat_[i]);
    if (heat_[i] < 0) continue;
    all_heats_.slots.push_back(heat_[i]);
    if (source.friction) frictions_.slots.push_back(heat_[i]);
  }
  for (std::size_t j = 0; j < boundaries.conductances.size(); ++j) {
    const bool contact = boundaries.conductances[j].kind == rom::ConductanceKind::contact;
    const double deviation = contact ? contact_deviation(boundaries.conductances[j], priors) : priors.film;
    const double largest = contact ? largest_contact : largest_film;
    const double walk = (contact ? priors.contact_walk_per_root_min : priors.film_walk_per_root_min) * per_root_s;
    add({(contact ? "contact " : "film ") + boundaries.conductances[j].name,
         contact ? ParameterKind::contact : ParameterKind::film, static_cast<int>(j),
         priors.centred ? -0.5 * deviation * deviation : 0.0, deviation, walk, 0.0, -largest, largest,
         boundaries.conductances[j].nominal_W_per_m2K * boundaries.conductances[j].area_m2},
        conductance_[j]);
    if (conductance_[j] >= 0 && contact && has_fit(boundaries.conductances[j])) fits_.slots.push_back(conductance_[j]);
  }
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    add({"bias " + boundaries.environments[e].name, ParameterKind::environment, static_cast<int>(e), 0.0,
         priors.environment_K, 0.0, priors.environment_memory_s, -widest_environment_K, widest_environment_K},
        environment_[e]);
  }
  add_laws(network, priors);
  add_capacities(network, priors);
  add_disturbances(network, priors);
  add_starts(network, priors);
  calibrated_ = priors.calibrated;
  if (calibrated_) take_calibrated();
  mean_.resize(count());
  for (Eigen::Index i = 0; i < count(); ++i) mean_[i] = list_[static_cast<std::size_t>(i)].mean;
}

void ParameterModel::add_laws(const rom::Network& network, const EstimatorPriors& priors) {
  const std::vector<rom::HeatSource>& sources = network.boundaries.sources;
  if (std::find(friction_.begin(), friction_.end(), true) != friction_.end()) {
    add({"bearing temperature", ParameterKind::bearing_temperature, 0, priors.bearing_mean_per_K, priors.bearing_per_K,
         0.0, 0.0, 0.0, priors.bearing_mean_per_K + widest * priors.bearing_per_K},
        bearing_);
  }
  for (std::size_t i = 0; i < sources.size(); ++i) {
    if (sources[i].law.speed_terms.empty()) continue;
    add({"exponent " + sources[i].name, ParameterKind::speed_exponent, static_cast<int>(i), 0.0, priors.speed_exponent,
         0.0, 0.0, -widest * priors.speed_exponent, widest * priors.speed_exponent},
        exponent_[i]);
  }
  if (!network.deformations.empty()) {
    add({"expansion", ParameterKind::expansion, 0, 0.0, priors.expansion, 0.0, 0.0, -largest_expansion,
         largest_expansion},
        expansion_);
  }
}

void ParameterModel::add_capacities(const rom::Network& network, const EstimatorPriors& priors) {
  const Eigen::MatrixXd& capacity = network.capacity_J_per_K;
  const bool lumped = (capacity - Eigen::MatrixXd(capacity.diagonal().asDiagonal())).isZero(0.0);
  if (!network.hand_written || !lumped) return;
  capacity_.assign(network.nodes.size(), -1);
  for (std::size_t i = 0; i < network.nodes.size(); ++i) {
    add({"capacity " + network.nodes[i].name, ParameterKind::capacity, static_cast<int>(i), 0.0, priors.capacity, 0.0,
         0.0, -largest_capacity, largest_capacity,
         capacity(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))},
        capacity_[i]);
  }
}

void ParameterModel::add_disturbances(const rom::Network& network, const EstimatorPriors& priors) {
  const double heat_W = nominal_heats_W(network);
  const bool wanted = heat_W > 0.0 && (network.hand_written ? priors.disturbance_by_hand : priors.disturbance) > 0.0;
  if (wanted || priors.start_K > 0.0) groups_ = thermal_groups(network, most_groups);
  if (!wanted) return;
  std::vector<double> deviation_W(groups_.size(), heat_W * priors.disturbance);
  if (network.hand_written) {
    const std::vector<double> through_W = heat_through_groups_W(network, groups_);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const double flows_W = std::max(least_flow * heat_W, through_W[g]);
      deviation_W[g] = std::max(deviation_W[g], flows_W * priors.disturbance_by_hand);
    }
  }
  disturbance_.assign(groups_.size(), -1);
  node_heat_.resize(network.capacity_J_per_K.rows(), static_cast<Eigen::Index>(groups_.size()));
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    node_heat_.col(static_cast<Eigen::Index>(g)) =
        network.capacity_J_per_K * groups_[g].indicator / groups_[g].capacity_J_per_K;
    add({"unexplained heat " + groups_[g].name, ParameterKind::disturbance, static_cast<int>(g), 0.0, deviation_W[g],
         0.0, priors.disturbance_memory_s, -most_disturbance * heat_W, most_disturbance * heat_W},
        disturbance_[g]);
  }
}

void ParameterModel::add_starts(const rom::Network& network, const EstimatorPriors& priors) {
  if (!(priors.start_K > 0.0)) return;
  shapes_ = start_shapes(network, rom::NetworkOperator(network), groups_);
  if (!(priors.start_shape_K > 0.0)) shapes_.resize(1);
  for (std::size_t k = 0; k < shapes_.size(); ++k) {
    int slot = -1;
    add({"start " + shapes_[k].name, ParameterKind::start, static_cast<int>(k), 0.0,
         k == 0 ? priors.start_K : priors.start_shape_K, 0.0, 0.0, -largest_start_K, largest_start_K},
        slot);
    if (k == 0) start_ = slot;
  }
}

void ParameterModel::take_calibrated() {
  const CalibratedPrior& calibrated = *calibrated_;
  for (std::size_t i = 0; i < calibrated.names.size(); ++i) {
    const auto found = std::find_if(list_.begin(), list_.end(),
                                    [&](const Parameter& parameter) { return parameter.name == calibrated.names[i]; });
    if (found == list_.end()) {
      throw rom::InputError({}, "calibration", "\"" + calibrated.names[i] + "\" is no parameter of this network");
    }
    const auto slot = static_cast<Eigen::Index>(i);
    const double shift =
        calibrated.nominal.size() > slot ? nominal_shift(calibrated.nominal[slot], found->nominal) : 0.0;
    found->mean = std::clamp(calibrated.mean[slot] + shift, found->minimum, found->maximum);
    found->deviation = std::sqrt(calibrated.covariance(slot, slot));
    calibrated_slots_.push_back(found - list_.begin());
  }
}

rom::CorrectionFactors ParameterModel::make_factors(const rom::Network& network) const {
  rom::CorrectionFactors factors = no_correction(network.boundaries);
  const Eigen::Index nodes = network.capacity_J_per_K.rows();
  if (has_disturbances()) factors.node_heat_W = Eigen::VectorXd::Zero(nodes);
  if (has_capacities()) factors.capacity_factor = Eigen::VectorXd::Ones(nodes);
  return factors;
}

void ParameterModel::add(Parameter parameter, int& slot) {
  if (parameter.deviation <= 0.0) return;
  parameter.uncalibrated_mean = parameter.mean;
  parameter.uncalibrated_deviation = parameter.deviation;
  slot = static_cast<int>(list_.size());
  list_.push_back(std::move(parameter));
}

Eigen::MatrixXd ParameterModel::covariance() const {
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(count(), count());
  for (Eigen::Index i = 0; i < count(); ++i) {
    const double deviation = list_[static_cast<std::size_t>(i)].deviation;
    covariance(i, i) = deviation * deviation;
  }
  for (const SharedCause* cause : {&all_heats_, &frictions_, &fits_}) {
    for (const int a : cause->slots) {
      for (const int b : cause->slots) {
        if (a != b) covariance(a, b) += cause->deviation * cause->deviation;
      }
    }
  }
  for (const Eigen::Index slot : calibrated_slots_) {
    covariance.row(slot).setZero();
    covariance.col(slot).setZero();
  }
  for (std::size_t a = 0; a < calibrated_slots_.size(); ++a) {
    for (std::size_t b = 0; b < calibrated_slots_.size(); ++b) {
      covariance(calibrated_slots_[a], calibrated_slots_[b]) =
          calibrated_->covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    }
  }
  return covariance;
}

double ParameterModel::log_speed(double speed_rpm) const {
  if (!(reference_speed_rpm_ > 0.0)) return 0.0;  // a network whose laws do not know speed
  return std::log(std::max(std::abs(speed_rpm) / reference_speed_rpm_, slowest_speed));
}

double ParameterModel::expansion_factor(const Eigen::VectorXd& theta) const {
  return expansion_ < 0 ? 1.0 : std::exp(theta[expansion_]);
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): a view, written through by expand_by
void ParameterModel::expand(const Eigen::VectorXd& theta, double& length_m, Eigen::Ref<Eigen::VectorXd> slope) const {
  if (expansion_ >= 0) expand_by(expansion_factor(theta), expansion_, length_m, slope);
}

Eigen::VectorXd ParameterModel::as_in(const ParameterModel& other, const Eigen::VectorXd& theta) const {
  Eigen::VectorXd same = Eigen::VectorXd::Zero(other.count());
  for (Eigen::Index i = 0; i < other.count(); ++i) {
    const std::string& name = other.list_[static_cast<std::size_t>(i)].name;
    const auto found = std::find_if(list_.begin(), list_.end(), [&](const Parameter& own) { return own.name == name; });
    if (found != list_.end()) same[i] = theta[found - list_.begin()];
  }
  return same;
}

void ParameterModel::apply(const Eigen::VectorXd& theta, double speed_rpm, const Eigen::VectorXd& source_rise_K,
                           rom::CorrectionFactors& factors, Eigen::VectorXd& environment_bias_K) const {
  const double log_x = log_speed(speed_rpm);
  const auto value = [&](int slot) { return slot < 0 ? 0.0 : theta[slot]; };
  for (Eigen::Index i = 0; i < factors.heat.size(); ++i) {
    double log_factor = value(heat(i)) + value(exponent(i)) * log_x;
    if (is_friction(i)) log_factor -= value(bearing_) * source_rise_K[i];
    factors.heat[i] = std::exp(log_factor);
  }
  for (Eigen::Index j = 0; j < factors.conductance.size(); ++j) {
    factors.conductance[j] = std::exp(value(conductance(j)));
  }
  for (Eigen::Index e = 0; e < environment_bias_K.size(); ++e) environment_bias_K[e] = value(environment(e));
  factors.expansion = expansion_factor(theta);
  if (has_disturbances() && factors.node_heat_W.size() > 0) {
    factors.node_heat_W.noalias() =
        node_heat_ * theta.segment(disturbance_.front(), static_cast<Eigen::Index>(disturbance_.size()));
  }
  if (!has_capacities()) return;
  for (Eigen::Index i = 0; i < factors.capacity_factor.size(); ++i) {
    factors.capacity_factor[i] = std::exp(theta[capacity(i)]);
  }
}

}  // namespace spindle_twin::correction
