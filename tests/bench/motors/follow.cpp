#include "tests/bench/motors/follow.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <memory>

#include "firmware/cycle/cycle.hpp"
#include "rom/integrate/fallback_stepper.hpp"
#include "tests/bench/motors/two_nodes.hpp"
#include "tests/firmware/support/daemon_plan.hpp"

namespace spindle_twin::bench {
namespace {

using firmware::bits;
using firmware::Snapshot;

constexpr double noise_K = 0.05;
constexpr double offset_K = 0.2;
constexpr double settled_s = 120.0;
constexpr double rejection_window_s = 600.0;
constexpr double ns_per_s = 1e9;

firmware::CyclePlan plan_of(const rom::Network& network, const MotorRun& run, const std::array<bool, 2>& fed,
                            const FollowOptions& options) {
  firmware::DaemonLines lines;
  lines.period_s = run.period_s;
  for (std::size_t k = 0; k < fed.size(); ++k) {
    if (fed[k]) lines.sensors.emplace_back(place_names[k]);
  }
  lines.noise_K = noise_K;
  lines.offset_K = offset_K;
  lines.max_degC = 250.0;
  lines.correction = options.correction;
  lines.health = options.health;
  return firmware::daemon_plan(network, lines);
}

firmware::DeviceFrame frame_of(const MotorRun& run, Eigen::Index i, std::int64_t now_ns) {
  firmware::DeviceFrame frame;
  frame.connected = true;
  for (std::size_t k = 0; k < place_names.size(); ++k) {
    frame.sensors[k] = {run.readings_K(static_cast<Eigen::Index>(k), i), now_ns};
  }
  const MotorInputs& inputs = run.inputs[static_cast<std::size_t>(i)];
  const auto set = [&](firmware::Signal which, double value) {
    frame.signals[static_cast<std::size_t>(which)] = {value, now_ns};
  };
  set(firmware::Signal::speed, rated_speed_rpm * inputs.speed_share);
  set(firmware::Signal::load, inputs.load);
  for (const firmware::Signal air : {firmware::Signal::ambient, firmware::Signal::coolant}) set(air, inputs.ambient_K);
  return frame;
}

/// Updates of the last ten minutes: how many readings there were, and how many were rejected.
class Rejections {
 public:
  /// True where the window is full and most of it was rejected.
  bool note(const Snapshot& snapshot, const std::array<bool, 2>& fed) {
    if (snapshot.updates == updates_) return most_;
    updates_ = snapshot.updates;
    for (std::size_t k = 0; k < fed.size(); ++k) {
      const std::uint16_t flags = snapshot.sensor_update[k].flags;
      if (!fed[k] || flags == 0) continue;
      const bool rejected = (flags & bits(firmware::Update::rejected)) != 0;
      window_.push_back({snapshot.model_time_s, rejected});
      ++readings_;
      all_rejected_ += rejected ? 1 : 0;
    }
    while (!window_.empty() && window_.front().time_s < snapshot.model_time_s - rejection_window_s) window_.pop_front();
    const auto rejected = std::count_if(window_.begin(), window_.end(), [](const Entry& e) { return e.rejected; });
    constexpr std::size_t fewest = 30;
    most_ = window_.size() >= fewest && 2 * static_cast<std::size_t>(rejected) > window_.size();
    return most_;
  }
  double share() const { return readings_ == 0 ? 0.0 : static_cast<double>(all_rejected_) / readings_; }

