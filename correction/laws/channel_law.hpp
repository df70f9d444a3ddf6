#pragma once

namespace spindle_twin::correction {

/// G/A of a channel segment [W/m²K]: G = W (1 − exp(−hA/W)) with h the film coefficient, A the wetted area > 0 and
/// W = |ṁ| c >= 0 the heat that the flow carries per kelvin. 0 without flow; h as W grows. Cycle-safe.
double channel_W_per_m2K(double film_W_per_m2K, double area_m2, double flow_W_per_K);

}  // namespace spindle_twin::correction
