#include <algorithm>
#include <cmath>
#include <limits>

#include "correction/estimator/estimator_correction.hpp"
#include "correction/estimator/second_pass.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double no_value = std::numeric_limits<double>::quiet_NaN();
/// Largest step of an ln factor by one reading: as far as a straight line stands for e^θ.
constexpr double straight = 0.3;
constexpr double by_chance = 3.0;  ///< deviations of what it leaves out that the rest of a reading may hide
constexpr double longest_lag_s = 120.0;
constexpr double lag_missed = 0.3;  // of what an open lag does, the share that a straight line in it leaves out

// A length tells of the nose what no sensor does. From the first of these squared innovations over their variance on it
// opens unexplained heats to so many deviations of their prior, for a machine whose tool is touched off cuts with it,
// and no sensor sees the heat of that. From the second on, where it is likelier with heats as wide than without, those
// that were open already become wider.
constexpr double disturbance_by_length = 8.0;
constexpr double unbelievable = 3.0;  // deviations of its prior
constexpr double opening_nis = 1.0;
constexpr double widening_nis = 2.0;

}  // namespace

double EstimatorCorrection::curvature_variance(const Eigen::Ref<const Eigen::VectorXd>& sensitivity) const {
  return sensitivity.cwiseProduct(curvature_).squaredNorm();
}

double EstimatorCorrection::lag_curvature_variance(Eigen::Index sensor) const {
  if (!has_lags()) return 0.0;
  const double slope_K_per_s = channels_[static_cast<std::size_t>(sensor)].mean_lag_slope();
  const double missed_K = lag_missed * slope_K_per_s * filter_.deviation(lag_at(sensor));
  return missed_K * missed_K;
}

void EstimatorCorrection::measure(double time_s) {
  const Eigen::Index p = parameters_.count();
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    const SensorChannel& channel = channels_[static_cast<std::size_t>(s)];
    const EstimatorSensor& sensor = options_.sensors[static_cast<std::size_t>(s)];
    auto row = made_.rows.col(s);
    row.setZero();
    row.head(p) = channel.sensitivity();
    row[offset_at(s)] = 1.0;
    if (has_lags()) row[lag_at(s)] = channel.mean_lag_slope();
    made_.innovation_K[s] = no_value;
    if (channel.samples() == 0) continue;
    made_.innovation_K[s] = channel.mean_residual_K() - made_.unknowns[offset_at(s)];
    const double interval_s = std::max(time_s - channel.fused_s, options_.period_s);
    const double floor_K = consistency_.floor_K(s);
    // A straight line leaves out no more than what is left of the readings, but by chance.
    const double seen_K2 = std::max(consistency_.square_K2(s), made_.innovation_K[s] * made_.innovation_K[s]);
    const double left_out_K2 = std::min(curvature_variance(channel.sensitivity()) + lag_curvature_variance(s),
                                        by_chance * by_chance * seen_K2);
    const double one_reading_K2 = sensor.noise_K * sensor.noise_K / channel.samples() + floor_K * floor_K + left_out_K2;
    made_.noise_K2[s] = one_reading_K2 * std::max(1.0, options_.correlation_s / interval_s);
  }
}

void EstimatorCorrection::measure_displacement() {
  made_.displacement_m = no_value;
  if (!displacement_.pending) return;
  const auto index = static_cast<std::size_t>(displacement_.index);
  const Eigen::VectorXd& row = network_->deformations[index].row_m_per_K;
  sensitivities_.of_row(displacement_.rows[index], place_);
  double length_m = row.dot(nodes_K_) - row.sum() * network_->boundaries.reference_temperature_K;
  parameters_.expand(theta_, length_m, place_);
  made_.displacement_row << place_, Eigen::VectorXd::Zero(made_.displacement_row.size() - place_.size());
  made_.displacement_m = displacement_.value_m - length_m;
  made_.displacement_variance_m2 = displacement_.variance_m2 + curvature_variance(place_);
}

bool EstimatorCorrection::is_beyond_belief() const {
  for (Eigen::Index i = 0; i < parameters_.count(); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
    const bool is_factor = parameter.kind == ParameterKind::heat || parameter.kind == ParameterKind::contact ||
                           parameter.kind == ParameterKind::film;
    if (!is_factor) continue;
    const double off = std::abs(theta_[i] - parameter.uncalibrated_mean) / parameter.uncalibrated_deviation;
    if (off > unbelievable || theta_[i] <= parameter.minimum || theta_[i] >= parameter.maximum) return true;
  }
  return false;
}

