#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "correction/estimator/calibrated_prior.hpp"
#include "correction/estimator/start_shapes.hpp"
#include "correction/estimator/thermal_groups.hpp"
#include "rom/network.hpp"
#include "rom/option.hpp"

namespace spindle_twin::correction {

/// What a parameter of the estimator multiplies or adds to.
enum class ParameterKind : std::uint8_t {
  heat,                 ///< ln of the factor on one heat source
  contact,              ///< ln of the factor on one contact conductance
  film,                 ///< ln of the factor on one film coefficient
  environment,          ///< what has to be added to the reading of an environment [K]
  bearing_temperature,  ///< friction heat falls as exp(−β rise of the bearing) [1/K]
  speed_exponent,       ///< heat · (|n| / n_ref)^δ
  expansion,            ///< ln of the factor on every deformation at given temperatures
  capacity,             ///< ln of the factor on one node's heat capacity, of hand-written networks
  disturbance,          ///< heat into one thermal group that no source explains [W]
  start,                ///< what the spindle was warmer at the start than the model's start, in one shape [K]
};

/// As people read it.
const char* name_of(ParameterKind kind);

/// ln of a factor in the heat balance: there the state follows e^θ, of which a straight line leaves something out.
bool bends_the_state(ParameterKind kind);

/// It is of the machine, not of the day: heats, contacts, films, what their laws do not know, expansion, capacities.
bool is_of_the_machine(ParameterKind kind);

/// A deformation as it is at a factor of 1, and its derivatives by θ: both with the factor, whose ln is θ of `slot`.
/// Cycle-safe.
void expand_by(double factor, Eigen::Index slot, double& length_m, Eigen::Ref<Eigen::VectorXd> slope);

/// ln(nominal / own), by which a ln factor of one network moves when another one takes it over; 0 where a nominal value
/// is not known (0 or less) or both are the same.
double nominal_shift(double nominal, double own);

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
  double nominal = 1.0;  ///< what the factor of a ln factor multiplies: W, W/K or J/K
  /// The prior of an unknown machine where mean and deviation are of a calibration; else the same as these.
  double uncalibrated_mean = 0.0;
  double uncalibrated_deviation = 0.0;
};

/// Deviations (1σ) of the priors; of ln factors where no unit stands. Options, not state: what a person may set, which
/// is why it is open. `each` says what each means.
struct EstimatorPriors {  // NOLINT(public-members): a table of options, which `each` names one by one
  double heat = 0.5;
  double heat_common = 0.0;
  double friction_common = 0.0;
  double heat_by_current = 0.0;  ///< 0: as `heat`
  double contact = 0.6;
  double fit_common = 0.0;
  double film = 0.3;
  double environment_K = 0.1;
  double environment_memory_s = 1800.0;
  double bearing_mean_per_K = 0.010;
  double bearing_per_K = 0.005;
  double speed_exponent = 0.15;
  double expansion = 0.05;
  double start_K = 0.2;              ///< 0: the start is known, no start parameter at all
  double start_shape_K = 0.05;       ///< of each other way in which it may have been warmer (start_shapes)
  double disturbance = 0.01;         ///< share of all nominal heats together, one heat per thermal group; 0: none
  double disturbance_by_hand = 0.1;  ///< hand-written: share of what flows through the group (operating_heat)
  double disturbance_memory_s = 3600.0;
  double capacity = 0.3;
  double heat_walk_per_root_min = 0.003;
  double contact_walk_per_root_min = 0.005;  ///< joints settle and loosen with load and temperature
  double film_walk_per_root_min = 0.003;
  /// A nominal value is the median of what machines have: start at the mean of the heats and of the resistances, which
  /// lie σ²/2 above in ln. Starting at the medians biases the nose by micrometres.
  bool centred = true;
  /// What a calibration knows instead of the deviations above, of the parameters that it names; null: none.
  std::shared_ptr<const CalibratedPrior> calibrated = nullptr;

  template <class Options, class Visit>
  static void each(Options& priors, Visit&& visit) {
    using rom::zero_or_some;
    constexpr double ln = 2.0;  // most deviation of a ln factor
    visit(zero_or_some("heat", "of each heat source for itself", ln), priors.heat);
    visit(zero_or_some("heat_common",
                       "of all sources together: where all are wrong by the same cause, 0.8 beside heat = 0.15", ln),
          priors.heat_common);
    visit(zero_or_some("friction_common", "of all friction heats together: the same grease, the same preload", ln),
          priors.friction_common);
    visit(zero_or_some("heat_by_current",
                       "instead of heat where a law reads the motor's measured current or power; 0: as heat", ln),
          priors.heat_by_current);
    visit(zero_or_some("contact", "", ln), priors.contact);
    visit(zero_or_some("fit_common", "of all contacts whose pressure comes from a fit: assembled alike, finished alike",
                       ln),
          priors.fit_common);
    visit(zero_or_some("film", "", ln), priors.film);
    visit(zero_or_some("environment_K", "of what coolant and ambient read", 10.0), priors.environment_K);
    visit(zero_or_some("environment_memory_s", "how long that stays", 1e9), priors.environment_memory_s);
    visit(zero_or_some("bearing_mean_per_K", "friction heat falls so much per kelvin of the bearing", 0.1),
          priors.bearing_mean_per_K);
    visit(zero_or_some("bearing_per_K", "", 0.1), priors.bearing_per_K);
    visit(zero_or_some("speed_exponent", "of each heat's speed law", 1.0), priors.speed_exponent);
    visit(zero_or_some("expansion", "of all deformations at given temperatures: coefficients of expansion, lengths; ln",
                       0.5),
          priors.expansion);
    visit(zero_or_some("start_K", "of the whole spindle at the start; opened where the first readings differ by more",
                       100.0),
          priors.start_K);
    visit(zero_or_some("start_shape_K", "of each part group against that, likewise", 100.0), priors.start_shape_K);
    visit(zero_or_some("disturbance",
                       "heat that no source explains, of all nominal heats; shut until readings speak for one", 1.0),
          priors.disturbance);
    visit(zero_or_some(
              "disturbance_by_hand",
              "in a hand-written network the same of the heat that passes the node, if that is more; always open", 1.0),
          priors.disturbance_by_hand);
    visit({"disturbance_memory_s", "how long such a heat stays", rom::between(60.0, 1e9)}, priors.disturbance_memory_s);
    visit(zero_or_some("capacity", "of each node of a hand-written network", 1.0), priors.capacity);
    visit(zero_or_some("heat_walk_per_root_min", "how fast the ln factors of heats wander", 1.0),
          priors.heat_walk_per_root_min);
    visit(zero_or_some("contact_walk_per_root_min", "", 1.0), priors.contact_walk_per_root_min);
    visit(zero_or_some("film_walk_per_root_min", "", 1.0), priors.film_walk_per_root_min);
    visit({"centred", "the description gives medians, the twin starts from the means"}, priors.centred);
  }
};

