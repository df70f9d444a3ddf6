#include "correction/estimator/estimator_core.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "correction/boundaries/evaluate_boundaries.hpp"
#include "correction/estimator/check_options.hpp"
#include "correction/estimator/inputs_changed.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double time_slack_s = 1e-6;
constexpr double seconds_per_hour = 3600.0;

}  // namespace

EstimatorCore::EstimatorCore(const rom::Network& the_network, EstimatorOptions the_options)
    : network(the_network),
      options(checked(the_network, std::move(the_options))),
      shared(std::make_shared<const rom::NetworkOperator>(the_network)),
      parameters(the_network, options.priors),
      sensitivities(the_network, shared, parameters),
      outputs(the_network, sensitivities, parameters, options.curvature > 0.0) {
  const Eigen::Index p = parameters.count();
  const auto m = static_cast<Eigen::Index>(options.sensors.size());
  const auto nodes = shared->nodes();
  prior_mean = Eigen::VectorXd::Zero(p + m);
  prior_mean.head(p) = parameters.mean();
  prior_covariance = Eigen::MatrixXd::Zero(p + m, p + m);
  prior_covariance.topLeftCorner(p, p) = parameters.covariance();
  for (Eigen::Index s = 0; s < m; ++s) {
    const double offset_K = options.sensors[static_cast<std::size_t>(s)].offset_K;
    prior_covariance(p + s, p + s) = offset_K * offset_K;
  }
  filter = SquareRootFilter(prior_mean, prior_covariance);
  prior = filter;
  prior_root = filter.root();
  last_update.theta = last_update.displacement_row = Eigen::VectorXd::Zero(p);
  last_update.rows = Eigen::MatrixXd::Zero(p, m);
  last_update.residual_K = last_update.noise_K2 = Eigen::VectorXd::Zero(m);
  keep = Eigen::VectorXd::Ones(p + m);
  growth = Eigen::VectorXd::Zero(p + m);
  row = Eigen::VectorXd::Zero(p + m);
  theta = theta_before = theta_step = Eigen::VectorXd::Zero(p);
  outputs.set_alternatives(Eigen::MatrixXd::Zero(p, m));
  neutral_mean = Eigen::VectorXd::Zero(p + m);
  factors = no_correction(network.boundaries);
  bias_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.boundaries.environments.size()));
  rises_K = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(network.boundaries.sources.size()));
  values = make_boundary_values(network.boundaries);
  held_state = corrected_state = network.boundaries.operating;
  start_K = corrected_K = nodes_K = Eigen::VectorXd::Zero(nodes);
  for (const EstimatorSensor& sensor : options.sensors) {
    SensorWindow window;
    window.internal = Eigen::VectorXd::Zero(nodes);
    sensitivities.internal_row(sensor.row, window.internal);
    window.sensitivity = window.lagged_sensitivity = window.sensitivity_before = Eigen::VectorXd::Zero(p);
    windows.push_back(std::move(window));
  }
  for (const rom::DeformationOutput& output : network.deformations) {
    displacement_rows.emplace_back(Eigen::VectorXd::Zero(nodes));
    sensitivities.internal_row(output.row_m_per_K, displacement_rows.back());
  }
  displacement_row = bend = Eigen::VectorXd::Zero(p);
  tare_deviation_K = Eigen::VectorXd::Zero(m);
}

void EstimatorCore::forget() {
  outputs.clear_alternatives();
  filter.set_mean(prior_mean);
  filter.set_root(prior_root);
  theta = prior_mean.head(parameters.count());
  for (std::size_t s = 0; s < windows.size(); ++s) {
    windows[s].record = {};
    windows[s].record.offset_deviation_K = options.sensors[s].offset_K;
  }
  note_bend();
  displacement_pending = false;
  tare_deviation_K.setZero();
}

void EstimatorCore::reset(double time_s, const Eigen::VectorXd& nodes, const rom::OperatingState& operating) {
  forget();
  sensitivities.start(parameters);
  for (std::size_t s = 0; s < windows.size(); ++s) {
    windows[s].start(options.sensors[s].row.dot(nodes));
    sensitivities.of_row(windows[s].internal, windows[s].sensitivity);
    windows[s].lagged_sensitivity = windows[s].sensitivity_before = windows[s].sensitivity;
  }
  started = true;
  period_open = false;
  fused_s = time_s;
  due_s = time_s + options.period_s;
  seen_s = time_s;
  fresh_until_s = time_s + fresh_s;
  start_memory_s = start_shape = 0.0;
  nodes_K = nodes;
  publish_factors(operating);
  outputs.evaluate(sensitivities, filter, bend, nodes_K);
}

