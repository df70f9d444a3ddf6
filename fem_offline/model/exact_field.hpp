#pragma once

#include <array>
#include <functional>

#include "fem_offline/description/spindle.hpp"

namespace spindle_twin::fem_offline {

/// A field known in closed form, with its derivatives along r and z.
struct ExactField {
  std::function<double(const Point&)> value;
  std::function<std::array<double, 2>(const Point&)> gradient;
};

/// Relative errors in the L2 norm over the volume.
struct FieldError {
  double value = 0.0;     ///< ‖T_h − T‖ / ‖T‖
  double gradient = 0.0;  ///< ‖∇T_h − ∇T‖ / ‖∇T‖; of the flux too where the conductivity is one
};

}  // namespace spindle_twin::fem_offline
