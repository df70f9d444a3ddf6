#include "correction/estimator/reading_record.hpp"

#include <cmath>
#include <limits>

#include "correction/estimator/inputs_changed.hpp"

namespace spindle_twin::correction {
namespace {

constexpr double longest_s = 2.0;
constexpr double slack_s = 1e-6;

/// An operating state with as many numbers as a machine may tell, so that none of them has to make room later.
rom::OperatingState with_all_told(const rom::Boundaries& boundaries) {
  rom::OperatingState state = boundaries.operating;
  Eigen::Index measured = 0;
  for (const rom::HeatSource& source : boundaries.sources) measured += source.measured ? 1 : 0;
  state.heat_W = Eigen::VectorXd::Zero(measured);
  return state;
}

}  // namespace

ReadingRecord::ReadingRecord(const rom::Boundaries& boundaries, Eigen::Index sensors, std::size_t capacity)
    : sums_K_(Eigen::VectorXd::Zero(sensors)), samples_(sums_K_) {
  open_.operating = with_all_told(boundaries);
  open_.reading_K = sums_K_;
  entries_.assign(capacity, open_);
}

void ReadingRecord::begin(double time_s, const rom::OperatingState& operating) {
  count_ = 0;
  begin_s_ = open_.begin_s = time_s;
  open_.operating = operating;
  open_.length = {};
  sums_K_.setZero();
  samples_.setZero();
}

bool ReadingRecord::note(double time_s, const Eigen::VectorXd& reading_K,
                         const Eigen::Array<bool, Eigen::Dynamic, 1>& valid, const rom::OperatingState& operating,
                         bool end) {
  for (Eigen::Index s = 0; s < sums_K_.size(); ++s) {
    if (!valid[s] || !std::isfinite(reading_K[s])) continue;
    sums_K_[s] += reading_K[s];
    samples_[s] += 1.0;
  }
  if (!end && time_s - open_.begin_s < longest_s - slack_s && !inputs_changed(operating, open_.operating)) return true;
  if (count_ == entries_.size()) return false;
  for (Eigen::Index s = 0; s < sums_K_.size(); ++s) {
    open_.reading_K[s] = samples_[s] > 0.0 ? sums_K_[s] / samples_[s] : std::numeric_limits<double>::quiet_NaN();
  }
  open_.end_s = time_s;
  entries_[count_] = open_;
  ++count_;
  open_.begin_s = time_s;
  open_.operating = operating;
  open_.length = {};
  sums_K_.setZero();
  samples_.setZero();
  return true;
}

}  // namespace spindle_twin::correction
