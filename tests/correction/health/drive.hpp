#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "correction/health/sensor_health.hpp"

namespace spindle_twin::correction::test {

inline constexpr std::uint64_t drive_seed = 20;

/// The first verdict by evidence is laid to the model; those of the two hours after this one are not. With two channels
/// there is none.
inline void spend_first_verdict(SensorHealth& health, std::size_t channels) {
  std::vector<HealthUpdate> updates(channels, {true, 0.0, 0});
  updates.back() = {true, 40.0, 2};
  health.note_update(updates);
  updates.back() = {true, 0.0, 0};
  health.note_update(updates);
}

/// Temperatures in closed form: each place answers a speed that goes in random steps with one exponential. The model
/// of it has the wrong gain at every place and is pulled to the readings every ten seconds, as an estimator does.
struct Drive {
  static constexpr std::size_t places = 6;
  static constexpr std::array<double, places> time_constant_s{300.0, 420.0, 600.0, 900.0, 180.0, 240.0};
  static constexpr std::array<double, places> gain_K{9.0, 7.0, 4.0, 12.0, 30.0, 2.0};

  explicit Drive(std::uint64_t seed, HealthLimits limits = {}, double the_resolution_K = 0.01)
      : random(seed),
        resolution_K(the_resolution_K),
        health(std::vector<HealthChannel>(places, {true, 253.15, 423.15, the_resolution_K}), limits),
        samples(places) {
    for (std::size_t i = 0; i < places; ++i) {
      truth_K[i] = model_K[i] = corrected_K[i] = free_K[i] = start_K;
      model_gain[i] = std::exp(0.25 * normal(random));
      offset_K[i] = 0.2 * normal(random);
    }
  }

  double level() {
    if (time_s >= until_s) {
      const bool rests = unit(random) < 0.1;
      until_s = time_s + (rests ? 3600.0 * unit(random) : 180.0 + 540.0 * unit(random));
      speed = steady ? 0.5 : rests ? 0.0 : unit(random);
    }
    return speed * speed;
  }

  void step() {
    const double level_now = level();
    for (std::size_t i = 0; i < places; ++i) {
      const double keep = std::exp(-cycle_s / time_constant_s[i]);
      truth_K[i] = start_K + gain_K[i] * level_now + keep * (truth_K[i] - start_K - gain_K[i] * level_now);
      const double model_rise_K = gain_K[i] * model_gain[i] * level_now;
      model_K[i] = start_K + model_rise_K + keep * (model_K[i] - start_K - model_rise_K);
      free_K[i] = start_K + model_rise_K + keep * (free_K[i] - start_K - model_rise_K);
      const double read_K = truth_K[i] + offset_K[i] + noise_K * normal(random);
      samples[i] = {true, resolution_K * std::round(read_K / resolution_K), model_K[i], model_K[i] - corrected_K[i],
                    free_K[i]};
    }
    if (tamper) tamper(samples);
    health.step(samples, time_s, time_s == 0.0 ? 0.0 : cycle_s);
    const bool due = std::fmod(time_s, 10.0) < 0.5 * cycle_s;
    for (std::size_t i = 0; i < places; ++i) {
      if (due && health.record(i).usable) model_K[i] += 0.2 * (samples[i].reading_K - offset_K[i] - model_K[i]);
      corrected_K[i] = model_K[i];
    }
    time_s += cycle_s;
  }
  void run_until(double end_s) {
    while (time_s < end_s) step();
  }
  int failed() const {
    int count = 0;
    for (std::size_t i = 0; i < places; ++i) count += health.record(i).state == HealthState::failed ? 1 : 0;
    return count;
  }

  static constexpr double start_K = 295.0;
  std::mt19937_64 random;
  std::normal_distribution<double> normal{0.0, 1.0};
  std::uniform_real_distribution<double> unit{0.0, 1.0};
  double resolution_K;
  SensorHealth health;
  std::vector<HealthSample> samples;
  std::function<void(std::vector<HealthSample>&)> tamper;
  std::array<double, places> truth_K{}, model_K{}, free_K{}, corrected_K{}, model_gain{}, offset_K{};
  double cycle_s = 1.0;
  double noise_K = 0.03;
  double time_s = 0.0, until_s = 0.0, speed = 0.0;
  bool steady = false;
};

}  // namespace spindle_twin::correction::test