 private:
  struct Entry {
    double time_s;
    bool rejected;
  };
  std::deque<Entry> window_;
  std::uint32_t updates_ = 0;
  int readings_ = 0, all_rejected_ = 0;
  bool most_ = false;
};

class Trace {
 public:
  Trace(const std::string& path, const char* label) : label_(label) {
    if (path.empty()) return;
    file_.reset(std::fopen(path.c_str(), "a"));
    if (!file_) std::fprintf(stderr, "cannot write %s\n", path.c_str());
  }
  static void head(std::FILE* file) {
    std::fprintf(file, "run,fed,time_s,speed_share,load,ambient_degC");
    for (const char* name : place_names) {
      for (const char* what : {"true_degC", "predicted_degC", "sd_K", "reading_degC", "uncorrected_degC",
                               "sensor_state", "sensor_fault", "innovation_K", "test_ratio"}) {
        std::fprintf(file, ",%s_%s", name, what);
      }
    }
    std::fprintf(file, ",state,quality,fault,updates\n");
  }
  void write(const MotorRun& run, Eigen::Index i, const Snapshot& snapshot) {
    if (!file_) return;
    if (std::ftell(file_.get()) == 0) head(file_.get());
    const double zero_K = firmware::zero_degC_K;
    const MotorInputs& inputs = run.inputs[static_cast<std::size_t>(i)];
    std::fprintf(file_.get(), "%llu,%s,%.1f,%.3f,%.3f,%.2f", static_cast<unsigned long long>(run.seed), label_,
                 snapshot.model_time_s, inputs.speed_share, inputs.load, inputs.ambient_K - zero_K);
    for (std::size_t k = 0; k < place_names.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      std::fprintf(file_.get(), ",%.4f,%.4f,%.4f,%.4f,%.4f,%u,%u,%.4f,%.4f", run.truth_K(row, i + 1) - zero_K,
                   snapshot.predicted_K[k] - zero_K, snapshot.predicted_deviation_K[k], run.readings_K(row, i) - zero_K,
                   snapshot.uncorrected_K[k] - zero_K, static_cast<unsigned>(snapshot.sensor_health[k].state),
                   static_cast<unsigned>(snapshot.sensor_health[k].fault), snapshot.sensor_update[k].innovation,
                   snapshot.sensor_update[k].test_ratio);
    }
    std::fprintf(file_.get(), ",%u,%u,%u,%u\n", static_cast<unsigned>(snapshot.state), snapshot.quality, snapshot.fault,
                 snapshot.updates);
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  const char* label_;
};

/// Sums of one place, from judged_from_s on.
struct PlaceSums {
  double squares_K2 = 0.0, variances_K2 = 0.0, uncorrected_K2 = 0.0;
  int within = 0, inside = 0;

