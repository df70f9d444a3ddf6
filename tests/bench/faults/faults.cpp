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
    case FaultKind::replugged:
      return "replugged";
  }
  return "";
}

void Saboteur::unplug(double time_s, Eigen::VectorXd& readings_K) const {
  for (const int which : {fault_.sensor, fault_.partner}) {
    if (!fault_.is_unplugged(which, time_s)) continue;
    readings_K[which] = fault_.unplugged.reads_open ? open_K : std::numeric_limits<double>::quiet_NaN();
  }
}

void Saboteur::tamper(double time_s, Eigen::VectorXd& readings_K) {
  if (!holding_) held_K_ = readings_K[fault_.sensor];
  holding_ = fault_.at(time_s);
  if (holding_) tamper_now(time_s, readings_K);
  unplug(time_s, readings_K);
}

void Saboteur::tamper_now(double time_s, Eigen::VectorXd& readings_K) {
  double& reading_K = readings_K[fault_.sensor];
  switch (fault_.kind) {
    case FaultKind::none:
    case FaultKind::withdrawn:
    case FaultKind::withdrawn_pair:
    case FaultKind::replugged:
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