void EstimatorCore::publish_factors(const rom::OperatingState& operating) {
  sensitivities.source_rises(nodes_K, rises_K);
  parameters.apply(theta, operating.speed_rpm, rises_K, factors, bias_K);
}

void EstimatorCore::open_period(double time_s, const rom::OperatingState& operating) {
  held_state.speed_rpm = operating.speed_rpm;
  held_state.load = operating.load;
  held_state.environment_K = operating.environment_K;
  held_state.flow_kg_per_s = operating.flow_kg_per_s;
  held_state.current_A = operating.current_A;
  held_state.power_W = operating.power_W;
  held_state.heat_W = operating.heat_W;
  corrected_state = held_state;
  corrected_state.environment_K += bias_K;
  evaluate_boundaries(network.boundaries, corrected_state, factors, values);
  shared->laws().at_temperatures(nodes_K, values);
  start_K = nodes_K;
  opened_s = time_s;
  period_open = true;
}

void EstimatorCore::close_period(double time_s) {
  if (!period_open) return;
  period_open = false;
  const double period_s = time_s - opened_s;
  for (SensorWindow& window : windows) sensitivities.of_row(window.internal, window.sensitivity_before);
  if (!sensitivities.advance({period_s, held_state.speed_rpm, start_K, nodes_K, values, theta}, parameters)) {
    ++failures;
  }
  for (std::size_t s = 0; s < windows.size(); ++s) {
    sensitivities.of_row(windows[s].internal, windows[s].sensitivity);
    windows[s].lag_sensitivity(period_s, options.sensors[s].lag_s);
  }
}

void EstimatorCore::passing_of_time(double elapsed_s, Eigen::VectorXd& to_keep, Eigen::VectorXd& to_grow) const {
  const Eigen::Index p = parameters.count();
  to_keep.setOnes();
  for (Eigen::Index i = 0; i < p; ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    const double memory_s = i == parameters.start() ? start_memory_s : parameter.memory_s;
    if (memory_s > 0.0) {
      to_keep[i] = std::exp(-elapsed_s / memory_s);
      to_grow[i] = parameter.deviation * parameter.deviation * (1.0 - to_keep[i] * to_keep[i]);
    } else {
      to_grow[i] = parameter.walk_per_root_s * parameter.walk_per_root_s * elapsed_s;
    }
  }
  const double offset_walk = options.offset_walk_K_per_root_hour * options.offset_walk_K_per_root_hour;
  for (Eigen::Index i = p; i < to_grow.size(); ++i) to_grow[i] = offset_walk * elapsed_s / seconds_per_hour;
}

void EstimatorCore::pass_time(double elapsed_s) {
  passing_of_time(elapsed_s, keep, growth);
  filter.pass_time(prior_mean, keep, growth);
  note_bend();
}

void EstimatorCore::note_bend() {
  const double share = std::sqrt(0.5 * options.curvature);
  for (Eigen::Index i = 0; i < bend.size(); ++i) {
    const ParameterKind kind = parameters.list()[static_cast<std::size_t>(i)].kind;
    const bool is_ln = kind == ParameterKind::heat || kind == ParameterKind::contact || kind == ParameterKind::film;
    bend[i] = is_ln ? share * filter.deviation(i) * filter.deviation(i) : 0.0;
  }
  if (start_memory_s > 0.0) {
    bend[parameters.start()] = start_shape * std::exp(-std::max(0.0, seen_s - widened_s) / start_memory_s);
  }
}

double EstimatorCore::curvature_variance(const Eigen::VectorXd& sensitivity) const {
  return sensitivity.cwiseProduct(bend).squaredNorm();
}

void EstimatorCore::fuse(SensorRecord& record, double innovation, double noise) {
  record.innovation_K = innovation;
  record.variance_K2 = filter.variance_of(row) + noise;
  record.test_ratio = innovation * innovation / (options.gate * options.gate * record.variance_K2);
  record.rejected = !(record.test_ratio <= 1.0);
  record.fused = !record.rejected && filter.update(row, innovation, noise);
  record.rejected_in_a_row = record.rejected ? record.rejected_in_a_row + 1 : 0;
}