  void add(double time_s, double error_K, double sd_K, double uncorrected_K, PlaceScore& score) {
    // A number that is none, or that grows without end, is as wrong as can be.
    const double size_K = std::isfinite(error_K) ? std::abs(error_K) : 1e9;
    if (time_s < judged_from_s) {
      if (time_s >= settled_s) score.worst_early_K = std::max(score.worst_early_K, size_K);
      return;
    }
    score.worst_K = std::max(score.worst_K, size_K);
    squares_K2 += size_K * size_K;
    variances_K2 += sd_K * sd_K;
    uncorrected_K2 += uncorrected_K * uncorrected_K;
    within += size_K <= 1.0 ? 1 : 0;
    inside += size_K <= 2.0 * sd_K ? 1 : 0;
  }
  void finish(int count, PlaceScore& score) const {
    score.rms_K = std::sqrt(squares_K2 / count);
    score.deviation_K = std::sqrt(variances_K2 / count);
    score.uncorrected_K = std::sqrt(uncorrected_K2 / count);
    score.within_1_K = static_cast<double>(within) / count;
    score.inside = static_cast<double>(inside) / count;
  }
};

Eigen::Vector2d places_of(const Motor& motor) {
  return {motor.temperatures_K()[MotorBody::winding], motor.temperatures_K()[MotorBody::housing]};
}

/// The run itself, from what the motor is now.
void record(Motor& motor, const std::vector<DutySegment>& duty, Random& random, MotorRun& run) {
  std::normal_distribution<double> normal(0.0, 1.0);
  const Eigen::Vector2d offsets_K(offset_K * normal(random), offset_K * normal(random));
  const auto periods = static_cast<Eigen::Index>(run_s / run.period_s);
  run.truth_K.resize(2, periods + 1);
  run.readings_K.resize(2, periods);
  run.truth_K.col(0) = places_of(motor);
  for (Eigen::Index i = 0; i < periods; ++i) {
    run.inputs.push_back(inputs_at(duty, run.period_s * static_cast<double>(i)));
    for (Eigen::Index k = 0; k < 2; ++k) {
      run.readings_K(k, i) = run.truth_K(k, i) + offsets_K[k] + noise_K * normal(random);
    }
    motor.advance(run.period_s, run.inputs.back());
    run.truth_K.col(i + 1) = places_of(motor);
  }
}

}  // namespace

const char* name_of(Start start) {
  switch (start) {
    case Start::cold:
      return "cold";
    case Start::warm:
      return "warm";
    case Start::warm_stopped:
      return "stopped";
  }
  return "unknown";
}

MotorRun run_motor(Motor motor, Start start, std::uint64_t seed) {
  constexpr std::array<double, 3> periods_s{1.0, 2.0, 5.0};
  Random random(seed);
  MotorRun run;
  run.seed = seed;
  run.start = start;
  run.bodies = motor.bodies();
  run.period_s = periods_s[std::uniform_int_distribution<std::size_t>(0, periods_s.size() - 1)(random)];
  std::vector<DutySegment> duty = draw_duty(random, run_s);
  motor.set_uniform(duty.front().inputs.ambient_K);
  if (start != Start::cold) {
    const double before_s = draw(random, 3600.0, 3.0 * 3600.0);
    const std::vector<DutySegment> earlier = draw_duty(random, before_s);
    constexpr double step_s = 60.0;
    for (double time_s = 0.0; time_s < before_s; time_s += step_s) motor.advance(step_s, inputs_at(earlier, time_s));
  }
  if (start == Start::warm_stopped) {
    MotorInputs stopped;
    stopped.ambient_K = duty.front().inputs.ambient_K;
    motor.advance(draw(random, 120.0, 1800.0), stopped);
  }
  record(motor, duty, random, run);
  return run;
}

MotorRun run_motor_at_rated_duty(Motor motor, std::uint64_t seed) {
  constexpr double warming_s = 2.0 * 3600.0;
  Random random(seed);
  MotorRun run;
  run.seed = seed;
  run.start = Start::warm;
  run.bodies = motor.bodies();
  run.period_s = 2.0;
  const MotorInputs rated{1.0, 1.0, 293.15};
  motor.set_uniform(rated.ambient_K);
  motor.advance(warming_s, rated);
  record(motor, {{run_s, rated}}, random, run);
  return run;
}

FollowScore follow(const rom::Network& network, const MotorRun& run, const std::array<bool, 2>& fed,
                   const FollowOptions& options) {
  firmware::Cycle cycle(network, plan_of(network, run, fed, options),
                        [](const rom::Network& of) { return rom::make_runtime_stepper(of); });
  Trace trace(options.trace_path, options.label);
  FollowScore score;
  std::array<PlaceSums, 2> sums;
  Rejections rejections;
  int count = 0, cycles = 0, degraded = 0, failed = 0, unsaid = 0;
  for (Eigen::Index i = 0; i < run.readings_K.cols(); ++i) {
    const double time_s = run.period_s * static_cast<double>(i);
    const auto now_ns = static_cast<std::int64_t>(ns_per_s * (1.0 + time_s));
    const Snapshot& snapshot = cycle.step(frame_of(run, i, now_ns), {}, now_ns, 0);
    trace.write(run, i, snapshot);
    ++cycles;
    const bool running = snapshot.state == firmware::State::running;
    degraded += running ? 0 : 1;
    failed += snapshot.sensors_failed > 0 ? 1 : 0;
    unsaid += rejections.note(snapshot, fed) && running ? 1 : 0;
    score.ended_running = running;
    count += time_s >= judged_from_s ? 1 : 0;
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const double true_K = run.truth_K(static_cast<Eigen::Index>(k), i + 1);
      sums[k].add(time_s, snapshot.predicted_K[k] - true_K, snapshot.predicted_deviation_K[k],
                  snapshot.uncorrected_K[k] - true_K, score.places[k]);
    }
  }
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k].finish(count, score.places[k]);
  score.degraded = static_cast<double>(degraded) / cycles;
  score.failed = static_cast<double>(failed) / cycles;
  score.rejecting_unsaid = static_cast<double>(unsaid) / cycles;
  score.rejected = rejections.share();
  return score;
}

}  // namespace spindle_twin::bench
