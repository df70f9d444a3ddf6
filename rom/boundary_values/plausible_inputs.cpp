#include "rom/boundary_values/plausible_inputs.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"
#include "rom/boundary_values/held_law.hpp"
#include "rom/units.hpp"

namespace spindle_twin::rom {
namespace {

constexpr double speed_reserve = 2.0;
constexpr double most_load = 3.0;
constexpr double coolant_within_K = 25.0;
constexpr double ambient_within_K = 30.0;
constexpr double flow_reserve = 5.0;
constexpr double heat_reserve = 5.0;
constexpr double heat_backwards = 0.5;
constexpr Range film_W_per_m2K = between(0.1, 5e4);
constexpr Range contact_W_per_m2K = between(1.0, 1e6);
constexpr double fastest_warming_K_per_s = 1.0;
constexpr Range result_degC = between(-40.0, 300.0);

/// What the description says of it, or the default.
Range said(const Boundaries& boundaries, const std::string& of, Range otherwise) {
  for (const PlausibleRange& own : boundaries.plausible) {
    if (own.of == of) return own.range;
  }
  return otherwise;
}

Range either_way(double most) { return most > 0.0 ? between(-most, most) : any_number; }

/// Round to what a message needs: hundredths, of small values three digits.
std::string rounded(double value) {
  const double digits = value == 0.0 ? 0.0 : std::floor(std::log10(std::abs(value)));
  const double steps_per_unit = std::pow(10.0, std::max(2.0, 2.0 - digits));
  return printed(std::round(value * steps_per_unit) / steps_per_unit);
}

void judge(double value, Range believed, const std::string& field, const std::string& unit,
           std::vector<Implausible>& found) {
  if (auto amiss = judge_value(value, believed, field, unit)) found.push_back(std::move(*amiss));
}

Range shifted(Range range, double by) { return between(range.min + by, range.max + by); }

}  // namespace

std::optional<Implausible> judge_value(double value, Range believed, const std::string& field,
                                       const std::string& unit) {
  if (is_allowed(believed, value)) return std::nullopt;
  return Implausible{field, rounded(value) + " is not plausible; believed is " + rounded(believed.min) + " to " +
                                rounded(believed.max) + " " + unit};
}

PlausibleInputs plausible_inputs(const Boundaries& boundaries, double certified_rpm) {
  const double fastest_rpm =
      std::max({std::abs(boundaries.operating.speed_rpm), boundaries.reference_speed_rpm, certified_rpm});
  PlausibleInputs believed{said(boundaries, "speed_rpm", either_way(speed_reserve * fastest_rpm)),
                           said(boundaries, "load", either_way(most_load)),
                           {},
                           {},
                           {}};
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    const double middle_K = boundaries.operating.environment_K[static_cast<Eigen::Index>(e)];
    const double reach_K =
        boundaries.environments[e].kind == EnvironmentKind::coolant ? coolant_within_K : ambient_within_K;
    believed.environment_K.push_back(said(boundaries, plausible_temperature_prefix + boundaries.environments[e].name,
                                          between(middle_K - reach_K, middle_K + reach_K)));
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    const double described_kg_per_s = std::abs(boundaries.operating.flow_kg_per_s[static_cast<Eigen::Index>(c)]);
    believed.flow_kg_per_s.push_back(said(boundaries, plausible_flow_prefix + boundaries.circuits[c].name,
                                          either_way(flow_reserve * described_kg_per_s)));
  }
  for (const std::size_t heat : measured_heats(boundaries)) {
    const double described_W = boundaries.sources[heat].nominal_W;
    believed.heat_W.push_back(described_W > 0.0 ? between(-heat_backwards * described_W, heat_reserve * described_W)
                                                : any_number);
  }
  return believed;
}

std::vector<Implausible> implausible_inputs(const Boundaries& boundaries, const PlausibleInputs& believed,
                                            const OperatingState& state) {
  std::vector<Implausible> found;
  judge(state.speed_rpm, believed.speed_rpm, "speed_rpm", "rpm", found);
  judge(state.load, believed.load, "load", "as a share of the rated load, 1 and not 100 when it is full", found);
  for (std::size_t e = 0; e < boundaries.environments.size(); ++e) {
    judge(state.environment_K[static_cast<Eigen::Index>(e)] - zero_degC_K,
          shifted(believed.environment_K[e], -zero_degC_K), boundaries.environments[e].name + "_degC",
          "degC, not kelvin", found);
  }
  for (std::size_t c = 0; c < boundaries.circuits.size(); ++c) {
    judge(state.flow_kg_per_s[static_cast<Eigen::Index>(c)], believed.flow_kg_per_s[c],
          boundaries.circuits[c].name + "_kg_per_s", "kg/s, not kg/min", found);
  }
  const std::vector<std::size_t> measured = measured_heats(boundaries);
  for (std::size_t h = 0; h < measured.size(); ++h) {
    const auto slot = static_cast<Eigen::Index>(h);
    if (slot >= state.heat_W.size() || std::isnan(state.heat_W[slot])) continue;
    judge(state.heat_W[slot], believed.heat_W[h], boundaries.sources[measured[h]].name + "_W", "W, not kW", found);
  }
  return found;
}

std::vector<Implausible> implausible_description(const Boundaries& boundaries, double capacity_J_per_K) {
  std::vector<Implausible> found;
  const Range film = said(boundaries, "film_W_per_m2K", film_W_per_m2K);
  const Range touching = said(boundaries, "contact_W_per_m2K", contact_W_per_m2K);
  for (std::size_t i = 0; i < boundaries.conductances.size(); ++i) {
    const Conductance& conductance = boundaries.conductances[i];
    const bool contact = conductance.kind == ConductanceKind::contact;
    if (conductance.nominal_W_per_m2K == 0.0) continue;  // switched off on purpose
    const std::string field = (contact ? "contact " : "film ") + conductance.name;
    if (auto amiss = judge_value(conductance.nominal_W_per_m2K, contact ? touching : film, field, "W/m2K")) {
      amiss->conductance = i;
      found.push_back(std::move(*amiss));
    }
  }
  BoundaryValues values = make_boundary_values(boundaries);
  evaluate_boundaries(boundaries, boundaries.operating, no_correction(boundaries), values);
  const double heat_W = values.heat_W.sum();
  const Range believed_W = said(boundaries, "heat_W", between(0.0, fastest_warming_K_per_s * capacity_J_per_K));
  if (!is_allowed(believed_W, heat_W)) {
    const std::string least = believed_W.min > 0.0 ? rounded(believed_W.min) + " to " : "up to ";
    found.push_back({"source", rounded(heat_W) + " W in all are not plausible; they would warm the whole spindle (" +
                                   rounded(capacity_J_per_K) + " J/K) by " + rounded(heat_W / capacity_J_per_K) +
                                   " K/s, believed is " + least + rounded(believed_W.max) + " W"});
  }
  return found;
}

std::vector<Implausible> implausible_temperatures(const Boundaries& boundaries, double coldest_K, double hottest_K) {
  std::vector<Implausible> found;
  const Range believed_degC = shifted(said(boundaries, "result_K", shifted(result_degC, zero_degC_K)), -zero_degC_K);
  judge(coldest_K - zero_degC_K, believed_degC, "coldest temperature", "degC", found);
  judge(hottest_K - zero_degC_K, believed_degC, "hottest temperature", "degC", found);
  if (found.size() == 2) found.erase(found.begin());  // of two the hottest says more
  return found;
}

}  // namespace spindle_twin::rom
