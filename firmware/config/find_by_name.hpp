#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "rom/read/input_error.hpp"

namespace spindle_twin::firmware {

/// Index of the thing of that name. Throws rom::InputError that lists the names there are.
template <class Named>
std::size_t find_by_name(const std::vector<Named>& things, const std::string& name, const char* kind,
                         const rom::SourceLine& where, const std::string& field) {
  const auto found = std::find_if(things.begin(), things.end(), [&](const Named& thing) { return thing.name == name; });
  if (found != things.end()) return static_cast<std::size_t>(found - things.begin());
  std::string names;
  for (const Named& thing : things) names += (names.empty() ? "" : ", ") + thing.name;
  throw rom::InputError(where, field, "the network has no " + std::string(kind) + " \"" + name + "\"; it has " + names);
}

}  // namespace spindle_twin::firmware
