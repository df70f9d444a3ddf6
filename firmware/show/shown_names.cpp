#include "firmware/show/shown_names.hpp"

#include <array>
#include <utility>

#include "rom/boundary_values/held_law.hpp"

namespace spindle_twin::firmware {
namespace {

template <class Named>
std::vector<std::string> names(const std::vector<Named>& things) {
  std::vector<std::string> all;
  for (const Named& thing : things) all.push_back(thing.name);
  return all;
}

}  // namespace

const std::vector<std::string>* ShownNames::of(std::string_view slot_names) const {
  const std::array<std::pair<std::string_view, const std::vector<std::string>*>, 7> lists{
      {{"key_points", &key_points},
       {"parts", &parts},
       {"sources", &sources},
       {"conductances", &conductances},
       {"deformations", &deformations},
       {"circuits", &circuits},
       {"heats", &heats}}};
  for (const auto& [name, list] : lists) {
    if (name == slot_names) return list;
  }
  return nullptr;
}

ShownNames names_of(const rom::Network& network) {
  ShownNames shown;
  shown.spindle = network.spindle;
  shown.key_points = names(network.key_points);
  shown.parts = names(network.parts);
  shown.sources = names(network.boundaries.sources);
  shown.conductances = names(network.boundaries.conductances);
  shown.deformations = names(network.deformations);
  shown.circuits = names(network.boundaries.circuits);
  for (const std::size_t heat : rom::measured_heats(network.boundaries)) {
    shown.heats.push_back(network.boundaries.sources[heat].name);
  }
  return shown;
}

}  // namespace spindle_twin::firmware
