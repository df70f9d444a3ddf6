#include "rom/boundary_values/environments.hpp"

namespace spindle_twin::rom {

std::optional<double> first_environment_K(const Boundaries& boundaries, EnvironmentKind kind,
                                          const OperatingState& state) {
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    if (boundaries.environments[e].kind == kind) return state.environment_K[static_cast<Eigen::Index>(e)];
  }
  return std::nullopt;
}

double rest_temperature_K(const Boundaries& boundaries, const OperatingState& state) {
  const auto ambient_K = first_environment_K(boundaries, EnvironmentKind::ambient, state);
  if (ambient_K) return *ambient_K;
  return state.environment_K.size() > 0 ? state.environment_K[0] : boundaries.reference_temperature_K;
}

}  // namespace spindle_twin::rom
