#include "correction/paper/check_options.hpp"

#include "rom/read/input_error.hpp"
#include "rom/read/options.hpp"

namespace spindle_twin::correction {

void check_options(const rom::Network& network, const PaperOptions& options) {
  PaperOptions::each(options, rom::CheckOptions());
  PaperGuards::each(options.guards, rom::CheckOptions());
  if (options.window_s > options.period_s) throw rom::InputError({}, "window_s", "must be from 0 s to period_s");

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