bool EstimatorCorrection::contradicted(double time_s) {
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    const SensorChannel& channel = channels_[static_cast<std::size_t>(s)];
    if (channel.samples() == 0) continue;
    row_ = made_.rows.col(s);
    const double known_K2 = filter_.variance_of(row_);
    const double variance_K2 = known_K2 + made_.noise_K2[s];
    const double innovation_K = made_.innovation_at(s, filter_.mean());
    const double noise_K = options_.sensors[static_cast<std::size_t>(s)].noise_K;
    const double explained_K2 =
        known_K2 + noise_K * noise_K / channel.samples() + curvature_variance(channel.sensitivity());
    const bool rejected = !(innovation_K * innovation_K <= options_.gate * options_.gate * variance_K2);
    consistency_.note(s, innovation_K, variance_K2, explained_K2, rejected,
                      std::min(made_.elapsed_s, time_s - channel.fused_s));
  }
  return consistency_.conclude(made_.elapsed_s);
}

void EstimatorCorrection::fuse(SensorRecord& record, const Eigen::Ref<const Eigen::VectorXd>& row, double innovation,
                               double noise) {
  row_ = row;
  const double known = filter_.variance_of(row_, gain_);
  // The larger of the step that one reading may make in an ln factor sets how much it counts.
  double largest = 0.0;
  for (Eigen::Index i = 0; i < curvature_.size(); ++i) {
    if (curvature_[i] > 0.0 && !parameters_.is_start(i)) largest = std::max(largest, std::abs(gain_[i]));
  }
  record.innovation_K = innovation;
  record.variance_K2 = known + noise;
  record.test_ratio = innovation * innovation / (options_.gate * options_.gate * record.variance_K2);
  record.rejected = !(record.test_ratio <= 1.0);
  const double bounded = std::max(noise, std::abs(innovation) * largest / straight - known);
  record.fused = !record.rejected && filter_.update(row_, innovation, bounded);
  record.rejected_in_a_row = record.rejected ? record.rejected_in_a_row + 1 : 0;
}

void EstimatorCorrection::fuse_sensors(double time_s) {
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    SensorChannel& channel = channels_[static_cast<std::size_t>(s)];
    SensorRecord& record = records_[static_cast<std::size_t>(s)];
    record.rejected = record.fused = false;
    record.observation_K = channel.mean_reading_K();
    if (channel.samples() == 0) continue;
    fuse(record, made_.rows.col(s), made_.innovation_at(s, filter_.mean()), made_.noise_K2[s]);
    if (record.fused) channel.fused_s = time_s;
  }
}

void EstimatorCorrection::fuse_displacement() {
  if (!displacement_.pending) return;
  displacement_.pending = false;
  displacement_.record.observation_K = displacement_.value_m;
  fuse(displacement_.record, made_.displacement_row, made_.displacement_at(filter_.mean()),
       made_.displacement_variance_m2);
}

void EstimatorCorrection::fuse_tares() {
  for (Eigen::Index s = 0; s < tare_deviation_K_.size(); ++s) {
    if (!(tare_deviation_K_[s] > 0.0)) continue;
    const Eigen::Index b = offset_at(s);
    row_.setZero();
    row_[b] = 1.0;
    filter_.update(row_, -filter_.mean()[b], tare_deviation_K_[s] * tare_deviation_K_[s]);
    tare_deviation_K_[s] = 0.0;
  }
}

void EstimatorCorrection::open_heats_by_length() {
  if (!displacement_.pending) return;
  row_ = made_.displacement_row;
  const double variance_m2 = filter_.variance_of(row_) + made_.displacement_variance_m2;
  const double innovation_m = made_.displacement_at(filter_.mean());
  const double nis = innovation_m * innovation_m / variance_m2;
  if (!(nis > opening_nis)) return;
  keep_.setOnes();
  growth_.setZero();
  const double opened = open_.disturbance;
  before_length_ = filter_;
  if (nis > widening_nis) {
    widen_disturbances(disturbance_by_length);
  } else {
    widen_disturbances_to(std::max(open_.disturbance, disturbance_by_length));
  }
  filter_.widen(keep_, growth_);
  // What no heat explains is more likely a wrong length than another machine, until the next is off to the same side.
  const double most_m2 = options_.gate * options_.gate * (filter_.variance_of(row_) + made_.displacement_variance_m2);
  const bool explained = innovation_m * innovation_m <= most_m2;
  const SensorRecord& before = displacement_.record;
  const bool again = before.rejected_in_a_row > 0 && before.innovation_K * innovation_m > 0.0;
  if (explained || again) return;
  filter_ = before_length_;
  open_.disturbance = opened;
}

