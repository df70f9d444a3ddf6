#include "correction/estimator/held_period.hpp"

#include <utility>

#include "correction/estimator/inputs_changed.hpp"
#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::correction {

HeldPeriod::HeldPeriod(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> coordinates)
    : network_(&network),
      coordinates_(std::move(coordinates)),
      held_(network.boundaries.operating),
      corrected_(held_),
      values_(make_boundary_values(network.boundaries)),
      start_K_(Eigen::VectorXd::Zero(coordinates_->nodes())) {
  // Room for those of the factors; without, evaluating them would allocate in the first period.
  values_.node_heat_W = Eigen::VectorXd::Zero(coordinates_->nodes());
  values_.capacity_factor = Eigen::VectorXd::Ones(coordinates_->nodes());
}

void HeldPeriod::open(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating,
                      const rom::CorrectionFactors& factors, const Eigen::VectorXd& environment_bias_K) {
  held_ = operating;
  corrected_ = held_;
  corrected_.environment_K += environment_bias_K;
  evaluate_boundaries(network_->boundaries, corrected_, factors, values_);
  coordinates_->laws().at_temperatures(nodes_K, values_);
  start_K_ = nodes_K;
  opened_s_ = time_s;
  open_ = true;
}

bool HeldPeriod::differs(const rom::OperatingState& operating) const { return inputs_changed(operating, held_); }

double HeldPeriod::close(double time_s, const Eigen::VectorXd& nodes_K, const Eigen::VectorXd& theta,
                         const ParameterModel& parameters, Sensitivities& sensitivities) {
  if (!open_) return 0.0;
  open_ = false;
  const double period_s = time_s - opened_s_;
  const bool carried =
      sensitivities.advance({period_s, held_.speed_rpm, start_K_, nodes_K, values_, theta}, parameters);
  return carried ? period_s : -period_s;
}

}  // namespace spindle_twin::correction
