#pragma once

#include <string>
#include <vector>

#include "correction/estimator/estimator_correction.hpp"
#include "rom/boundary_values/schedule.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// Where a temperature can be taken: a key point, a node, or the mean of a part.
struct SensorPlace {
  std::string name;
  std::string part;
  double r_m = 0.0;
  double z_m = 0.0;
  Eigen::VectorXd row;  ///< N
};

/// All places of a network, key points first.
std::vector<SensorPlace> sensor_places(const rom::Network& network);

/// Places by name, in the order asked. Throws rom::InputError naming `field` and listing what there is.
std::vector<SensorPlace> find_places(const rom::Network& network, const std::vector<std::string>& names,
                                     const std::string& field);

struct IdentifyOptions {
  EstimatorPriors priors;
  double sample_s = 10.0;                 ///< between readings
  double noise_K = 0.03;                  ///< 1σ of one reading
  double offset_deviation_K = 0.0;        ///< 1σ of each sensor's constant error
  double floor_K = 0.0;                   ///< 1σ of what the network is wrong at a sensor
  double correlation_s = 60.0;            ///< readings closer than this share noise and floor; 0: each stands alone
  int placements = 3;                     ///< further sensors to look for
  std::vector<std::string> closed_parts;  ///< parts that no further sensor can be put on: what turns
};

/// Priors of a yardstick: heats, joints and films unknown, everything else as described, nothing wandering.
EstimatorPriors constant_priors();

struct IdentifiedParameter {
  std::string name;
  ParameterKind kind = ParameterKind::heat;
  ParameterEstimate estimate;  ///< value: where it was linearised
};

/// The sensor that leaves least of the first deformation open, after all before it are in place.
struct Placement {
  SensorPlace place;
  double deformation_m = 0.0;  ///< 1σ with it
};

struct Identification {
  double growth_m = 0.0;          ///< first deformation at the end of the drive cycle
  double prior_m = 0.0;           ///< 1σ of it without sensors
  double posterior_m = 0.0;       ///< with them
  std::vector<double> without_m;  ///< 1σ where this one sensor is left out, all others in place
  std::vector<IdentifiedParameter> parameters;
  std::vector<Placement> placements;       ///< one after another
  std::vector<Placement> first_placement;  ///< every open place as the next sensor, best first
};

/// Linearised Bayesian posterior over a drive cycle from a cold start, at the values of the description:
///   P⁻¹ = P₀⁻¹ + Σ_t Σ_s hᵀh / r,  h = l_s S(t),    σ² = l S(end) P S(end)ᵀ lᵀ with l the first deformation's row.
/// No reading is used, so it tells before any sensor is bought what a set of them can know.
/// Throws rom::InputError for a network without deformation, std::runtime_error if the network cannot be integrated.
Identification identify(const rom::Network& network, const std::vector<SensorPlace>& sensors,
                        const rom::Schedule& schedule, const IdentifyOptions& options);

}  // namespace spindle_twin::correction