bool EstimatorCorrection::update(double time_s) {
  made_.elapsed_s = time_s - times_.fused_s;
  pass_time(made_.elapsed_s);
  if (knows_calibration_) recall_.take_in(made_.elapsed_s, filter_);
  times_.fused_s = time_s;
  made_.unknowns = linearised_at();
  measure(time_s);
  if (contradicted_) consistency_.contradict();
  const bool found = contradicted(time_s);
  if (is_held_) {
    held_in_vain_ = held_in_vain_ || found;
  } else if (found || contradicted_) {
    contradicted_ = false;
    loosen(consistency_.largest_innovation_K(), !found);
    measure(time_s);
  }
  heed_change();
  measure_displacement();
  open_heats_by_length();
  fuse_sensors(time_s);
  fuse_tares();
  fuse_displacement();
  const bool moved = !is_held_ && follow_filter();
  for (SensorChannel& channel : channels_) channel.clear();
  ++updates_;
  return moved;
}

void EstimatorCorrection::bound(Eigen::VectorXd& unknowns) const {
  for (Eigen::Index i = 0; i < parameters_.count(); ++i) {
    const Parameter& parameter = parameters_.list()[static_cast<std::size_t>(i)];
    unknowns[i] = std::clamp(unknowns[i], parameter.minimum, parameter.maximum);
  }
  for (Eigen::Index s = 0; has_lags() && s < static_cast<Eigen::Index>(channels_.size()); ++s) {
    unknowns[lag_at(s)] = std::clamp(unknowns[lag_at(s)], 0.0, longest_lag_s);
  }
}

bool EstimatorCorrection::follow_filter() {
  const Eigen::Index p = parameters_.count();
  row_ = filter_.mean();
  bound(row_);
  filter_.set_mean(row_);
  theta_ = row_.head(p);
  theta_step_ = theta_ - made_.unknowns.head(p);
  corrected_K_ = nodes_K_;
  const bool moved = theta_step_.squaredNorm() > 0.0;
  if (moved) sensitivities_.correct(theta_step_, corrected_K_);
  nodes_K_ = corrected_K_;
  for (std::size_t s = 0; s < channels_.size(); ++s) {
    const auto index = static_cast<Eigen::Index>(s);
    sensitivities_.of_row(channels_[s].internal(), place_);
    const double lag_step_s = has_lags() ? row_[lag_at(index)] - made_.unknowns[lag_at(index)] : 0.0;
    channels_[s].correct(place_, theta_step_, lag_step_s);
    records_[s].offset_K = row_[offset_at(index)];
    records_[s].offset_deviation_K = filter_.deviation(offset_at(index));
  }
  note_curvature();
  publish_deviations();
  return moved;
}

void EstimatorCorrection::widen_offset(Eigen::Index sensor, double deviation_K) {
  keep_.setOnes();
  growth_.setZero();
  growth_[offset_at(sensor)] = deviation_K * deviation_K;
  filter_.pass_time(prior_mean_, keep_, growth_);
  begin_another_record();
}

void EstimatorCorrection::note_tare(Eigen::Index sensor, double shift_K, double deviation_K) {
  filter_.shift(offset_at(sensor), -shift_K);
  channels_[static_cast<std::size_t>(sensor)].clear();
  records_[static_cast<std::size_t>(sensor)].offset_K = filter_.mean()[offset_at(sensor)];
  tare_deviation_K_[sensor] = deviation_K;
  begin_another_record();
}

void EstimatorCorrection::note_displacement(int index, double value_m, double deviation_m) {
  if (index < 0 || index >= static_cast<int>(displacement_.rows.size())) return;
  if (!std::isfinite(value_m) || !(deviation_m > 0.0)) return;
  displacement_.index = index;
  displacement_.value_m = value_m;
  displacement_.variance_m2 = deviation_m * deviation_m;
  displacement_.pending = true;
  displacement_.record.fused = displacement_.record.rejected = false;
  if (second_pass_) second_pass_->note_displacement(index, value_m, deviation_m);
}

}  // namespace spindle_twin::correction
