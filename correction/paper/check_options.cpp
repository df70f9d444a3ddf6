#include "correction/paper/check_options.hpp"

#include "rom/read/input_error.hpp"

namespace spindle_twin::correction {
namespace {

void require(bool allowed, const char* option, const char* message) {
  if (!allowed) throw rom::InputError({}, option, message);
}

}  // namespace

void check_options(const rom::Network& network, const PaperOptions& options) {
  const PaperGuards& guards = options.guards;
  // Written so that NaN fails.
  require(options.period_s > 0.0, "period_s", "must be above 0 s");
  require(options.window_s >= 0.0 && options.window_s <= options.period_s, "window_s", "must be from 0 s to period_s");
  require(options.relaxation > 0.0 && options.relaxation <= 1.0, "relaxation", "must be above 0 and at most 1");
  require(options.joint_exponent >= 0.0 && options.joint_exponent <= 1.0, "joint_exponent", "must be from 0 to 1");
  require(guards.reading_uncertainty_K >= 0.0, "reading_uncertainty_K", "must be at least 0 K");
  require(guards.minimum_rise_K >= 0.0, "minimum_rise_K", "must be at least 0 K");
  require(guards.step_minimum >= 0.0 && guards.step_minimum < 1.0, "step_minimum", "must be from 0 to below 1");
  require(guards.step_maximum > 1.0, "step_maximum", "must be above 1");
  require(guards.heat_minimum >= 0.0 && guards.heat_minimum < 1.0, "heat_minimum", "must be from 0 to below 1");
  require(guards.heat_maximum > 1.0, "heat_maximum", "must be above 1");
  require(guards.resistance_minimum >= 0.0 && guards.resistance_minimum < 1.0, "resistance_minimum",
          "must be from 0 to below 1");
  require(guards.resistance_maximum > 1.0, "resistance_maximum", "must be above 1");
  require(guards.resistance_step > 1.0, "resistance_step", "must be above 1");
  require(guards.minimum_sensors >= 1, "minimum_sensors", "must be at least 1");
  require(guards.settle_s >= 0.0, "settle_s", "must be at least 0 s");
  require(guards.speed_change_rpm >= 0.0, "speed_change_rpm", "must be at least 0 rpm");
  require(guards.load_change >= 0.0, "load_change", "must be at least 0");
  require(guards.standstill_rpm >= 0.0, "standstill_rpm", "must be at least 0 rpm");

  std::vector<bool> taken(network.boundaries.sources.size(), false);
  for (const HeatGroup& group : options.groups) {
    const std::string field = "group " + group.name;
    if (group.key_points.empty()) throw rom::InputError({}, field, "needs at least one key point");
    if (group.sources.empty()) throw rom::InputError({}, field, "needs at least one heat source");
    for (const int key_point : group.key_points) {
      if (key_point < 0 || static_cast<std::size_t>(key_point) >= network.key_points.size()) {
        throw rom::InputError({}, field, "names a key point that the network does not have");
      }
    }
    for (const int source : group.sources) {
      if (source < 0 || static_cast<std::size_t>(source) >= taken.size()) {
        throw rom::InputError({}, field, "names a heat source that the network does not have");
      }
      if (taken[static_cast<std::size_t>(source)]) {
        throw rom::InputError({}, field, "a heat source may be in one group only");
      }
      taken[static_cast<std::size_t>(source)] = true;
    }
  }
}

}  // namespace spindle_twin::correction
