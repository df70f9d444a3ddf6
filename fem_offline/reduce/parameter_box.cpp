#include "fem_offline/reduce/parameter_box.hpp"

#include <cmath>

#include "rom/boundary_values/held_law.hpp"
#include "rom/laws/channel_law.hpp"

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

rom::Range factor_range(const ParameterBox& box, const rom::Conductance& conductance) {
  const bool contact = conductance.kind == rom::ConductanceKind::contact;
  return contact ? rom::between(box.contact_low, box.contact_high) : rom::between(box.film_low, box.film_high);
}

Eigen::VectorXd random_conductance_factors(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                           RandomStream& random) {
  Eigen::VectorXd factors(static_cast<Eigen::Index>(boundaries.conductances.size()));
  for (Eigen::Index j = 0; j < factors.size(); ++j) {
    const rom::Range range = factor_range(box, boundaries.conductances[static_cast<std::size_t>(j)]);
    if (corner) {
      factors[j] = random.uniform(0.0, 1.0) < 0.5 ? range.min : range.max;
    } else {
      factors[j] = random.log_uniform(range.min, range.max);
    }
  }
  return factors;
}

double flow_scale_kg_per_s(const rom::Boundaries& boundaries, std::size_t circuit) {
  const double described_kg_per_s = std::abs(boundaries.operating.flow_kg_per_s[static_cast<Eigen::Index>(circuit)]);
  if (described_kg_per_s > 0.0) return described_kg_per_s;
  double film_W_per_K = 0.0;
  for (const int segment : boundaries.circuits[circuit].segments) {
    const rom::Conductance& film = boundaries.conductances[static_cast<std::size_t>(segment)];
    film_W_per_K += film.nominal_W_per_m2K * film.area_m2;
  }
  return film_W_per_K / boundaries.circuits[circuit].heat_capacity_J_per_kgK;
}

Eigen::VectorXd random_flow_kg_per_s(const rom::Boundaries& boundaries, const ParameterBox& box, RandomStream& random) {
  Eigen::VectorXd flow_kg_per_s(static_cast<Eigen::Index>(boundaries.circuits.size()));
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const bool rest = random.uniform(0.0, 1.0) < 1.0 / 6.0;
    const double sign = random.uniform(0.0, 1.0) < 0.2 ? -1.0 : 1.0;
    const double factor = random.log_uniform(box.flow_low, box.flow_high);
    flow_kg_per_s[static_cast<Eigen::Index>(c)] = rest ? 0.0 : sign * factor * flow_scale_kg_per_s(boundaries, c);
  }
  return flow_kg_per_s;
}

Eigen::VectorXd random_conductances(const rom::Boundaries& boundaries, const ParameterBox& box, bool corner,
                                    RandomStream& random) {
  double speed_rpm = random.uniform(0.0, box.speed_high_rpm);
  if (corner) speed_rpm = speed_rpm < 0.5 * box.speed_high_rpm ? 0.0 : box.speed_high_rpm;
  const double load = random.uniform(0.0, box.load_high);
  rom::LawDrive drive;
  rom::set_machine(boundaries.operating, drive);
  drive.speed_rpm = speed_rpm;
  drive.load = load;
  Eigen::VectorXd conductances = random_conductance_factors(boundaries, box, corner, random);
  for (Eigen::Index j = 0; j < conductances.size(); ++j) {
    const rom::Conductance& item = boundaries.conductances[static_cast<std::size_t>(j)];
    conductances[j] *= rom::held_conductance_W_per_m2K(item, boundaries.reference_speed_rpm, 1.0, drive,
                                                       boundaries.operating.environment_K);
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    double factor = random.log_uniform(box.flow_low, box.flow_high);
    if (corner) factor = random.uniform(0.0, 1.0) < 0.5 ? box.flow_low : box.flow_high;
    const rom::CoolantCircuit& circuit = boundaries.circuits[c];
    const double flow_W_per_K = factor * flow_scale_kg_per_s(boundaries, c) * circuit.heat_capacity_J_per_kgK;
    for (const int segment : circuit.segments) {
      conductances[segment] = rom::channel_W_per_m2K(
          conductances[segment], boundaries.conductances[static_cast<std::size_t>(segment)].area_m2, flow_W_per_K);
    }
  }
  return conductances;
}

}  // namespace spindle_twin::fem_offline
