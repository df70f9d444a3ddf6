#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace spindle_twin::correction {

/// How the ratio of rises is formed from the window means t_m (measured) and t_f (model) of the valid sensors.
/// t_base is the model with the group's sources off, t_i the temperature at the last reset, t_inf the first ambient.
enum class RatioForm : std::uint8_t {
  consistent,           ///< sum(t_m - t_base) / sum(t_f - t_base)
  average_ratio,        ///< 1 / (1 - mean r), r = (t_m - t_f) / (t_m - t_i): section 3.3 read so that a match gives 1
  as_printed_eq3,       ///< mean of (t_m - t_inf) / (t_f - t_inf)
  as_printed_additive,  ///< max(0, 1 + mean r): section 3.3 word for word; kills the source once t_f rises twice t_m
};

/// Ratio of rises above the form's own zero, and the smallest rises it was formed from (for the guard).
struct RiseRatio {
  double ratio = 1.0;
  double measured_rise_K = 0.0;  ///< consistent: mean over the sensors; other forms: the smallest in magnitude
  double model_rise_K = 0.0;
};

/// `zero_K` is t_base, t_i or t_inf per sensor, as the form asks. All of the same length >= 1. A zero denominator gives
/// a ratio that is not finite, with the rise that says so. Cycle-safe.
RiseRatio rise_ratio(RatioForm form, const Eigen::Ref<const Eigen::VectorXd>& measured_K,
                     const Eigen::Ref<const Eigen::VectorXd>& model_K, const Eigen::Ref<const Eigen::VectorXd>& zero_K);

}  // namespace spindle_twin::correction
