#pragma once

#include <Eigen/Core>
#include <memory>

#include "correction/estimator/parameters.hpp"
#include "correction/estimator/sensitivities.hpp"
#include "rom/integrate/network_operator.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// A stretch of time in which speed, load, current, power and flows stand still: over it the sensitivities are carried
/// in one step when it ends, because only then the model's temperatures at both ends are known. May run in the cycle
/// but for the constructor.
class HeldPeriod {
 public:
  HeldPeriod(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> coordinates);

  /// Begins at time_s with the model at these nodes and its corrected inputs.
  void open(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating,
            const rom::CorrectionFactors& factors, const Eigen::VectorXd& environment_bias_K);
  bool is_open() const { return open_; }
  /// What is held differs from this by more than the sensitivities bear (inputs_changed).
  bool differs(const rom::OperatingState& operating) const;
  double opened_s() const { return opened_s_; }
  /// Ends it without use.
  void drop() { open_ = false; }

  /// Ends it at time_s with the model at these nodes: S goes on by it. Its length, 0 where none was open; negative
  /// where the sensitivities could not be carried on, and stay.
  double close(double time_s, const Eigen::VectorXd& nodes_K, const Eigen::VectorXd& theta,
               const ParameterModel& parameters, Sensitivities& sensitivities);

 private:
  const rom::Network* network_;
  std::shared_ptr<const rom::NetworkOperator> coordinates_;
  rom::OperatingState held_, corrected_;
  rom::BoundaryValues values_;
  Eigen::VectorXd start_K_;
  double opened_s_ = 0.0;
  bool open_ = false;
};

}  // namespace spindle_twin::correction
