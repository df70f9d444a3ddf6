#pragma once

#include "rom/laws/smooth.hpp"

namespace spindle_twin::rom {

/// G/A of a channel segment [W/m²K]: G = W (1 − exp(−hA/W)) with h the film coefficient, A the wetted area > 0 and
/// W = |ṁ| c >= 0 the heat that the flow carries per kelvin. 0 without flow; h as W grows. Smooth over all W >= 0, with
/// dG/dW = 1 at zero flow: reversal has the corner of |ṁ|, which is the flow's own. Cycle-safe.
template <class Scalar>
Scalar channel_W_per_m2K(const Scalar& film_W_per_m2K, double area_m2, const Scalar& flow_W_per_K) {
  if (real_part(flow_W_per_K) == 0.0) return flow_W_per_K / area_m2;
  return flow_W_per_K * one_minus_exp(Scalar(film_W_per_m2K * area_m2 / flow_W_per_K)) / area_m2;
}

}  // namespace spindle_twin::rom
