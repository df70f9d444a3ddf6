#include "correction/estimator/consistency.hpp"

#include <algorithm>
#include <cmath>

#include "rom/units.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double most_nis = 12.0;  // one reading alone does not keep the mean of a minute above 1 for a minute

double weight(double elapsed_s, double memory_s) { return 1.0 - std::exp(-elapsed_s / memory_s); }

}  // namespace

Consistency::Consistency(const ConsistencyLimits& limits, Eigen::Index sensors)
    : limits_(limits), nis_(Eigen::VectorXd::Zero(sensors)), floor_K2_(nis_), square_K2_(nis_) {
  restart();
}

void Consistency::restart() {
  nis_.setZero();
  square_K2_.setZero();
  floor_K2_.setConstant(limits_.floor_K * limits_.floor_K);
  nis_of_hour_ = rejected_share_ = above_s_ = calm_s_ = 0.0;
  in_doubt_ = false;
}

void Consistency::note(Eigen::Index sensor, double innovation_K, double variance_K2, double explained_K2, bool rejected,
                       double since_s) {
  const double square_K2 = innovation_K * innovation_K;
  square_K2_[sensor] += weight(since_s, limits_.nis_memory_s) * (square_K2 - square_K2_[sensor]);
  const double ratio = std::min(square_K2 / variance_K2, most_nis);
  nis_[sensor] += weight(since_s, limits_.nis_memory_s) * (ratio - nis_[sensor]);
  if (!rejected && !in_doubt_) {
    const double least_K2 = limits_.floor_K * limits_.floor_K;
    const double most_K2 = limits_.floor_largest_K * limits_.floor_largest_K;
    double& floor_K2 = floor_K2_[sensor];
    floor_K2 += weight(since_s, limits_.floor_memory_s) * (square_K2 - explained_K2 - floor_K2);
    floor_K2 = std::clamp(floor_K2, least_K2, std::max(least_K2, most_K2));
  }
  noted_K_ = std::max(noted_K_, std::abs(innovation_K));
  noted_nis_ += ratio;
  ++noted_;
  if (rejected) ++rejected_;
}

bool Consistency::conclude(double elapsed_s) {
  largest_K_ = noted_K_;
  if (noted_ == 0) return false;
  nis_of_hour_ += weight(elapsed_s, rom::seconds_per_hour) * (noted_nis_ / noted_ - nis_of_hour_);
  rejected_share_ +=
      weight(elapsed_s, limits_.rejected_memory_s) * (static_cast<double>(rejected_) / noted_ - rejected_share_);
  noted_K_ = noted_nis_ = 0.0;
  noted_ = rejected_ = 0;
  const bool above = largest_nis() > limits_.nis || rejected_share_ > limits_.rejected_share;
  above_s_ = above ? above_s_ + elapsed_s : 0.0;
  calm_s_ = largest_nis() < limits_.calm_nis && rejected_share_ < limits_.rejected_share ? calm_s_ + elapsed_s : 0.0;
  if (calm_s_ >= limits_.patience_s) in_doubt_ = false;
  if (above_s_ < limits_.patience_s) return false;
  contradict();
  return true;
}

void Consistency::contradict() {
  in_doubt_ = true;
  ++contradictions_;
  nis_.setZero();
  floor_K2_.setConstant(limits_.floor_K * limits_.floor_K);
  rejected_share_ = above_s_ = calm_s_ = 0.0;
}

double Consistency::floor_K(Eigen::Index sensor) const { return std::sqrt(floor_K2_[sensor]); }

}  // namespace spindle_twin::correction