/// θ of a network: the list, the prior covariance, and what a value of θ makes of the network's inputs. The rise of a
/// friction heat (rom::HeatSource) is T of the source itself, b·T with b its column of B. A watt into a group warms all
/// of it alike: C 1_g / C_g at the nodes.
class ParameterModel {
 public:
  /// Throws rom::InputError naming the option for a prior out of range, and a calibrated parameter that this network
  /// does not have. Allocates.
  ParameterModel(const rom::Network& network, const EstimatorPriors& priors);

  const std::vector<Parameter>& list() const { return list_; }
  Eigen::Index count() const { return static_cast<Eigen::Index>(list_.size()); }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// Value of θ at which all factors are 1.
  Eigen::VectorXd neutral() const { return Eigen::VectorXd::Zero(count()); }
  Eigen::MatrixXd covariance() const;
  /// What it begins with instead of the priors of an unknown machine; null: nothing.
  const CalibratedPrior* calibrated() const { return calibrated_.get(); }
  /// Tells one from another; empty without one.
  std::string calibration_origin() const { return calibrated_ ? calibrated_->origin : ""; }
  /// Indices into θ of its parameters, in its order; empty without one.
  const std::vector<Eigen::Index>& calibrated_slots() const { return calibrated_slots_; }

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
  int expansion() const { return expansion_; }
  /// Factor of θ on every deformation. Cycle-safe.
  double expansion_factor(const Eigen::VectorXd& theta) const;
  /// A deformation as it is without that factor, and its derivatives by θ: both with it. Cycle-safe.
  void expand(const Eigen::VectorXd& theta, double& length_m, Eigen::Ref<Eigen::VectorXd> slope) const;
  /// These parameters as another model has them (of the same machine): by name, 0 where it has no such. Allocates.
  Eigen::VectorXd as_in(const ParameterModel& other, const Eigen::VectorXd& theta) const;
  int capacity(Eigen::Index node) const { return capacity_[static_cast<std::size_t>(node)]; }
  bool has_capacities() const { return !capacity_.empty() && capacity_.front() >= 0; }
  int disturbance(Eigen::Index group) const { return disturbance_[static_cast<std::size_t>(group)]; }
  Eigen::Index group_count() const { return static_cast<Eigen::Index>(disturbance_.size()); }
  bool has_disturbances() const { return !disturbance_.empty() && disturbance_.front() >= 0; }
  /// The start parameters are the last of θ, one per shape from here on, the uniform one first; -1 without.
  int start() const { return start_; }
  Eigen::Index starts() const { return start_ < 0 ? 0 : count() - start_; }
  bool is_start(Eigen::Index i) const { return start_ >= 0 && i >= start_; }
  bool is_start_of_group(Eigen::Index i) const { return is_start(i) && i >= count() - std::ssize(groups_); }

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
  /// What laws of friction, speed and expansion are wrong by.
  void add_laws(const rom::Network& network, const EstimatorPriors& priors);
  void add_capacities(const rom::Network& network, const EstimatorPriors& priors);
  void add_disturbances(const rom::Network& network, const EstimatorPriors& priors);
  void add_starts(const rom::Network& network, const EstimatorPriors& priors);
  void take_calibrated();
  /// Parameters of one cause that all of them share; its deviation.
  struct SharedCause {
    std::vector<int> slots;
    double deviation = 0.0;
  };

  std::vector<Parameter> list_;
  std::shared_ptr<const CalibratedPrior> calibrated_;
  std::vector<Eigen::Index> calibrated_slots_;  // of its parameters
  Eigen::VectorXd mean_;
  std::vector<int> heat_, exponent_, conductance_, environment_, capacity_, disturbance_;
  std::vector<ThermalGroup> groups_;
  std::vector<StartShape> shapes_;
  Eigen::MatrixXd node_heat_;  // N x groups: where a watt into each group goes
  int bearing_ = -1, expansion_ = -1, start_ = -1;
  std::vector<bool> friction_;
  double reference_speed_rpm_ = 0.0;
  SharedCause all_heats_, frictions_, fits_;
};

}  // namespace spindle_twin::correction
