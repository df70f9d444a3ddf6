#include "correction/estimator/estimator_correction.hpp"
#include "correction/estimator/second_pass.hpp"

// The estimator's part of a second pass: where it begins, how it is held, and how the estimate goes over to it.
namespace spindle_twin::correction {

void EstimatorCorrection::note_instant(Instant& to) const {
  to.filter = filter_;
  to.sensitivities = sensitivities_.transposed();
  to.channels = channels_;
  to.consistency = consistency_;
  to.nodes_K = nodes_K_;
  to.flow_kg_per_s = known_flow_kg_per_s_;
  to.times = times_;
  to.open = open_;
  to.knows_calibration = knows_calibration_;
}

void EstimatorCorrection::hold(const Instant& from, const Eigen::VectorXd& unknowns,
                               const rom::OperatingState& operating) {
  filter_ = from.filter;
  sensitivities_.set_transposed(from.sensitivities);
  channels_ = from.channels;
  consistency_ = from.consistency;
  nodes_K_ = from.nodes_K;
  known_flow_kg_per_s_ = from.flow_kg_per_s;
  times_ = from.times;
  open_ = from.open;
  knows_calibration_ = from.knows_calibration;
  started_ = true;
  is_held_ = held_in_vain_ = false;
  displacement_.pending = false;
  // What had been known from the start is in the state: x += S (z̃ − z).
  made_.unknowns = filter_.mean();
  filter_.set_mean(unknowns);
  follow_filter();
  held_at_ = filter_.mean();
  filter_.set_mean(from.filter.mean());
  is_held_ = true;
  publish_factors(operating);
  period_.drop();
  open_period(times_.seen_s, operating);
}

void EstimatorCorrection::release() {
  is_held_ = false;
  made_.unknowns = held_at_;
  follow_filter();
}

void EstimatorCorrection::take_over(const EstimatorCorrection& pass, const rom::OperatingState& operating) {
  ++relinearised_;
  filter_ = pass.filter_;
  open_ = pass.open_;
  sensitivities_.set_transposed(pass.sensitivities_.transposed());
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    const double fused_s = channels_[s].fused_s;
    channels_[s] = pass.channels_[s];
    channels_[s].fused_s = fused_s;
    const Eigen::Index b = offset_at(static_cast<Eigen::Index>(s));
    records_[s].offset_K = filter_.mean()[b];
    records_[s].offset_deviation_K = filter_.deviation(b);
  }
  theta_ = pass.theta_;
  nodes_K_ = corrected_K_ = pass.corrected_K_;
  outputs_.clear_alternatives();
  note_curvature();
  publish_deviations();
  publish_factors(operating);
  period_.drop();
  open_period(times_.seen_s, operating);
}

void EstimatorCorrection::begin_another_record() {
  if (second_pass_) second_pass_->begin_anew();
}

}  // namespace spindle_twin::correction
