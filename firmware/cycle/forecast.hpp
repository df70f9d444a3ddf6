#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "firmware/cycle/integrate.hpp"

namespace spindle_twin::firmware {

struct ForecastPlan {
  double ahead_s = 0.0;          ///< look-ahead, a multiple of Forecast::stride_s; 0: no forecast
  double settled_m = 1e-6;       ///< the growth has settled once it changes by less within settled_within_s
  std::size_t every_cycles = 1;  ///< one stride each so many cycles
};

/// How one deformation output goes on if speed, load, flows, surroundings and the correction's factors stay as they are
/// now. A model of its own runs ahead from the twin's temperatures, one stride a cycle, and begins anew at the horizon:
/// the cycle's time stays even, and a result is at most `strides` steps old.
class Forecast {
 public:
  static constexpr double stride_s = 300.0;
  static constexpr double settled_within_s = 600.0;
  static constexpr std::size_t strides = 48;  ///< a horizon of four hours

  /// `network` must outlive this. Allocates.
  Forecast(const rom::Network& network, const ForecastPlan& plan, const MakeStepper& make_stepper);

  /// One stride; before a round's first the state of `now` and the inputs it runs with are taken over. Runs in the
  /// cycle, no allocation unless the exact stepper is needed.
  void step(const Model& now, const rom::OperatingState& operating, const rom::CorrectionFactors& factors);

  /// Growth of the output between now and ahead_s later. NaN until the first round came so far. [m]
  double change_m() const { return change_m_; }
  /// From when on the growth stays within settled_m in every settled_within_s; NaN: not within the horizon, or not
  /// known yet. [s]
  double settled_after_s() const { return settled_after_s_; }

 private:
  void conclude();

  const rom::Network& network_;
  ForecastPlan plan_;
  Model model_;
  rom::OperatingState operating_;
  rom::CorrectionFactors factors_;
  std::array<double, strides + 1> path_m_{};
  std::size_t done_ = 0;  ///< strides of this round
  std::size_t waited_ = 0;
  double change_m_ = std::numeric_limits<double>::quiet_NaN();
  double settled_after_s_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace spindle_twin::firmware
