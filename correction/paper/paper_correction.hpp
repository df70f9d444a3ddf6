#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "correction/paper/rise_ratio.hpp"
#include "rom/integrate/stepper.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// Why the last correction instant changed nothing. The number is what a status register publishes.
enum class Freeze : std::uint16_t {
  none = 0,
  waiting = 1,            ///< the first period has not passed
  too_few_sensors = 2,    ///< fewer valid sensors over the whole window than PaperGuards::minimum_sensors
  operating_changed = 3,  ///< speed or load changed within PaperGuards::settle_s
  standstill = 4,         ///< no heat to be seen
  small_rise = 5,         ///< a rise below max(10 u, minimum_rise_K)
  negative_ratio = 6,     ///< ratio <= 0 or not finite
  deadband = 7,           ///< |ln ratio| below u / rise: nothing to correct
  at_limit = 8,           ///< the cumulative limit is reached and the ratio points beyond it
  base_failed = 9,        ///< the base response could not be integrated
};

/// Sensors that judge and sources that follow one common factor.
struct HeatGroup {
  std::string name;
  std::vector<int> key_points;  ///< indices into Network::key_points
  std::vector<int> sources;     ///< indices into Boundaries::sources; a source is in one group at most
};

/// One group, all key points, all sources.
std::vector<HeatGroup> common_heat_group(const rom::Network& network);

struct PaperGuards {
  double reading_uncertainty_K = 0.03;  ///< u of a window mean against the base
  double minimum_rise_K = 0.3;
  double step_minimum = 0.8;  ///< of one correction
  double step_maximum = 1.25;
  double heat_minimum = 0.2;  ///< cumulative, on the description's heat
  double heat_maximum = 5.0;
  double resistance_minimum = 0.1;  ///< cumulative, on the description's contact resistance
  double resistance_maximum = 10.0;
  double resistance_step = 1.25;  ///< a contact moves by this factor at most per correction, up or down
  int minimum_sensors = 2;        ///< valid through the whole window; never more than the group has
  double settle_s = 80.0;         ///< no correction so long after a change of speed or load
  double speed_change_rpm = 50.0;
  double load_change = 0.05;
  double standstill_rpm = 1.0;
  bool deadband = true;
};

/// Guards so wide that none acts: for reproducing the law as it was published.
PaperGuards no_guards();

struct PaperOptions {
  double period_s = 80.0;   ///< between corrections
  double window_s = 10.0;   ///< last part of the period over which measured and model are averaged alike; 0: one sample
  double relaxation = 1.0;  ///< gamma in Q' = Q ratio^gamma, (0, 1]
  bool state_rescale = true;  ///< multiply the model's rise above the base by the same factor (see rescaled_nodes_K)
  bool heat_law = true;
  bool joint_law = true;
  double joint_exponent = 0.68;
  RatioForm form = RatioForm::consistent;
  std::vector<HeatGroup> groups;  ///< empty: common_heat_group
  PaperGuards guards;
};

/// What the cycle hands over at time_s: all of the same instant, one entry per Network::key_points.
struct PaperSample {
  double time_s = 0.0;
  const Eigen::VectorXd& measured_K;
  const Eigen::Array<bool, Eigen::Dynamic, 1>& valid;
  const Eigen::VectorXd& predicted_K;
  const Eigen::VectorXd& nodes_K;
  const rom::OperatingState& operating;
};

struct PaperStep {
  bool corrected = false;       ///< factors() changed in this call
  bool state_rescaled = false;  ///< the caller sets its stepper to rescaled_nodes_K() before it integrates on
};

/// The paper's correction: every period_s one factor on the heat of each group and one on each contact with a fit.
///
///   heat      Q' = Q · clamp(ratio^gamma)                            ratio as in RatioForm
///   joint     R' = R (1 + dP/P0)^-0.68, dP from rom::JointFit and the mean rises of the two bodies since assembly,
///             the model's part means shifted by the mean residual of the sensors on that part
///   state     T' = T_base + clamp(ratio^gamma) (T - T_base)          optional
///
/// T_base integrates the network beside the caller's, with the group's sources off and the same conductances,
/// environments and other sources: by superposition T - T_base is the group's own rise.
/// step() may run in the cycle: no allocation after construction, cost = one Stepper::advance per group.
class PaperCorrection {
 public:
  using StepperFactory = std::function<std::unique_ptr<rom::Stepper>()>;

  /// `network` must outlive this. Throws rom::InputError naming the option for one out of range.
  PaperCorrection(const rom::Network& network, PaperOptions options, const StepperFactory& make_stepper);
  ~PaperCorrection();
  PaperCorrection(PaperCorrection&&) noexcept;
  PaperCorrection& operator=(PaperCorrection&&) noexcept;

  /// Starts anew at time_s from these nodes, which count as unheated (base = nodes); the factors are kept.
  void reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating);

  /// Takes the sample at time_s, corrects if a period has passed, then carries the base to time_s + advance_s with
  /// the new factors, as the caller does with its own model. The first call resets by itself.
  PaperStep step(const PaperSample& sample, double advance_s);

  /// Instead of step() while the correction is switched off and the caller's model runs with all factors 1: all factors
  /// go back to 1, the base is carried on with them, so that T - T_base stays what the uncorrected heats have done, and
  /// the next step() begins a new period. May run in the cycle, as step().
  void stand_by(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating, double advance_s);

  const rom::CorrectionFactors& factors() const;
  /// All nodes of the corrected model; meaningful when the last step() said state_rescaled.
  const Eigen::VectorXd& rescaled_nodes_K() const;
  int groups() const;
  Freeze freeze(int group) const;  ///< of the last correction instant
  double ratio(int group) const;  ///< of the last correction instant, before clamp and relaxation; 1 if none was formed
  double base_rise_K(
      int group) const;  ///< mean rise of the group's key points above the base, of the last correction instant

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace spindle_twin::correction
