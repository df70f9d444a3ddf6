#include "fem_offline/reduce/drive_case.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::fem_offline {
namespace {

constexpr double drive_rest_share = 0.25;
constexpr double coolant_step_share = 1.0 / 3.0;
constexpr double longest_case_s = 7200.0;
constexpr double drift_high_K_per_s = drive_drift_K / longest_case_s;
constexpr double segment_grid_s = 32.0;  ///< segments are multiples of it, so that few step lengths serve them

/// Logarithms of the conductances' factors, which run at constant rates and turn round at the walls of the box.
class DriftingFactors {
 public:
  DriftingFactors(const rom::Boundaries& boundaries, const ParameterBox& box, const Eigen::VectorXd& start,
                  RandomStream random)
      : random_(random), logarithms_(start.array().log()), rates_per_s_(start.size()) {
    for (const rom::Conductance& item : boundaries.conductances) {
      const rom::Range range = factor_range(box, item);
      low_.push_back(std::log(range.min));
      high_.push_back(std::log(range.max));
    }
  }

  void new_rates() {
    constexpr double fastest_per_s = std::numbers::ln2 / drift_doubling_s;
    for (double& rate : rates_per_s_) rate = random_.uniform(-fastest_per_s, fastest_per_s);
  }

  void move(double duration_s) {
    for (Eigen::Index j = 0; j < logarithms_.size(); ++j) {
      const double low = low_[static_cast<std::size_t>(j)], high = high_[static_cast<std::size_t>(j)];
      double& at = logarithms_[j];
      at += rates_per_s_[j] * duration_s;
      if (at < low || at > high) {
        at = 2.0 * std::clamp(at, low, high) - at;
        rates_per_s_[j] = -rates_per_s_[j];
      }
    }
  }

  Eigen::VectorXd factors() const { return logarithms_.array().exp(); }

 private:
  RandomStream random_;
  Eigen::VectorXd logarithms_, rates_per_s_;
  std::vector<double> low_, high_;
};

}  // namespace

DriveCase random_case(const rom::Boundaries& boundaries, std::uint64_t seed, std::uint32_t index,
                      const CaseOptions& options) {
  const ParameterBox& box = options.box;
  RandomStream random(seed, StreamPurpose::verification, index);
  DriveCase result;
  result.factors = rom::no_correction(boundaries);
  result.factors.conductance = random_conductance_factors(boundaries, box, false, random);
  result.initial_temperature_K = boundaries.reference_temperature_K + random.uniform(-drive_spread_K, drive_spread_K);

  DriftingFactors drifting(boundaries, box, result.factors.conductance,
                           RandomStream(seed, StreamPurpose::drift, index));

  const Eigen::VectorXd base_K = boundaries.operating.environment_K;
  Eigen::VectorXd start_K = base_K;
  Eigen::VectorXd drift_K_per_s = Eigen::VectorXd::Zero(base_K.size());
  for (Eigen::Index i = 0; i < base_K.size(); ++i) {
    start_K[i] += random.uniform(-drive_spread_K, drive_spread_K);
    const double drift = random.uniform(-drift_high_K_per_s, drift_high_K_per_s);
    if (boundaries.environments[static_cast<std::size_t>(i)].kind == rom::EnvironmentKind::ambient) {
      drift_K_per_s[i] = drift;
    }
  }

  const double end_s = random.uniform(3600.0, longest_case_s);
  const double longest_s = options.drift ? longest_drift_interval_s : longest_interval_s;
  double time_s = 0.0;
  while (time_s < end_s) {
    rom::OperatingState state = boundaries.operating;
    const bool rest = random.uniform(0.0, 1.0) < drive_rest_share;
    state.speed_rpm = random.uniform(0.0, box.speed_high_rpm);
    state.load = random.uniform(0.0, box.load_high);
    if (rest) state.speed_rpm = state.load = 0.0;
    const bool coolant_step = random.uniform(0.0, 1.0) < coolant_step_share;
    for (Eigen::Index i = 0; i < base_K.size(); ++i) {
      const double step_K = random.uniform(-drive_spread_K, drive_spread_K);
      const bool coolant = boundaries.environments[static_cast<std::size_t>(i)].kind == rom::EnvironmentKind::coolant;
      if (coolant && coolant_step) start_K[i] = base_K[i] + step_K;
    }
    state.flow_kg_per_s = random_flow_kg_per_s(boundaries, box, random);
    // Powers of two as far as possible, so that few step lengths (and factors of the FE matrix) serve a segment.
    const double drawn_s = random.uniform(60.0, 900.0);
    const double segment_end_s = time_s + segment_grid_s * std::max(2.0, std::round(drawn_s / segment_grid_s));
    double since_start_s = 0.0;
    drifting.new_rates();
    while (time_s < std::min(segment_end_s, end_s)) {
      const double duration_s = std::min(std::clamp(since_start_s, 1.0, longest_s), segment_end_s - time_s);
      state.environment_K = start_K + (time_s + 0.5 * duration_s) * drift_K_per_s;
      // The middle of the interval, as for the environments.
      drifting.move(0.5 * duration_s);
      result.intervals.push_back(
          {duration_s, state, options.drift ? drifting.factors() : Eigen::VectorXd(), since_start_s});
      drifting.move(0.5 * duration_s);
      since_start_s += duration_s;
      time_s += duration_s;
    }
  }
  return result;
}

}  // namespace spindle_twin::fem_offline
