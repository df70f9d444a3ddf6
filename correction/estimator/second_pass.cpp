#include "correction/estimator/second_pass.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "rom/boundary_values/evaluate_boundaries.hpp"

namespace spindle_twin::correction {
namespace {

/// Ages of the record at which it is gone through. Not in the first minutes: friction of a grease that settles after
/// each start is followed by updates, and for constant by a pass over ten minutes, which they still fit.
constexpr std::array<double, 3> ages_s{1800.0, 3600.0, 7200.0};
constexpr std::size_t capacity = 4800;  // stretches: two hours, the last passes, and changes of the inputs
constexpr int most_passes = 3;
// Step of an ln factor below which e^θ is as good as straight: half its square is what a line leaves out.
constexpr double settled_ln = 0.1;
constexpr double longest_ln = 1.0;        // step of an ln factor from one pass to the next
constexpr double most_at_once_s = 200.0;  // of the record in one cycle: a cycle after a pause is no longer than others
constexpr double age_slack_s = 1e-6;
// Beside what readings leave open, the model's own error may be larger than the daemon's.
constexpr double tolerance_K = 1e-5;

EstimatorOptions of_a_pass(EstimatorOptions options) {
  options.second_pass = 0.0;
  options.curvature = 0.0;  // it is linearised where it ends
  return options;
}

rom::CvodeSettings settings_of_a_pass() {
  rom::CvodeSettings settings;
  settings.tolerance_K = tolerance_K;
  return settings;
}

/// The pass has settled when the step of these is small: in them the readings are not linear.
bool must_settle(ParameterKind kind) { return bends_the_state(kind) || kind == ParameterKind::speed_exponent; }

}  // namespace

SecondPass::SecondPass(const rom::Network& network, EstimatorOptions options,
                       std::shared_ptr<const rom::NetworkOperator> coordinates, const EstimatorCorrection& like)
    : network_(&network),
      times_as_fast_(options.second_pass),
      pass_(network, of_a_pass(std::move(options)), coordinates),
      stepper_(std::move(coordinates), settings_of_a_pass()),
      values_(rom::make_boundary_values(network.boundaries)),
      corrected_(network.boundaries.operating),
      record_(network.boundaries, static_cast<Eigen::Index>(pass_.sensors().size()), capacity),
      unknowns_(like.filter().mean()),
      valid_(
          Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(static_cast<Eigen::Index>(pass_.sensors().size()), false)) {
  like.note_instant(start_);
  pass_.sensitivities_ = like.sensitivities_;  // which share what does not change
  pass_.outputs_ = {};  // nobody reads them, and their candidate points are the largest part of an estimator
  // CVODE takes its memory with the first step.
  rom::evaluate_boundaries(network.boundaries, corrected_, pass_.factors(), values_);
  stepper_.advance(1.0, values_);
}

void SecondPass::begin_anew() {
  is_recording_ = is_passing_ = false;
  next_age_ = 0;
}

void SecondPass::end_passes() {
  is_passing_ = false;
  ++next_age_;
}

bool SecondPass::follow(const EstimatorCorrection& estimator, const EstimatorSample& sample, bool updated) {
  if (next_age_ == ages_s.size()) return false;
  const double elapsed_s = sample.time_s - seen_s_;
  seen_s_ = sample.time_s;
  if (!is_recording_) {
    if (estimator.start_unseen_) return false;
    estimator.note_instant(start_);
    record_.begin(sample.time_s, sample.operating);
    is_recording_ = true;
    return false;
  }
  if (!record_.note(sample.time_s, sample.measured_K, sample.valid, sample.operating, updated)) {
    next_age_ = ages_s.size();
    return false;
  }
  if (!is_passing_) {
    if (!updated || sample.time_s - record_.begin_s() < ages_s[next_age_] - age_slack_s) return false;
    passes_ = 0;
    unknowns_ = estimator.filter().mean();
    begin_pass();
    return false;
  }
  go_on(elapsed_s, sample.operating);
  if (failed_) {
    end_passes();
    return false;
  }
  return updated && next_entry_ == record_.count() && conclude();
}

void SecondPass::begin_pass() {
  pass_.hold(start_, unknowns_, record_.at(0).operating);
  stepper_.set_temperatures(pass_.corrected_nodes_K());
  is_passing_ = true;
  failed_ = false;
  next_entry_ = 0;
  due_s_ = 0.0;
  ++passes_;
}

void SecondPass::go_on(double elapsed_s, const rom::OperatingState& now) {
  due_s_ += std::min(times_as_fast_ * elapsed_s, most_at_once_s);
  while (due_s_ > 0.0 && next_entry_ < record_.count() && !failed_) {
    const RecordedReadings& stretch = record_.at(next_entry_);
    due_s_ -= stretch.end_s - stretch.begin_s;
    const bool is_last = next_entry_ + 1 == record_.count();
    go_through(next_entry_, is_last ? now : record_.at(next_entry_ + 1).operating);
    ++next_entry_;
  }
}

void SecondPass::go_through(std::size_t entry, const rom::OperatingState& after) {
  const RecordedReadings& stretch = record_.at(entry);
  corrected_ = stretch.operating;
  corrected_.environment_K += pass_.environment_bias_K();
  rom::evaluate_boundaries(network_->boundaries, corrected_, pass_.factors(), values_);
  const double length_s = stretch.end_s - stretch.begin_s;
  if (length_s > 0.0 && stepper_.advance(length_s, values_) != rom::StepStatus::ok) {
    failed_ = true;
    return;
  }
  const RecordedLength& length = stretch.length;
  if (length.index >= 0) pass_.note_displacement(length.index, length.value_m, length.deviation_m);
  for (Eigen::Index s = 0; s < valid_.size(); ++s) valid_[s] = std::isfinite(stretch.reading_K[s]);
  pass_.step({stretch.end_s, stretch.reading_K, valid_, stepper_.temperatures_K(), after}, length_s);
  failed_ = pass_.held_in_vain_;
}

/// Whether what it missed of its last minute of readings is no more than their noise and the least that the network is
/// wrong by, in the mean of the sensors: constant parameters fit the first readings of the record and the last.
bool SecondPass::fits() const {
  double missed_K2 = 0.0, allowed_K2 = 0.0;
  const double floor_K = pass_.consistency_.least_floor_K();
  for (Eigen::Index s = 0; s < valid_.size(); ++s) {
    const double noise_K = pass_.sensors()[static_cast<std::size_t>(s)].noise_K;
    missed_K2 += pass_.consistency_.square_K2(s);
    allowed_K2 += noise_K * noise_K + floor_K * floor_K;
  }
  return missed_K2 <= allowed_K2;
}

bool SecondPass::conclude() {
  unknowns_ = pass_.filter_.mean();
  pass_.bound(unknowns_);
  double moved = 0.0;
  for (Eigen::Index i = 0; i < pass_.parameters().count(); ++i) {
    if (!must_settle(pass_.parameters().list()[static_cast<std::size_t>(i)].kind)) continue;
    const double step = unknowns_[i] - pass_.held_at_[i];
    moved = std::max(moved, std::abs(step));
    unknowns_[i] = pass_.held_at_[i] + std::clamp(step, -longest_ln, longest_ln);
  }
  if (moved <= settled_ln) {
    end_passes();
    if (!fits()) return false;
    pass_.release();
    return true;
  }
  if (passes_ == most_passes) {
    end_passes();
    return false;
  }
  begin_pass();
  return false;
}

}  // namespace spindle_twin::correction
