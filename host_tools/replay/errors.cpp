#include "host_tools/replay/errors.hpp"

#include <algorithm>
#include <cmath>

#include "firmware/cycle/publish.hpp"

namespace spindle_twin::host_tools {
namespace {

void add_reading(double measured, double predicted, double deviation, double uncorrected, double time_s,
                 OutputErrors& errors) {
  if (!std::isfinite(measured) || !std::isfinite(predicted)) return;
  const bool first = errors.twin.count == 0;
  errors.lowest = first ? measured : std::min(errors.lowest, measured);
  errors.highest = first ? measured : std::max(errors.highest, measured);
  errors.twin.add(predicted - measured, time_s);
  if (std::isfinite(deviation)) {
    ++errors.with_deviation;
    errors.sum_of_variances += deviation * deviation;
    if (std::abs(predicted - measured) <= 2.0 * deviation) ++errors.within_2_deviations;
  }
  if (std::isfinite(uncorrected)) errors.uncorrected.add(uncorrected - measured, time_s);
}

}  // namespace

void ErrorStatistics::add(double error, double time_s) {
  ++count;
  sum_of_squares += error * error;
  last = error;
  if (std::abs(error) <= std::abs(worst)) return;
  worst = error;
  worst_at_s = time_s;
}

double ErrorStatistics::rms() const {
  return count > 0 ? std::sqrt(sum_of_squares / static_cast<double>(count)) : firmware::not_a_value;
}

double OutputErrors::deviation() const {
  return with_deviation > 0 ? std::sqrt(sum_of_variances / static_cast<double>(with_deviation)) : firmware::not_a_value;
}

ReplayErrors::ReplayErrors(const rom::Network& network, const firmware::CyclePlan& plan, const Log& log, double from_s)
    : log_(log),
      limits_(plan.sensors),
      from_s_(from_s),
      slack_s_(1e-6 * plan.period_s),
      before_{firmware::not_a_value, firmware::first_snapshot(network)},
      after_(before_),
      error_K_(network.key_points.size(), firmware::not_a_value) {
  for (std::size_t k = 0; k < network.key_points.size(); ++k) {
    if (!log.has_sensor[k]) continue;
    sensor_slots_.push_back(k);
    sensors_.push_back({network.key_points[k].name, plan.sensors[k].configured});
  }
  for (std::size_t d = 0; d < network.deformations.size(); ++d) {
    if (!log.has_deformation[d]) continue;
    deformation_slots_.push_back(d);
    deformations_.push_back({network.deformations[d].name, plan.probes[d].configured});
  }
}

const std::vector<double>& ReplayErrors::add(const ReplayedCycle& cycle) {
  std::fill(error_K_.begin(), error_K_.end(), firmware::not_a_value);
  while (next_ < log_.rows.size() && log_.rows[next_].time_s <= cycle.time_s + slack_s_) judge(log_.rows[next_++]);
  before_ = after_;
  after_ = {cycle.end_s, cycle.snapshot};
  return error_K_;
}

void ReplayErrors::judge(const LogRow& row) {
  const double span_s = after_.time_s - before_.time_s;
  const auto predicted = [&](double before, double after) {
    if (row.time_s >= after_.time_s - slack_s_) return after;
    return before + (after - before) * (row.time_s - before_.time_s) / span_s;
  };
  const bool counts = row.time_s >= from_s_;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const std::size_t k = sensor_slots_[i];
    const double twin_K = predicted(before_.snapshot.predicted_K[k], after_.snapshot.predicted_K[k]);
    const double uncorrected_K = predicted(before_.snapshot.uncorrected_K[k], after_.snapshot.uncorrected_K[k]);
    if (row.measured_K[k] < limits_[k].min_K || row.measured_K[k] > limits_[k].max_K) continue;
    error_K_[k] = twin_K - row.measured_K[k];
    const double deviation_K = after_.snapshot.predicted_deviation_K[k];
    if (counts) add_reading(row.measured_K[k], twin_K, deviation_K, uncorrected_K, row.time_s, sensors_[i]);
  }
  const auto open_loop_m = [](const Prediction& prediction, std::size_t d) {
    return d == 0 ? prediction.snapshot.nose_uncorrected_m + prediction.snapshot.tare_m : firmware::not_a_value;
  };
  for (std::size_t i = 0; i < deformations_.size() && counts; ++i) {
    const std::size_t d = deformation_slots_[i];
    const double twin_m = predicted(before_.snapshot.deformation_m[d], after_.snapshot.deformation_m[d]);
    const double uncorrected_m = predicted(open_loop_m(before_, d), open_loop_m(after_, d));
    const double deviation_m = after_.snapshot.deformation_deviation_m[d];
    add_reading(row.deformation_m[d], twin_m, deviation_m, uncorrected_m, row.time_s, deformations_[i]);
  }
}

}  // namespace spindle_twin::host_tools
