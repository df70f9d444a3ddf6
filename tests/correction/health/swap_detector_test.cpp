#include "correction/health/swap_detector.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace spindle_twin::correction::test {
namespace health_swap_detector_test {

/// Two places that answer the same square wave with different time constants; the model has another gain at each, and
/// readings are noisy.
struct TwoPlaces {
  SwapDetector detector{{0.03, 0.03}};
  std::array<double, 2> truth_K{}, time_constant_s{120.0, 900.0}, gain{0.6, 1.6};
  std::mt19937_64 random{6};
  std::normal_distribution<double> noise_K{0.0, 0.03};
  bool swapped = false;
  bool modelled = true;
  double rise_K = 10.0;
  int t = 0;

  void step() {
    const double level_K = t++ % 1200 < 600 ? rise_K : 0.0;
    for (std::size_t i = 0; i < 2; ++i) truth_K[i] += (level_K - truth_K[i]) / time_constant_s[i];
    for (std::size_t i = 0; i < 2 && modelled; ++i) detector.note_model(i, gain[i] * truth_K[i], 1.0);
    for (std::size_t i = 0; i < 2; ++i) {
      detector.note_reading(i, truth_K[swapped ? 1 - i : i] + noise_K(random), 1.0, true, {});
    }
  }
  /// Seconds until the two are found; -1: not.
  int found_within(int seconds) {
    while (t < seconds) {
      step();
      if (detector.find({true, true}, {}).one == 0) return t;
    }
    return -1;
  }
};

TEST(SwapDetector, two_that_move_as_each_others_model_are_swapped_whatever_its_gain) {
  TwoPlaces places;
  EXPECT_EQ(places.found_within(7200), -1);
  TwoPlaces crossed;
  crossed.swapped = true;
  const int found_s = crossed.found_within(7200);
  EXPECT_GE(found_s, 180);
  EXPECT_LT(found_s, 1200);
}

TEST(SwapDetector, what_was_seen_of_one_that_is_forgotten_counts_no_more) {
  TwoPlaces crossed;
  crossed.swapped = true;
  ASSERT_GT(crossed.found_within(7200), 0);
  crossed.detector.forget(1);
  EXPECT_TRUE(std::isinf(crossed.detector.evidence(0, 1, {})));
  crossed.swapped = false;
  EXPECT_EQ(crossed.found_within(crossed.t + 7200), -1);
}

TEST(SwapDetector, what_was_forgotten_does_not_speak_for_two_that_are_swapped_later) {
  std::array<int, 2> found_s{};
  for (const bool forgotten : {false, true}) {
    TwoPlaces places;
    while (places.t < 7200) places.step();
    if (forgotten) {
      for (const std::size_t i : {0U, 1U}) places.detector.forget(i);
    }
    places.swapped = true;
    found_s[forgotten ? 1 : 0] = places.found_within(7200 + 14400) - 7200;
  }
  EXPECT_LT(found_s[0], 0) << "two hours speak against it";
  EXPECT_GE(found_s[1], 180);
  EXPECT_LT(found_s[1], 7200);
}

TEST(SwapDetector, small_movements_need_longer_and_none_says_nothing) {
  for (const double rise_K : {1.0, 0.0}) {
    TwoPlaces crossed;
    crossed.swapped = true;
    crossed.rise_K = rise_K;
    EXPECT_EQ(crossed.found_within(7200) > 0, rise_K > 0.0) << rise_K;
  }
}

TEST(SwapDetector, hundredths_of_a_kelvin_count_where_sensors_are_that_quiet) {
  TwoPlaces crossed;
  crossed.swapped = true;
  crossed.detector = SwapDetector{{1e-4, 1e-4}};
  crossed.noise_K = std::normal_distribution<double>{0.0, 1e-4};
  crossed.rise_K = 0.02;
  EXPECT_GT(crossed.found_within(7200), 0);
}

TEST(SwapDetector, without_an_uncorrected_model_or_out_of_use_nothing_is_found) {
  TwoPlaces blind;
  blind.swapped = true;
  blind.modelled = false;
  EXPECT_EQ(blind.found_within(3600), -1);
  TwoPlaces crossed;
  crossed.swapped = true;
  while (crossed.t < 3600) crossed.step();
  EXPECT_EQ(crossed.detector.find({true, false}, {}).one, -1);
  EXPECT_EQ(crossed.detector.find({true, true}, {}).other, 1);
}

TEST(SwapDetector, less_will_do_to_name_the_partner_of_a_channel_that_is_blamed_already) {
  const HealthLimits limits;
  TwoPlaces crossed;
  crossed.swapped = true;
  while (crossed.t < 3600 && crossed.detector.partner_of(0, {true, true}, limits) < 0) crossed.step();
  EXPECT_EQ(crossed.detector.partner_of(1, {true, true}, limits), 0);
  EXPECT_EQ(crossed.detector.partner_of(1, {false, true}, limits), -1);
  EXPECT_EQ(crossed.detector.find({true, true}, limits).one, -1) << "by itself that is too little";
  EXPECT_GT(crossed.detector.evidence(0, 1, limits), limits.swap_support);
  EXPECT_LT(crossed.detector.evidence(0, 1, limits), limits.swap_limit);
}

TEST(SwapDetector, what_has_been_seen_counts_for_an_hour) {
  const HealthLimits limits;
  TwoPlaces crossed;
  crossed.swapped = true;
  const auto evidence_after = [&](int seconds) {
    while (crossed.t < seconds) crossed.step();
    return crossed.detector.evidence(0, 1, limits);
  };
  const double hour = evidence_after(3600), five_hours = evidence_after(18000);
  // Of steady movement 1 − e^(−t/τ) has been kept: 0.99 / 0.63; with twice or half the memory it would be 2.3 or 1.2.
  EXPECT_NEAR(five_hours / hour, 1.57, 0.2);
}

/// The evidence of two places by its equations, from all that was told, with sums over the whole history.
struct ByTheEquations {
  std::vector<std::array<double, 2>> readings_K, models_K;  // one a second

