#include "tests/bench/reality/follow.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>

#include "firmware/cycle/cycle.hpp"
#include "rom/units.hpp"
#include "tests/bench/reality/default_plan.hpp"
#include "tests/bench/reality/machine_side.hpp"

namespace spindle_twin::bench {
namespace {

constexpr double back_window_s = 1800.0;
constexpr double minute_s = 60.0;

/// Sums on their way to a score.
class Judge {
 public:
  Judge(const RealityTruth& truth, const MachineSide& machine, double cycle_s)
      : truth_(truth), machine_(machine), cycle_s_(cycle_s) {
    score_.seed = truth.seed;
    score_.cycle_s = cycle_s;
  }

  void note(const firmware::Snapshot& now, double time_s) {
    note_nose(now, time_s);
    note_sensors(now);
    note_pair(now, time_s);
    if (now.state != firmware::State::running) score_.degraded_s += cycle_s_;
    score_.ends_degraded = now.state != firmware::State::running;
    score_.quality_at_end = now.quality;
    score_.faults |= now.fault;
  }

  RealityScore score() const {
    RealityScore score = score_;
    const auto mean = [](double sum, long count) { return count > 0 ? sum / static_cast<double>(count) : 0.0; };
    score.error_um = std::sqrt(mean(score.error_um, judged_));
    score.deviation_um = std::sqrt(mean(score.deviation_um, judged_));
    score.open_um = std::sqrt(mean(score.open_um, judged_));
    score.inside = mean(score.inside, judged_);
    score.inside_from_1_min = mean(score.inside_from_1_min, from_1_min_);
    score.rejected = mean(score.rejected, readings_);
    score.failed_at_end_s = *std::max_element(failed_s_.begin(), failed_s_.end());
    return score;
  }

 private:
  void note_nose(const firmware::Snapshot& now, double time_s) {
    const double nose_um = rom::um_per_m * now.nose_m;
    const double true_um = rom::um_per_m * truth_.nose_m(time_s);
    const double error_um = nose_um - true_um;
    const double deviation_um = rom::um_per_m * now.deformation_deviation_m[0];
    const bool inside = std::abs(error_um) <= 2.0 * deviation_um;
    if (noted_ > 0) score_.step_um_per_s = std::max(score_.step_um_per_s, std::abs(nose_um - last_um_) / cycle_s_);
    last_um_ = nose_um;
    ++noted_;
    if (time_s >= minute_s) {
      score_.inside_from_1_min += inside ? 1.0 : 0.0;
      ++from_1_min_;
    }
    const double since_s = time_s - truth_.event_s;
    if (truth_.event_s >= 0.0 && since_s >= 0.0 && since_s <= back_window_s && !inside) score_.back_s = since_s;
    if (time_s < first_judged_s) return;
    if (judged_ == 0) score_.at_15_min_um = error_um;
    score_.error_um += error_um * error_um;
    score_.deviation_um += deviation_um * deviation_um;
    const double open_um = rom::um_per_m * now.nose_uncorrected_m - true_um;
    score_.open_um += open_um * open_um;
    score_.worst_um = std::max(score_.worst_um, std::abs(error_um));
    score_.inside += inside ? 1.0 : 0.0;
    ++judged_;
  }

  void note_sensors(const firmware::Snapshot& now) {
    const bool updated = now.updates != updates_;
    updates_ = now.updates;
    for (std::size_t s = 0; s < sensor_count; ++s) {
      const firmware::SensorState state = now.sensor_health[s].state;
      const bool out = state == firmware::SensorState::failed || state == firmware::SensorState::returning;
      failed_s_[s] = out && !machine_.is_faulty(s) ? failed_s_[s] + cycle_s_ : 0.0;
      score_.failed_s = std::max(score_.failed_s, failed_s_[s]);
      const unsigned flags = now.sensor_update[s].flags;
      if (!updated || flags == 0) continue;
      ++readings_;
      score_.rejected += (flags & firmware::bits(firmware::Update::rejected)) != 0 ? 1.0 : 0.0;
    }
  }

  void note_pair(const firmware::Snapshot& now, double time_s) {
    const auto& [one, other] = machine_.pair();
    const auto is_swapped = [&](std::size_t s) { return now.sensor_health[s].fault == firmware::SensorFault::swapped; };
    if (score_.pair_swapped_s >= 0.0 || !is_swapped(one) || !is_swapped(other)) return;
    score_.pair_swapped_s = std::max(0.0, time_s - Unplugging::back_s);
  }

  const RealityTruth& truth_;
  const MachineSide& machine_;
  double cycle_s_;
  RealityScore score_;
  std::array<double, sensor_count> failed_s_{};
  std::uint32_t updates_ = 0;
  double last_um_ = 0.0;
  long noted_ = 0, judged_ = 0, from_1_min_ = 0, readings_ = 0;
};

void print_head(std::ostream& to) {
  to << "time_s,true_um,nose_um,sd_um,open_um,speed_rpm,state,quality,fault,in_doubt";
  for (std::size_t s = 0; s < sensor_count; ++s) {
    to << ",true" << s << "_K,read" << s << "_K,predicted" << s << "_K,sd" << s << "_K,innovation" << s << "_K,test"
       << s << ",flags" << s << ",state" << s << ",fault" << s;
  }
  to << '\n';
}

void print_row(const RealityTruth& truth, const firmware::Snapshot& now, double time_s, std::ostream& to) {
  to << time_s << ',' << rom::um_per_m * truth.nose_m(time_s) << ',' << rom::um_per_m * now.nose_m << ','
     << rom::um_per_m * now.deformation_deviation_m[0] << ',' << rom::um_per_m * now.nose_uncorrected_m << ','
     << now.signals[0] << ',' << static_cast<int>(now.state) << ',' << now.quality << ',' << now.fault << ','
     << now.model_in_doubt;
  for (std::size_t s = 0; s < sensor_count; ++s) {
    to << ',' << truth.place_K(s, time_s) << ',' << now.measured_K[s] << ',' << now.predicted_K[s] << ','
       << now.predicted_deviation_K[s] << ',' << now.sensor_update[s].innovation << ','
       << now.sensor_update[s].test_ratio << ',' << now.sensor_update[s].flags << ','
       << static_cast<int>(now.sensor_health[s].state) << ',' << static_cast<int>(now.sensor_health[s].fault);
  }
  to << '\n';
}

}  // namespace

RealityScore follow_reality(const rom::Network& network, const RealityTruth& truth, const Family& family,
                            double cycle_s, const Unplugging& unplugging, std::ostream* trace) {
  const double period_s = family.cycle_s > 0.0 ? family.cycle_s : cycle_s;
  firmware::Cycle cycle(network, default_plan(family.sensors, period_s),
                        [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  MachineSide machine(truth, family, unplugging);
  Judge judge(truth, machine, period_s);
  if (trace != nullptr) print_head(*trace);
  const long cycles = std::lround(family.run_s / period_s);
  for (long k = 0; k < cycles; ++k) {
    const double time_s = static_cast<double>(k) * period_s;
    machine.tell(time_s);
    const firmware::Snapshot& now = cycle.step(machine.frame(), machine.command(), clock_ns(time_s), 0);
    const double predicted_for_s = time_s + period_s;
    judge.note(now, predicted_for_s);
    if (trace != nullptr) print_row(truth, now, predicted_for_s, *trace);
  }
  RealityScore score = judge.score();
  const auto& [one, other] = machine.pair();
  score.pair_apart_K = std::abs(truth.place_K(one, Unplugging::back_s) - truth.place_K(other, Unplugging::back_s));
  return score;
}

}  // namespace spindle_twin::bench
