#include "correction/paper/base_response.hpp"

#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::correction {

BaseResponse::BaseResponse(const rom::Network& network, std::shared_ptr<const rom::NetworkOperator> coordinates,
                           std::unique_ptr<rom::Stepper> stepper, std::vector<int> sources)
    : network_(&network),
      coordinates_(std::move(coordinates)),
      stepper_(std::move(stepper)),
      sources_(std::move(sources)),
      factors_(rom::no_correction(network.boundaries)),
      values_(rom::make_boundary_values(network.boundaries)),
      sum_K_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.key_points.size()))),
      now_K_(sum_K_) {}

void BaseResponse::advance(const rom::OperatingState& operating, const rom::CorrectionFactors& factors,
                           const Eigen::VectorXd& nodes_K, double advance_s) {
  factors_.heat = factors.heat;
  factors_.conductance = factors.conductance;
  for (const int source : sources_) factors_.heat[source] = 0.0;
  rom::evaluate_boundaries(network_->boundaries, operating, factors_, values_);
  if (coordinates_) coordinates_->laws().at_temperatures(nodes_K, values_);
  values_.laws.follow = false;
  if (stepper_->advance(advance_s, values_) != rom::StepStatus::ok) failed_ = true;
}

void BaseResponse::clear_window() {
  sum_K_.setZero();
  failed_ = false;
}

void BaseResponse::add_to_window(const Eigen::MatrixXd& key_point_rows) {
  now_K_.noalias() = key_point_rows * stepper_->temperatures_K();
  sum_K_ += now_K_;
}

}  // namespace spindle_twin::correction