  static std::vector<double> freed_from_mean(const std::vector<std::array<double, 2>>& told, std::size_t i,
                                             double tau_s) {
    std::vector<double> moved;
    double mean = told.front()[i];
    for (const auto& each : told) {
      moved.push_back(each[i] - mean);
      mean = std::exp(-1.0 / tau_s) * mean + (1.0 - std::exp(-1.0 / tau_s)) * each[i];
    }
    return moved;
  }
  double evidence(double noise_K, const HealthLimits& limits) const {
    const std::size_t n = readings_K.size();
    std::vector<double> weight(n);
    double seen_s = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      weight[k] = std::exp(-static_cast<double>(n - 1 - k) / limits.swap_memory_s);
      seen_s += weight[k];
    }
    const auto sum = [&](const auto& term) {
      double total = 0.0;
      for (std::size_t k = 0; k < n; ++k) total += weight[k] * term(k);
      return total;
    };
    double gains = 0.0, penalty = 0.0;
    for (const double tau_s : SwapDetector::scales_s) {
      std::array<std::vector<double>, 2> y, m;
      for (std::size_t i = 0; i < 2; ++i) {
        y[i] = freed_from_mean(readings_K, i, tau_s);
        m[i] = freed_from_mean(models_K, i, tau_s);
      }
      std::array<double, 2> samples{}, square{};
      for (std::size_t i = 0; i < 2; ++i) {
        const double second = sum([&](std::size_t k) { return std::pow(m[i][k], 2); });
        samples[i] = second * second / sum([&](std::size_t k) { return std::pow(m[i][k], 4); }) / tau_s;
        square[i] = sum([&](std::size_t k) { return std::pow(y[i][k], 2); });
      }
      const auto gain = [&](std::size_t i, std::size_t j) {
        return sum([&](std::size_t k) { return y[i][k] * m[j][k]; }) /
               sum([&](std::size_t k) { return std::pow(m[j][k], 2); });
      };
      const auto left_over = [&](std::size_t i, std::size_t j) {
        const double factor = gain(i, j);
        return sum([&](std::size_t k) { return std::pow(y[i][k] - factor * m[j][k], 2); });
      };
      for (std::size_t i = 0; i < 2; ++i) {
        const double least = std::pow(limits.swap_floor, 2) * square[i] + noise_K * noise_K * seen_s;
        gains += std::min(samples[0], samples[1]) * std::log((left_over(i, i) + least) / (left_over(i, 1 - i) + least));
        if (tau_s != 300.0) continue;
        const double unsure = std::pow(limits.swap_gain, 2) + std::pow(limits.swap_K, 2) * seen_s / square[i];
        penalty += (std::pow(std::log(gain(i, i)), 2) - std::pow(std::log(gain(i, 1 - i)), 2)) / unsure;
      }
    }
    return gains + penalty;
  }
};

