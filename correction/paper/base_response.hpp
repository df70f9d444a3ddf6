#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "rom/boundaries.hpp"
#include "rom/integrate/network_operator.hpp"
#include "rom/integrate/stepper.hpp"
#include "rom/network.hpp"

namespace spindle_twin::correction {

/// T_base of one group: the network integrated beside the caller's with the group's sources off and the same
/// conductances, environments and other sources. By superposition T − T_base is the group's own rise; that holds for
/// heats and conductances that do not depend on which of two solutions is asked, so physical laws are held at what they
/// are at the corrected network's temperatures. No allocation after construction; may run in the cycle.
class BaseResponse {
 public:
  /// `network` must outlive this. `coordinates`: of a network with physical laws, else empty.
  BaseResponse(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> coordinates,
               std::unique_ptr<rom::Stepper> stepper, std::vector<int> sources);

  const Eigen::VectorXd& temperatures_K() const { return stepper_->temperatures_K(); }
  void set_temperatures(const Eigen::VectorXd& nodes_K) { stepper_->set_temperatures(nodes_K); }

  /// Carries it on by advance_s; `factors` and `nodes_K` are those of the corrected network.
  void advance(const rom::OperatingState& operating, const rom::CorrectionFactors& factors,
               const Eigen::VectorXd& nodes_K, double advance_s);
  /// Whether a step of this window could not be integrated.
  bool failed() const { return failed_; }

  void clear_window();
  /// Counts the present temperatures at the key points.
  void add_to_window(const Eigen::MatrixXd& key_point_rows);
  /// Mean over the window's samples.
  double mean_K(Eigen::Index key_point, int samples) const { return sum_K_[key_point] / samples; }

 private:
  const rom::Network* network_;
  std::shared_ptr<const rom::NetworkOperator> coordinates_;
  std::unique_ptr<rom::Stepper> stepper_;
  std::vector<int> sources_;
  rom::CorrectionFactors factors_;  ///< the common factors with this group's heat off
  rom::BoundaryValues values_;
  Eigen::VectorXd sum_K_, now_K_;  ///< per key point
  bool failed_ = false;
};

}  // namespace spindle_twin::correction