void EstimatorCore::fuse_sensor(Eigen::Index s, double time_s) {
  SensorWindow& window = windows[static_cast<std::size_t>(s)];
  const EstimatorSensor& sensor = options.sensors[static_cast<std::size_t>(s)];
  SensorRecord& record = window.record;
  record.rejected = record.fused = false;
  record.observation_K = std::numeric_limits<double>::quiet_NaN();
  last_update.rows.col(s) = window.lagged_sensitivity;
  last_update.residual_K[s] = std::numeric_limits<double>::quiet_NaN();
  if (window.samples == 0) return;
  const Eigen::Index p = parameters.count();
  row.setZero();
  row.head(p) = window.lagged_sensitivity;
  row[p + s] = 1.0;
  theta_step = filter.mean().head(p) - theta_before;
  const double count = window.samples;
  record.observation_K = window.measured_K / count;
  const double innovation =
      window.residual_K / count - window.lagged_sensitivity.dot(theta_step) - filter.mean()[p + s];
  const double interval_s = std::max(time_s - window.fused_s, options.period_s);
  const double one_reading_K2 = sensor.noise_K * sensor.noise_K / count + options.floor_K * options.floor_K +
                                curvature_variance(window.lagged_sensitivity);
  const double noise = one_reading_K2 * std::max(1.0, options.correlation_s / interval_s);
  last_update.residual_K[s] = window.residual_K / count;
  last_update.noise_K2[s] = noise;
  fuse(record, innovation, noise);
  if (record.fused) window.fused_s = time_s;
}

void EstimatorCore::fuse_displacement() {
  const Eigen::Index p = parameters.count();
  const rom::DeformationOutput& output = network.deformations[static_cast<std::size_t>(displacement_index)];
  sensitivities.of_row(displacement_rows[static_cast<std::size_t>(displacement_index)], displacement_row);
  row.setZero();
  row.head(p) = displacement_row;
  theta_step = filter.mean().head(p) - theta_before;
  const double predicted_m = output.row_m_per_K.dot(nodes_K) -
                             output.row_m_per_K.sum() * network.boundaries.reference_temperature_K +
                             displacement_row.dot(theta_step);
  last_update.displacement_row = displacement_row;
  const double variance_m2 = displacement_variance_m2 + curvature_variance(displacement_row);
  last_update.displacement_variance_m2 = variance_m2;
  last_update.displacement_m = displacement_m - predicted_m + displacement_row.dot(theta_step);
  displacement_record.observation_K = displacement_m;
  fuse(displacement_record, displacement_m - predicted_m, variance_m2);
  displacement_pending = false;
}

bool EstimatorCore::update(double time_s) {
  const Eigen::Index p = parameters.count();
  last_update.elapsed_s = time_s - fused_s;
  pass_time(last_update.elapsed_s);
  fused_s = time_s;
  theta_before = filter.mean().head(p);
  last_update.theta = theta_before;
  last_update.displacement_m = std::numeric_limits<double>::quiet_NaN();
  for (Eigen::Index s = 0; s < static_cast<Eigen::Index>(windows.size()); ++s) fuse_sensor(s, time_s);
  fuse_tares();
  if (displacement_pending) fuse_displacement();
  const bool moved = follow_filter();
  for (SensorWindow& window : windows) window.clear();
  ++updates;
  return moved;
}

bool EstimatorCore::follow_filter() {
  const Eigen::Index p = parameters.count();
  theta = filter.mean().head(p);
  for (Eigen::Index i = 0; i < p; ++i) {
    const Parameter& parameter = parameters.list()[static_cast<std::size_t>(i)];
    theta[i] = std::clamp(theta[i], parameter.minimum, parameter.maximum);
  }
  filter.set_first(theta);
  theta_step = theta - theta_before;
  corrected_K = nodes_K;
  const bool moved = theta_step.squaredNorm() > 0.0;
  if (moved) sensitivities.correct(theta_step, corrected_K);
  nodes_K = corrected_K;
  for (std::size_t s = 0; s < windows.size(); ++s) {
    windows[s].lagged_K += windows[s].lagged_sensitivity.dot(theta_step);
    windows[s].temperature_K += windows[s].sensitivity.dot(theta_step);
    const Eigen::Index b = p + static_cast<Eigen::Index>(s);
    windows[s].record.offset_K = filter.mean()[b];
    windows[s].record.offset_deviation_K = filter.deviation(b);
  }
  note_bend();
  outputs.evaluate(sensitivities, filter, bend, nodes_K);
  return moved;
}

