#include "correction/estimator/inputs_changed.hpp"

#include <algorithm>
#include <cmath>

namespace spindle_twin::correction {
namespace {

constexpr double speed_share = 2e-3;
constexpr double load_change = 0.01;
constexpr double flow_share = 2e-3;
constexpr double motor_share = 0.05;

bool differs(double a, double b, double share) { return std::abs(a - b) > share * std::max(std::abs(a), std::abs(b)); }

bool differs(const std::optional<double>& a, const std::optional<double>& b, double share) {
  return a.has_value() != b.has_value() || (a && differs(*a, *b, share));
}

}  // namespace

bool inputs_changed(const rom::OperatingState& now, const rom::OperatingState& held) {
  if (differs(now.speed_rpm, held.speed_rpm, speed_share)) return true;
  if (std::abs(now.load - held.load) > load_change) return true;
  if (differs(now.current_A, held.current_A, motor_share) || differs(now.power_W, held.power_W, motor_share))
    return true;
  for (Eigen::Index c = 0; c < now.flow_kg_per_s.size(); ++c) {
    if (differs(now.flow_kg_per_s[c], held.flow_kg_per_s[c], flow_share)) return true;
  }
  for (Eigen::Index h = 0; h < now.heat_W.size(); ++h) {
    if (std::isnan(now.heat_W[h]) != std::isnan(held.heat_W[h])) return true;
    if (differs(now.heat_W[h], held.heat_W[h], motor_share)) return true;
  }
  return false;
}

}  // namespace spindle_twin::correction
