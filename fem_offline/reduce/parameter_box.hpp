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
};

/// What a random stream is for; streams of one seed never overlap.
enum class StreamPurpose : std::uint32_t { full_snapshots = 1, rich_snapshots = 2, candidates = 3, verification = 4 };

/// Random numbers that depend on (seed, purpose, index) alone, so that item k is the same whatever runs beside it.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, StreamPurpose purpose, std::uint32_t index);
  double uniform(double low, double high);
  double log_uniform(double low, double high);

 private:
  std::mt19937_64 engine_;
};

/// One random factor per conductance: contacts log-uniform in [contact_low, contact_high], all films in
/// [film_low, film_high]; with `corner` every factor at one end of its range.
Eigen::VectorXd random_conductance_factors(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                           RandomStream& random);

/// Conductances [W/m²K] at a random speed and random factors; with `corner` at one end of every range.
Eigen::VectorXd random_conductances(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                    RandomStream& random);

}  // namespace spindle_twin::fem_offline
