#include "correction/estimator/estimator_correction.hpp"

#include <utility>

#include "correction/estimator/estimator_core.hpp"

namespace spindle_twin::correction {

std::vector<EstimatorSensor> key_point_sensors(const rom::Network& network, const EstimatorOptions& options) {
  std::vector<EstimatorSensor> sensors;
  for (const rom::KeyPoint& point : network.key_points) {
    sensors.push_back({point.name, point.row, options.noise_K, options.offset_K, options.lag_s});
  }
  return sensors;
}

struct EstimatorCorrection::Impl : EstimatorCore {
  using EstimatorCore::EstimatorCore;
};

EstimatorCorrection::EstimatorCorrection(const rom::Network& network, EstimatorOptions options)
    : impl_(std::make_unique<Impl>(network, std::move(options))) {}
EstimatorCorrection::~EstimatorCorrection() = default;
EstimatorCorrection::EstimatorCorrection(EstimatorCorrection&&) noexcept = default;
EstimatorCorrection& EstimatorCorrection::operator=(EstimatorCorrection&&) noexcept = default;

void EstimatorCorrection::reset(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating) {
  impl_->reset(time_s, nodes_K, operating);
}

EstimatorStep EstimatorCorrection::step(const EstimatorSample& sample, double) { return impl_->step(sample); }

void EstimatorCorrection::stand_by(double time_s, const Eigen::VectorXd& nodes_K, const rom::OperatingState& operating,
                                   double) {
  impl_->stand_by(time_s, nodes_K, operating);
}

void EstimatorCorrection::note_displacement(int index, double value_m, double deviation_m) {
  impl_->note_displacement(index, value_m, deviation_m);
}

void EstimatorCorrection::widen_offset(Eigen::Index sensor, double deviation_K) {
  impl_->widen_offset(sensor, deviation_K);
}

void EstimatorCorrection::widen_start(double time_s, const Eigen::VectorXd& nodes_K, const Eigen::VectorXd& rise_K) {
  impl_->widen_start(time_s, nodes_K, rise_K);
}

void EstimatorCorrection::note_tare(Eigen::Index sensor, double shift_K, double deviation_K) {
  impl_->note_tare(sensor, shift_K, deviation_K);
}

const EstimatorUpdate& EstimatorCorrection::last_update() const { return impl_->last_update; }
double EstimatorCorrection::gate() const { return impl_->options.gate; }
const SquareRootFilter& EstimatorCorrection::filter() const { return impl_->filter; }
const SquareRootFilter& EstimatorCorrection::prior() const { return impl_->prior; }
void EstimatorCorrection::passing_of_time(double elapsed_s, Eigen::VectorXd& keep, Eigen::VectorXd& growth) const {
  impl_->passing_of_time(elapsed_s, keep, growth);
}
void EstimatorCorrection::set_alternatives(const Eigen::MatrixXd& steps) { impl_->outputs.set_alternatives(steps); }
void EstimatorCorrection::adopt(const SquareRootFilter& other, const rom::OperatingState& operating) {
  impl_->adopt(other, operating);
}

void EstimatorCorrection::set_parameters(const Eigen::VectorXd& theta) {
  impl_->filter.set_first(theta);
  impl_->theta = theta;
}

const rom::CorrectionFactors& EstimatorCorrection::factors() const { return impl_->factors; }
const Eigen::VectorXd& EstimatorCorrection::environment_bias_K() const { return impl_->bias_K; }
const Eigen::VectorXd& EstimatorCorrection::corrected_nodes_K() const { return impl_->corrected_K; }
const ParameterModel& EstimatorCorrection::parameters() const { return impl_->parameters; }
ParameterEstimate EstimatorCorrection::estimate(Eigen::Index parameter) const {
  return {impl_->theta[parameter], impl_->filter.deviation(parameter), impl_->filter.scale()[parameter]};
}
const std::vector<EstimatorSensor>& EstimatorCorrection::sensors() const { return impl_->options.sensors; }
const SensorRecord& EstimatorCorrection::record(Eigen::Index sensor) const {
  return impl_->windows.at(static_cast<std::size_t>(sensor)).record;
}
const SensorRecord& EstimatorCorrection::displacement_record() const { return impl_->displacement_record; }
const OutputDeviations& EstimatorCorrection::deviations() const { return impl_->outputs.deviations(); }
Eigen::MatrixXd EstimatorCorrection::covariance() const { return impl_->filter.covariance(); }
Eigen::MatrixXd EstimatorCorrection::sensitivities_K() const { return impl_->sensitivities.in_kelvin(); }
void EstimatorCorrection::save(EstimatorState& state) const { impl_->save(state); }
bool EstimatorCorrection::restore(const EstimatorState& state) { return impl_->restore(state); }
long EstimatorCorrection::updates() const { return impl_->updates; }
long EstimatorCorrection::failures() const { return impl_->failures; }

}  // namespace spindle_twin::correction
