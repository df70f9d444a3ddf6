#include "firmware/cycle/forecast.hpp"

#include <algorithm>
#include <cmath>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::firmware {

Forecast::Forecast(const rom::Network& network, const ForecastPlan& plan, const MakeStepper& make_stepper)
    : network_(network),
      plan_(plan),
      model_(make_model(network, make_stepper)),
      operating_(network.boundaries.operating),
      factors_(rom::no_correction(network.boundaries)) {}

void Forecast::step(const Model& now, const rom::OperatingState& operating, const rom::CorrectionFactors& factors) {
  if (++waited_ < plan_.every_cycles) return;
  waited_ = 0;
  if (done_ == 0) {
    operating_ = operating;
    factors_ = factors;
    model_.stepper->set_temperatures(now.stepper->temperatures_K());
    path_m_[0] = now.outputs.deformations_m[0];
  }
  if (integrate(network_, operating_, factors_, stride_s, model_) == Integrated::not_at_all) {
    done_ = 0;
    change_m_ = settled_after_s_ = std::numeric_limits<double>::quiet_NaN();
    return;
  }
  predict(network_, model_, factors_.expansion);
  path_m_[++done_] = model_.outputs.deformations_m[0];
  if (static_cast<double>(done_) * stride_s == plan_.ahead_s) change_m_ = path_m_[done_] - path_m_[0];
  if (done_ < strides) return;
  conclude();
  done_ = 0;
}

void Forecast::conclude() {
  constexpr auto window = static_cast<std::size_t>(settled_within_s / stride_s);
  std::size_t settled = strides + 1 - window;
  while (settled > 0) {
    const auto [least, most] = std::minmax_element(path_m_.begin() + static_cast<long>(settled) - 1,
                                                   path_m_.begin() + static_cast<long>(settled + window));
    if (*most - *least > plan_.settled_m) break;
    --settled;
  }
  const bool within = settled + window <= strides;
  settled_after_s_ = within ? static_cast<double>(settled) * stride_s : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace spindle_twin::firmware
