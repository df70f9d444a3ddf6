#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

#include "rom/boundaries.hpp"

namespace spindle_twin::fem_offline {

/// The box of parameters over which a network holds. Film factors come on top of the speed law.
struct ParameterBox {
  double contact_low = 0.1;
  double contact_high = 10.0;
  double film_low = 0.2;
  double film_high = 5.0;
  double speed_high_rpm = 24000.0;
  double load_high = 1.0;
  /// Coolant flow as a factor on flow_scale_kg_per_s; drive cycles also stop and reverse it.
  double flow_low = 0.05;
  double flow_high = 2.0;
};

/// What a random stream is for; streams of one seed never overlap.
enum class StreamPurpose : std::uint32_t {
  full_snapshots = 1,
  rich_snapshots = 2,
  candidates = 3,
  verification = 4,
  size_choice = 5,
  drift = 6,
  full_histories = 7,
  worst_search = 8
};

/// Random numbers that depend on (seed, purpose, index) alone, so that item k is the same whatever runs beside it.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, StreamPurpose purpose, std::uint32_t index);
  double uniform(double low, double high);
  double log_uniform(double low, double high);

 private:
  std::mt19937_64 engine_;
};

/// The box's range of factors on a conductance.
rom::Range factor_range(const ParameterBox& box, const rom::Conductance& conductance);

/// One random factor per conductance: contacts log-uniform in [contact_low, contact_high], all films in
/// [film_low, film_high]; with `corner` every factor at one end of its range.
Eigen::VectorXd random_conductance_factors(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                           RandomStream& random);

/// The description's flow of a circuit, or, where that is zero, the flow at which hA = ṁ c. > 0.
double flow_scale_kg_per_s(const rom::Boundaries& boundaries, std::size_t circuit);

/// A drive cycle's flow of every circuit: at rest one time in six, backwards one time in five, log-uniform in the box.
/// Draws nothing where there is no circuit.
Eigen::VectorXd random_flow_kg_per_s(const rom::Boundaries& boundaries, const ParameterBox& box, RandomStream& random);

/// Conductances [W/m²K] at a random speed, coolant flow and random factors; with `corner` at one end of every range.
Eigen::VectorXd random_conductances(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                    RandomStream& random);

}  // namespace spindle_twin::fem_offline
