#pragma once

#include "rom/boundaries.hpp"

namespace spindle_twin::rom {

/// As people read it.
constexpr const char* kind_name(ConductanceKind kind) {
  switch (kind) {
    case ConductanceKind::contact:
      return "contact";
    case ConductanceKind::gap_film:
      return "gap film";
    case ConductanceKind::air_film:
      return "air film";
    case ConductanceKind::environment_film:
      return "environment film";
  }
  return "unknown";
}

/// Likewise.
constexpr const char* kind_name(EnvironmentKind kind) {
  return kind == EnvironmentKind::coolant ? "coolant" : "ambient";
}

}  // namespace spindle_twin::rom