TEST(SwapDetector, the_evidence_is_that_of_the_equations) {
  HealthLimits limits;
  limits.swap_fit = 1e3;  // no pair is refused for what is left over, so that there is a number to compare
  SwapDetector detector({0.03, 0.03});
  ByTheEquations equations;
  std::array<double, 2> truth_K{}, model_K{};
  for (int t = 0; t < 3000; ++t) {
    const double level_K = 10.0 * std::sin(t / 170.0) + (t % 900 < 400 ? 4.0 : 0.0);
    for (std::size_t i = 0; i < 2; ++i) {
      truth_K[i] += (level_K - truth_K[i]) / (i == 0 ? 120.0 : 700.0);
      model_K[i] += (0.8 * level_K - model_K[i]) / (i == 0 ? 200.0 : 500.0);
      detector.note_model(i, model_K[i], 1.0);
    }
    equations.readings_K.push_back({truth_K[1], truth_K[0]});
    equations.models_K.push_back(model_K);
    for (std::size_t i = 0; i < 2; ++i) detector.note_reading(i, truth_K[1 - i], 1.0, true, limits);
    if (t < 400 || t % 200 != 0) continue;
    const double expected = equations.evidence(0.03, limits);
    EXPECT_NEAR(detector.evidence(0, 1, limits), expected, 1e-6 * std::abs(expected)) << t;
  }
}

TEST(SwapDetector, two_that_read_the_same_place_are_not_swapped) {
  HealthLimits limits;
  limits.swap_fit = 1e3;
  for (const bool same : {false, true}) {
    SwapDetector detector({0.03, 0.03});
    std::array<double, 2> place_K{};
    for (int t = 0; t < 3000; ++t) {
      const double level_K = t % 600 < 300 ? 5.0 : 0.0;
      for (std::size_t i = 0; i < 2; ++i) {
        place_K[i] += (level_K - place_K[i]) / (i == 0 ? 60.0 : 900.0);
        detector.note_model(i, place_K[i], 1.0);
      }
      detector.note_reading(0, place_K[1], 1.0, true, limits);
      detector.note_reading(1, place_K[same ? 1 : 0], 1.0, true, limits);
    }
    const double evidence = detector.evidence(0, 1, limits);
    if (same) {
      EXPECT_EQ(evidence, -std::numeric_limits<double>::infinity()) << "the second fits its own place";
    } else {
      EXPECT_GT(evidence, limits.swap_limit);
    }
  }
}

TEST(SwapDetector, three_minutes_of_both_are_needed) {
  for (const std::size_t late : {std::size_t{0}, std::size_t{1}}) {
    TwoPlaces crossed;
    crossed.swapped = true;
    for (; crossed.t < 3200;) {
      const int level_s = crossed.t++ % 1200;
      for (std::size_t i = 0; i < 2; ++i) {
        crossed.truth_K[i] += ((level_s < 600 ? 10.0 : 0.0) - crossed.truth_K[i]) / crossed.time_constant_s[i];
      }
      for (std::size_t i = 0; i < 2; ++i) crossed.detector.note_model(i, crossed.truth_K[i], 1.0);
      for (std::size_t i = 0; i < 2; ++i) {
        crossed.detector.note_reading(i, crossed.truth_K[1 - i], 1.0, i != late || crossed.t > 2400, {});
      }
      const double evidence = crossed.detector.evidence(0, 1, {});
      if (crossed.t >= 2400 + 180) continue;
      ASSERT_EQ(evidence, -std::numeric_limits<double>::infinity()) << crossed.t;
    }
    EXPECT_GT(crossed.detector.evidence(0, 1, {}), 0.0);
  }
}

TEST(SwapDetector, a_place_whose_model_is_wrong_in_shape_is_not_swapped) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> unit(0.0, 1.0);
  constexpr std::array time_constant_s{100.0, 200.0, 400.0, 800.0, 1600.0};
  for (int run = 0; run < 40; ++run) {
    constexpr std::size_t n = time_constant_s.size();
    SwapDetector detector(std::vector<double>(n, 0.03));
    std::array<double, n> truth_K{}, model_K{}, factor{}, share{};
    for (std::size_t i = 0; i < n; ++i) factor[i] = std::exp(0.2 * unit(random));
    for (std::size_t i = 0; i < n; ++i) share[i] = std::exp(0.35 * unit(random));
    double level_K = 0.0;
    for (int t = 0; t < 7200; ++t) {
      if (t % 300 == 0) level_K = 10.0 * std::abs(unit(random));
      for (std::size_t i = 0; i < n; ++i) {
        truth_K[i] += (level_K - truth_K[i]) / time_constant_s[i];
        model_K[i] += (share[i] * level_K - model_K[i]) / (factor[i] * time_constant_s[i]);
        detector.note_model(i, model_K[i], 1.0);
      }
      for (std::size_t i = 0; i < n; ++i) detector.note_reading(i, truth_K[i] + 0.03 * unit(random), 1.0, true, {});
      if (t % 60 != 0) continue;
      ASSERT_EQ(detector.find(std::vector<bool>(n, true), {}).one, -1) << run << " at " << t;
    }
  }
}

}  // namespace health_swap_detector_test
}  // namespace spindle_twin::correction::test
