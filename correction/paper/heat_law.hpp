#pragma once

#include <Eigen/Core>

#include "correction/paper/base_response.hpp"
#include "correction/paper/measuring_window.hpp"
#include "correction/paper/paper_options.hpp"

namespace spindle_twin::correction {

/// Times that do not quite meet by rounding count as met: a period of 80 cycles of 1 s must not slip.
inline constexpr double time_slack_s = 1e-6;

/// What the heat law knows of the instant of a correction.
struct HeatInstant {
  double speed_rpm = 0.0;
  double settled_s = 0.0;          ///< since speed or load last changed
  double ambient_K = 0.0;          ///< zero of RatioForm::as_printed_eq3
  const Eigen::VectorXd& start_K;  ///< of the key points at the last reset: zero of the other forms but `consistent`
};

/// The heat law of one group, Q' = Q · clamp(ratio^gamma): one factor, and why it moved or did not. No allocation after
/// construction; may run in the cycle.
class HeatLaw {
 public:
  explicit HeatLaw(HeatGroup members);

  /// Forms the ratio over the window and moves the factor if no guard forbids it. Whether it moved.
  bool correct(const PaperOptions& options, const MeasuringWindow& window, const BaseResponse& base,
               const HeatInstant& instant);
  /// Instead of correct() where the heat law is switched off.
  void pass() { freeze_ = Freeze::none; }
  /// Waits for the first period to pass; the factor stays.
  void wait() { freeze_ = Freeze::waiting; }
  /// Likewise, with factor 1.
  void stand_by();

  const HeatGroup& members() const { return members_; }
  double factor() const { return factor_; }
  double step() const { return step_; }      ///< of the last correction instant: factor / factor before it
  double ratio() const { return ratio_; }    ///< likewise, before clamp and relaxation; 1 if none was formed
  double rise_K() const { return rise_K_; }  ///< likewise, mean rise of the group's key points above the base
  Freeze freeze() const { return freeze_; }

 private:
  Freeze judge(const PaperOptions& options, const MeasuringWindow& window, const BaseResponse& base,
               const HeatInstant& instant);
  /// Fills the sensor lists with window means; returns how many are valid over the whole window.
  Eigen::Index gather(RatioForm form, const MeasuringWindow& window, const BaseResponse& base,
                      const HeatInstant& instant);
  Freeze judge_ratio(const PaperOptions& options, Eigen::Index sensors);
  Freeze move(double relaxation, const PaperGuards& guards);

  HeatGroup members_;
  Eigen::VectorXd measured_K_, model_K_, zero_K_;  ///< the group's valid sensors, first entries used
  double factor_ = 1.0, step_ = 1.0, ratio_ = 1.0, rise_K_ = 0.0;
  Freeze freeze_ = Freeze::waiting;
};

}  // namespace spindle_twin::correction
