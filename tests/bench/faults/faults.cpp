#include "tests/bench/faults/faults.hpp"

#include <limits>
#include <utility>

namespace spindle_twin::bench {
namespace {

constexpr double open_K = 1123.15;         // end of the scale of a PT100 input
constexpr double shorted_K = 31.15;        // no resistance
constexpr double out_of_range_K = 438.15;  // 15 K above the range
constexpr double spike_share = 1.0 / 30.0;

}  // namespace

const char* name_of(FaultKind kind) {
  switch (kind) {
    case FaultKind::none:
      return "none";
    case FaultKind::withdrawn:
      return "withdrawn";
    case FaultKind::withdrawn_pair:
      return "both withdrawn";
    case FaultKind::open:
      return "open";
    case FaultKind::shorted:
      return "short";
    case FaultKind::out_of_range:
      return "out of range";
    case FaultKind::jump:
      return "jump";
    case FaultKind::spikes:
      return "spikes";
    case FaultKind::stuck:
      return "stuck";
    case FaultKind::swapped:
      return "swapped";
    case FaultKind::drift:
      return "drift";
  }
  return "";
}

void Saboteur::tamper(double time_s, Eigen::VectorXd& readings_K) {
  double& reading_K = readings_K[fault_.sensor];
  if (time_s >= fault_.from_s - fault_.unplugged_s && time_s < fault_.from_s) {
    reading_K = readings_K[fault_.partner] = std::numeric_limits<double>::quiet_NaN();
  }
  if (!holding_) held_K_ = reading_K;
  holding_ = fault_.at(time_s);
  if (!holding_) return;
  switch (fault_.kind) {
    case FaultKind::none:
    case FaultKind::withdrawn:
    case FaultKind::withdrawn_pair:
      break;
    case FaultKind::open:
      reading_K = open_K;
      break;
    case FaultKind::shorted:
      reading_K = shorted_K;
      break;
    case FaultKind::out_of_range:
      reading_K = out_of_range_K;
      break;
    case FaultKind::jump:
      reading_K += fault_.size_K;
      break;
    case FaultKind::spikes:
      if (std::bernoulli_distribution(spike_share)(random_)) reading_K += fault_.size_K;
      break;
    case FaultKind::stuck:
      reading_K = held_K_;
      break;
    case FaultKind::swapped:
      std::swap(reading_K, readings_K[fault_.partner]);
      break;
    case FaultKind::drift:
      reading_K += fault_.rate_K_per_s * (time_s - fault_.from_s);
      break;
  }
}

}  // namespace spindle_twin::bench
