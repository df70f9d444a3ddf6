#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "correction/paper/base_response.hpp"
#include "correction/paper/heat_law.hpp"
#include "correction/paper/joint_law.hpp"
#include "correction/paper/measuring_window.hpp"
#include "correction/paper/operating_changes.hpp"
#include "correction/paper/paper_options.hpp"
#include "rom/integrate/stepper.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

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

  /// Starts anew at time_s from these nodes, which count as unheated (base = nodes); the factors are kept.
  void reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating);

  /// Takes the sample at time_s, corrects if a period has passed, then carries the base to time_s + advance_s with
  /// the new factors, as the caller does with its own model. The first call resets by itself.
  PaperStep step(const PaperSample& sample, double advance_s);

  /// Instead of step() while the correction is switched off and the caller's model runs with all factors 1: all factors
  /// go back to 1, the base is carried on with them, so that T - T_base stays what the uncorrected heats have done, and
  /// the next step() begins a new period. May run in the cycle, as step().
  void stand_by(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating, double advance_s);

  const rom::CorrectionFactors& factors() const { return factors_; }
  /// All nodes of the corrected model; meaningful when the last step() said state_rescaled.
  const Eigen::VectorXd& rescaled_nodes_K() const { return rescaled_K_; }
  int groups() const { return static_cast<int>(groups_.size()); }
  Freeze freeze(int group) const { return heat(group).freeze(); }  ///< of the last correction instant
  double ratio(int group) const { return heat(group).ratio(); }    ///< likewise, see HeatLaw
  double base_rise_K(int group) const { return heat(group).rise_K(); }

 private:
  /// The heat of a group, and what the network would do without it.
  struct Group {
    HeatLaw heat;
    BaseResponse base;
    Eigen::VectorXd own_rise_K;  ///< per node, used while the state is rescaled
  };

  const HeatLaw& heat(int group) const { return groups_.at(static_cast<std::size_t>(group)).heat; }
  void clear_window();
  PaperStep correct(const PaperSample& sample);
  bool correct_heats(const PaperSample& sample);
  void rescale_state(const Eigen::VectorXd& nodes_K);
  void advance_bases(const rom::OperatingState& operating, const Eigen::VectorXd& nodes_K, double advance_s);

  const rom::Network* network_;
  PaperOptions options_;
  std::vector<Group> groups_;
  JointLaw joints_;
  MeasuringWindow window_;
  OperatingChanges operating_;
  rom::CorrectionFactors factors_;
  Eigen::MatrixXd key_point_rows_;
  Eigen::VectorXd start_K_;  ///< of the key points, at the last reset
  Eigen::VectorXd rescaled_K_, base_nodes_K_;
  double due_s_ = 0.0;
  bool started_ = false;
};

}  // namespace spindle_twin::correction
