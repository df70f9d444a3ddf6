#include "fem_offline/reduce/parameter_box.hpp"

#include <cmath>

#include "correction/laws/speed_law.hpp"

namespace spindle_twin::fem_offline {

RandomStream::RandomStream(std::uint64_t seed, StreamPurpose purpose, std::uint32_t index) {
  std::seed_seq words{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                      static_cast<std::uint32_t>(purpose), index};
  engine_.seed(words);
}

double RandomStream::uniform(double low, double high) {
  // The engine is fixed by the standard, std::uniform_real_distribution is not.
  const double fraction = static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  return low + (high - low) * fraction;
}

double RandomStream::log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }

Eigen::VectorXd random_conductance_factors(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                           RandomStream& random) {
  Eigen::VectorXd factors(static_cast<Eigen::Index>(boundaries.conductances.size()));
  for (Eigen::Index j = 0; j < factors.size(); ++j) {
    const bool contact = boundaries.conductances[static_cast<std::size_t>(j)].kind == rom::ConductanceKind::contact;
    const double low = contact ? box.contact_low : box.film_low;
    const double high = contact ? box.contact_high : box.film_high;
    if (corner) {
      factors[j] = random.uniform(0.0, 1.0) < 0.5 ? low : high;
    } else {
      factors[j] = random.log_uniform(low, high);
    }
  }
  return factors;
}

Eigen::VectorXd random_conductances(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                    RandomStream& random) {
  double speed_rpm = random.uniform(0.0, box.speed_high_rpm);
  if (corner) speed_rpm = speed_rpm < 0.5 * box.speed_high_rpm ? 0.0 : box.speed_high_rpm;
  const double load = random.uniform(0.0, box.load_high);
  Eigen::VectorXd conductances = random_conductance_factors(boundaries, box, corner, random);
  for (Eigen::Index j = 0; j < conductances.size(); ++j) {
    const rom::Conductance& item = boundaries.conductances[static_cast<std::size_t>(j)];
    conductances[j] *= item.nominal_W_per_m2K *
                       correction::evaluate_speed_law(item.law, speed_rpm, boundaries.reference_speed_rpm, load);
  }
  return conductances;
}

}  // namespace spindle_twin::fem_offline
