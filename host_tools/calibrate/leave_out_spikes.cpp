#include "host_tools/calibrate/leave_out_spikes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace spindle_twin::host_tools {
namespace {

constexpr std::size_t beside = 3;
constexpr std::size_t window = 2 * beside + 1;
constexpr double deviations = 6.0 * 1.4826;  // of the median absolute deviation; the second: of a normal distribution
constexpr double least_K = 0.3;              // what the daemon takes for a spike at least (health/limits.hpp)
constexpr double least_noises = 10.0;

double median_of(std::array<double, window> values) {
  std::nth_element(values.begin(), values.begin() + beside, values.end());
  return values[beside];
}

/// Places in the column, of readings only.
std::vector<Eigen::Index> spikes_in(const Eigen::Ref<const Eigen::VectorXd>& column, double least) {
  std::vector<Eigen::Index> at, found;
  for (Eigen::Index r = 0; r < column.size(); ++r) {
    if (std::isfinite(column[r])) at.push_back(r);
  }
  for (std::size_t i = beside; i + beside < at.size(); ++i) {
    std::array<double, window> values{}, off{};
    for (std::size_t k = 0; k < window; ++k) values[k] = column[at[i - beside + k]];
    const double median = median_of(values);
    for (std::size_t k = 0; k < window; ++k) off[k] = std::abs(values[k] - median);
    if (off[beside] > std::max(least, deviations * median_of(off))) found.push_back(at[i]);
  }
  return found;
}

void leave_out(Eigen::Ref<Eigen::VectorXd> column, const std::vector<double>& time_s, const std::string& name,
               double least, std::vector<Spikes>& spikes) {
  const std::vector<Eigen::Index> found = spikes_in(column, least);
  if (found.empty()) return;
  for (const Eigen::Index row : found) column[row] = std::numeric_limits<double>::quiet_NaN();
  spikes.push_back({name, static_cast<int>(found.size()), time_s[static_cast<std::size_t>(found.front())]});
}

}  // namespace

std::vector<Spikes> leave_out_spikes(const rom::Network& network, double probe_noise_m, correction::ThermalTest& test) {
  std::vector<Spikes> spikes;
  for (Eigen::Index k = 0; k < test.measured_K.cols(); ++k) {
    leave_out(test.measured_K.col(k), test.time_s, network.key_points[static_cast<std::size_t>(k)].name, least_K,
              spikes);
  }
  for (Eigen::Index d = 0; d < test.deformation_m.cols(); ++d) {
    leave_out(test.deformation_m.col(d), test.time_s, network.deformations[static_cast<std::size_t>(d)].name,
              least_noises * probe_noise_m, spikes);
  }
  return spikes;
}

}  // namespace spindle_twin::host_tools
