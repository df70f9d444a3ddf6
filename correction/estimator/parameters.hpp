#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "correction/estimator/start_shapes.hpp"
#include "correction/estimator/thermal_groups.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// What a parameter of the estimator multiplies or adds to.
enum class ParameterKind : std::uint8_t {
  heat,                 ///< ln of the factor on one heat source
  contact,              ///< ln of the factor on one contact conductance
  film,                 ///< ln of the factor on one film coefficient
  environment,          ///< what has to be added to the reading of an environment [K]
  bearing_temperature,  ///< friction heat falls as exp(−β rise of the bearing) [1/K]
  speed_exponent,       ///< heat · (|n| / n_ref)^δ
  capacity,             ///< ln of the factor on one node's heat capacity, of hand-written networks
  disturbance,          ///< heat into one thermal group that no source explains [W]
  start,                ///< what the spindle was warmer at the start than the model's start, in one shape [K]
};

/// As people read it.
const char* name_of(ParameterKind kind);

/// One entry of θ. A deviation of zero leaves it out.
struct Parameter {
  std::string name;
  ParameterKind kind = ParameterKind::heat;
  int index = 0;                 ///< source, conductance, environment, node, thermal group or start shape
  double mean = 0.0;             ///< prior
  double deviation = 0.0;        ///< prior, 1σ
  double walk_per_root_s = 0.0;  ///< random walk: variance grows by its square per second
  double memory_s = 0.0;  ///< > 0: forgets towards the mean with this time constant, variance stays at the prior's
  double minimum = 0.0;   ///< the filter never leaves [minimum, maximum]
  double maximum = 0.0;
};

/// Deviations (1σ) of the priors; of ln factors where no unit stands.
struct EstimatorPriors {
  double heat = 0.5;         ///< each source for itself
  double heat_common = 0.0;  ///< and all sources together, where they share a cause
  double contact = 0.6;
  double film = 0.3;
  double environment_K = 0.1;
  double environment_memory_s = 1800.0;
  double bearing_mean_per_K = 0.010;
  double bearing_per_K = 0.005;
  double speed_exponent = 0.15;
  double start_K = 0.2;         ///< of the whole spindle at the start; 0: the start is known, no start parameter at all
  double start_shape_K = 0.05;  ///< the same of each other way in which it may have been warmer (start_shapes)
  /// Heat that no source explains, one per thermal group: share of all nominal heats together, 1σ; 0: none. Of
  /// hand-written networks, whose structure is a guess, the second.
  double disturbance = 0.01;
  double disturbance_by_hand = 0.1;
  double disturbance_memory_s = 3600.0;
  double capacity = 0.3;                     ///< ln factors of the nodes' capacities, hand-written networks only
  double heat_walk_per_root_min = 0.003;     ///< of the ln factors, as the next two
  double contact_walk_per_root_min = 0.005;  ///< joints settle and loosen with load and temperature
  double film_walk_per_root_min = 0.003;
  /// A nominal value is the median of what machines have: start at the mean of the heats and of the resistances, which
  /// lie σ²/2 above in ln. Starting at the medians biases the nose by micrometres.
  bool centred = true;
};

/// θ of a network: the list, the prior covariance, and what a value of θ makes of the network's inputs. The rise of a
/// friction heat (rom::HeatSource) is T of the source itself, b·T with b its column of B. A watt into a group warms all of it alike: C 1_g / C_g at the nodes.
class ParameterModel {
 public:
  /// Throws rom::InputError naming the option for a prior out of range. Allocates.
  ParameterModel(const rom::Network& network, const EstimatorPriors& priors);

  const std::vector<Parameter>& list() const { return list_; }
  Eigen::Index count() const { return static_cast<Eigen::Index>(list_.size()); }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// Value of θ at which all factors are 1.
  Eigen::VectorXd neutral() const { return Eigen::VectorXd::Zero(count()); }
  Eigen::MatrixXd covariance() const;

  bool is_friction(Eigen::Index source) const { return friction_[static_cast<std::size_t>(source)]; }
  /// Heat of this group in W is θ of its slot.
  const std::vector<ThermalGroup>& groups() const { return groups_; }
  const std::vector<StartShape>& shapes() const { return shapes_; }
  /// Index into θ, -1 where the parameter is left out.
  int heat(Eigen::Index source) const { return heat_[static_cast<std::size_t>(source)]; }
  int exponent(Eigen::Index source) const { return exponent_[static_cast<std::size_t>(source)]; }
  int conductance(Eigen::Index j) const { return conductance_[static_cast<std::size_t>(j)]; }
  int environment(Eigen::Index e) const { return environment_[static_cast<std::size_t>(e)]; }
  int bearing() const { return bearing_; }
  int capacity(Eigen::Index node) const { return capacity_[static_cast<std::size_t>(node)]; }
  bool has_capacities() const { return !capacity_.empty() && capacity_.front() >= 0; }
  int disturbance(Eigen::Index group) const { return disturbance_[static_cast<std::size_t>(group)]; }
  Eigen::Index group_count() const { return static_cast<Eigen::Index>(disturbance_.size()); }
  bool has_disturbances() const { return !disturbance_.empty() && disturbance_.front() >= 0; }
  /// The start parameters are the last of θ, one per shape from here on, the uniform one first; -1 without.
  int start() const { return start_; }
  Eigen::Index starts() const { return start_ < 0 ? 0 : count() - start_; }
  bool is_start(Eigen::Index i) const { return start_ >= 0 && i >= start_; }

  /// All 1, with room for the node heats and capacities that θ sets. Allocates.
  rom::CorrectionFactors make_factors(const rom::Network& network) const;

  /// ln of |n| / n_ref as the speed exponents use it: not below 1/20, where no heat is left to be wrong.
  double log_speed(double speed_rpm) const;

  /// Factors and environment biases of θ at this speed and these temperatures of the sources; node heats and capacities
  /// only where `factors` has room for them (make_factors). Cycle-safe.
  void apply(const Eigen::VectorXd& theta, double speed_rpm, const Eigen::VectorXd& source_rise_K,
             rom::CorrectionFactors& factors, Eigen::VectorXd& environment_bias_K) const;

 private:
  void add(Parameter parameter, int& slot);
  void add_capacities(const rom::Network& network, const EstimatorPriors& priors);
  void add_disturbances(const rom::Network& network, const EstimatorPriors& priors);
  void add_starts(const rom::Network& network, const EstimatorPriors& priors);

  std::vector<Parameter> list_;
  Eigen::VectorXd mean_;
  std::vector<int> heat_, exponent_, conductance_, environment_, capacity_, disturbance_;
  std::vector<ThermalGroup> groups_;
  std::vector<StartShape> shapes_;
  Eigen::MatrixXd node_heat_;  // N x groups: where a watt into each group goes
  int bearing_ = -1, start_ = -1;
  std::vector<bool> friction_;
  double reference_speed_rpm_ = 0.0;
  double heat_common_ = 0.0;
};

}  // namespace spindle_twin::correction