void EstimatorCore::adopt(const SquareRootFilter& other, const rom::OperatingState& operating) {
  theta_before = theta;
  filter.set_mean(other.mean());
  filter.set_root(other.root());
  outputs.clear_alternatives();
  follow_filter();
  publish_factors(operating);
  // What is held so far belongs to the old parameters; the period that begins here, to the new ones.
  period_open = false;
  open_period(seen_s, operating);
}

EstimatorStep EstimatorCore::step(const EstimatorSample& sample) {
  if (!started) reset(sample.time_s, sample.nodes_K, sample.operating);
  if (standing_by) {
    standing_by = false;
    fused_s = sample.time_s;
    due_s = sample.time_s + options.period_s;
    for (SensorWindow& window : windows) window.clear();
  }
  nodes_K = sample.nodes_K;
  const double elapsed_s = sample.time_s - seen_s;
  seen_s = sample.time_s;
  for (std::size_t s = 0; s < windows.size(); ++s) {
    const auto index = static_cast<Eigen::Index>(s);
    windows[s].predict(options.sensors[s].row.dot(nodes_K), elapsed_s, options.sensors[s].lag_s);
    if (sample.valid[index]) windows[s].observe(sample.measured_K[index]);
  }
  const bool due = sample.time_s >= due_s - time_slack_s;
  const bool fresh = sample.time_s < fresh_until_s;
  if (due || fresh || inputs_changed(sample.operating, held_state)) close_period(sample.time_s);
  EstimatorStep result;
  if (due) {
    result.corrected = result.state_corrected = update(sample.time_s);
    due_s += options.period_s;
    if (due_s <= sample.time_s) due_s = sample.time_s + options.period_s;
  } else if (fresh) {
    outputs.evaluate(sensitivities, filter, bend, nodes_K);
  }
  publish_factors(sample.operating);
  if (!period_open) open_period(sample.time_s, sample.operating);
  return result;
}

void EstimatorCore::stand_by(double time_s, const Eigen::VectorXd& nodes, const rom::OperatingState& operating) {
  if (!started) reset(time_s, nodes, operating);
  if (!standing_by) {
    forget();
    filter.set_mean(neutral_mean);
    theta.setZero();
    standing_by = true;
  }
  nodes_K = nodes;
  const double elapsed_s = time_s - seen_s;
  seen_s = time_s;
  for (std::size_t s = 0; s < windows.size(); ++s) {
    windows[s].predict(options.sensors[s].row.dot(nodes_K), elapsed_s, options.sensors[s].lag_s);
  }
  factors.heat.setOnes();
  factors.conductance.setOnes();
  bias_K.setZero();
  if (time_s >= opened_s + options.period_s - time_slack_s || time_s < fresh_until_s ||
      inputs_changed(operating, held_state)) {
    close_period(time_s);
    outputs.evaluate(sensitivities, filter, bend, nodes_K);
  }
  if (!period_open) open_period(time_s, operating);
}

void EstimatorCore::widen_offset(Eigen::Index sensor, double deviation_K) {
  keep.setOnes();
  growth.setZero();
  growth[parameters.count() + sensor] = deviation_K * deviation_K;
  filter.pass_time(prior_mean, keep, growth);
}

void EstimatorCore::note_tare(Eigen::Index sensor, double shift_K, double deviation_K) {
  const Eigen::Index b = parameters.count() + sensor;
  row = filter.mean();
  row[b] -= shift_K;
  filter.set_mean(row);
  SensorWindow& window = windows[static_cast<std::size_t>(sensor)];
  window.clear();
  window.record.offset_K = row[b];
  tare_deviation_K[sensor] = deviation_K;
}

void EstimatorCore::fuse_tares() {
  for (Eigen::Index s = 0; s < tare_deviation_K.size(); ++s) {
    if (!(tare_deviation_K[s] > 0.0)) continue;
    const Eigen::Index b = parameters.count() + s;
    row.setZero();
    row[b] = 1.0;
    filter.update(row, -filter.mean()[b], tare_deviation_K[s] * tare_deviation_K[s]);
    tare_deviation_K[s] = 0.0;
  }
}

void EstimatorCore::note_displacement(int index, double value_m, double deviation_m) {
  if (index < 0 || index >= static_cast<int>(displacement_rows.size())) return;
  if (!std::isfinite(value_m) || !(deviation_m > 0.0)) return;
  displacement_index = index;
  displacement_m = value_m;
  displacement_variance_m2 = deviation_m * deviation_m;
  displacement_pending = true;
}

}  // namespace spindle_twin::correction
