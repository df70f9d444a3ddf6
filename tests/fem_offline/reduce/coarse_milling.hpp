#pragma once

#include "fem_offline/description/spindle.hpp"
#include "fem_offline/model/build_model.hpp"

namespace spindle_twin::fem_offline {

/// The shipped milling spindle without the small elements of its description: one across thin parts, none finer at
/// corners and in balls.
inline FeModel coarse_milling(double element_size_m) {
  Spindle spindle = read_spindle(SPINDLE_TWIN_SOURCE_DIR "/fem_offline/spindles/four_bearing_milling.toml");
  spindle.mesh.element_size_m = element_size_m;
  spindle.mesh.cells_across = 1;
  spindle.mesh.corner_size_m.reset();
  for (Part& part : spindle.parts) part.element_size_m.reset();
  return FeModel(spindle, build_section(spindle));
}

}  // namespace spindle_twin::fem_offline
