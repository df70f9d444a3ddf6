#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

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
  start,                ///< what the whole spindle was warmer at the start than the model's start [K]
};

/// As people read it.
const char* name_of(ParameterKind kind);

/// One entry of θ. A deviation of zero leaves it out.
struct Parameter {
  std::string name;
  ParameterKind kind = ParameterKind::heat;
  int index = 0;                 ///< source, conductance or environment
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
  double start_K = 0.2;
  double heat_walk_per_root_min = 0.003;     ///< of the ln factors, as the next two
  double contact_walk_per_root_min = 0.005;  ///< joints settle and loosen with load and temperature
  double film_walk_per_root_min = 0.003;
  /// A nominal value is the median of what machines have: start at the mean of the heats and of the resistances, which
  /// lie σ²/2 above in ln. Starting at the medians biases the nose by micrometres.
  bool centred = true;
};

/// θ of a network: the list, the prior covariance, and what a value of θ makes of the network's inputs. Friction heats
/// are the sources whose law knows speed but not load; their rise is T of the source itself, b·T with b its column of
/// B.
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
  /// Index into θ, -1 where the parameter is left out.
  int heat(Eigen::Index source) const { return heat_[static_cast<std::size_t>(source)]; }
  int exponent(Eigen::Index source) const { return exponent_[static_cast<std::size_t>(source)]; }
  int conductance(Eigen::Index j) const { return conductance_[static_cast<std::size_t>(j)]; }
  int environment(Eigen::Index e) const { return environment_[static_cast<std::size_t>(e)]; }
  int bearing() const { return bearing_; }
  int start() const { return start_; }

  /// ln of |n| / n_ref as the speed exponents use it: not below 1/20, where no heat is left to be wrong.
  double log_speed(double speed_rpm) const;

  /// Factors and environment biases of θ at this speed and these temperatures of the sources. Cycle-safe.
  void apply(const Eigen::VectorXd& theta, double speed_rpm, const Eigen::VectorXd& source_rise_K,
             rom::CorrectionFactors& factors, Eigen::VectorXd& environment_bias_K) const;

 private:
  void add(Parameter parameter, int& slot);

  std::vector<Parameter> list_;
  Eigen::VectorXd mean_;
  std::vector<int> heat_, exponent_, conductance_, environment_;
  int bearing_ = -1, start_ = -1;
  std::vector<bool> friction_;
  double reference_speed_rpm_ = 0.0;
  double heat_common_ = 0.0;
};

}  // namespace spindle_twin::correction
