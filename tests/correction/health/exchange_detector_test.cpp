#include "correction/health/exchange_detector.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace spindle_twin::correction::test {
namespace health_exchange_detector_test {

/// Two places that answer the same square wave with different time constants; the model has another gain at each, and
/// readings are noisy.
struct TwoPlaces {
  ExchangeDetector detector{{0.03, 0.03}};
  std::array<double, 2> truth_K{}, time_constant_s{120.0, 900.0}, gain{0.6, 1.6};
  std::mt19937_64 random{6};
  std::normal_distribution<double> noise_K{0.0, 0.03};
  bool exchanged = false;
  bool modelled = true;
  double rise_K = 10.0;
  int t = 0;

  void step() {
    const double level_K = t++ % 1200 < 600 ? rise_K : 0.0;
    for (std::size_t i = 0; i < 2; ++i) truth_K[i] += (level_K - truth_K[i]) / time_constant_s[i];
    for (std::size_t i = 0; i < 2 && modelled; ++i) detector.note_model(i, gain[i] * truth_K[i], 1.0);
    for (std::size_t i = 0; i < 2; ++i) {
      detector.note_reading(i, truth_K[exchanged ? 1 - i : i] + noise_K(random), 1.0, true, {});
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

TEST(ExchangeDetector, two_that_move_as_each_others_model_are_exchanged_whatever_its_gain) {
  TwoPlaces places;
  EXPECT_EQ(places.found_within(7200), -1);
  TwoPlaces crossed;
  crossed.exchanged = true;
  const int found_s = crossed.found_within(7200);
  EXPECT_GE(found_s, 180);
  EXPECT_LT(found_s, 1200);
}

TEST(ExchangeDetector, small_movements_need_longer_and_none_says_nothing) {
  for (const double rise_K : {1.0, 0.0}) {
    TwoPlaces crossed;
    crossed.exchanged = true;
    crossed.rise_K = rise_K;
    EXPECT_EQ(crossed.found_within(7200) > 0, rise_K > 0.0) << rise_K;
  }
}

TEST(ExchangeDetector, hundredths_of_a_kelvin_count_where_sensors_are_that_quiet) {
  TwoPlaces crossed;
  crossed.exchanged = true;
  crossed.detector = ExchangeDetector{{1e-4, 1e-4}};
  crossed.noise_K = std::normal_distribution<double>{0.0, 1e-4};
  crossed.rise_K = 0.02;
  EXPECT_GT(crossed.found_within(7200), 0);
}

TEST(ExchangeDetector, without_an_uncorrected_model_or_out_of_use_nothing_is_found) {
  TwoPlaces blind;
  blind.exchanged = true;
  blind.modelled = false;
  EXPECT_EQ(blind.found_within(3600), -1);
  TwoPlaces crossed;
  crossed.exchanged = true;
  while (crossed.t < 3600) crossed.step();
  EXPECT_EQ(crossed.detector.find({true, false}, {}).one, -1);
  EXPECT_EQ(crossed.detector.find({true, true}, {}).other, 1);
}

TEST(ExchangeDetector, less_will_do_to_name_the_partner_of_a_channel_that_is_blamed_already) {
  const HealthLimits limits;
  TwoPlaces crossed;
  crossed.exchanged = true;
  while (crossed.t < 3600 && crossed.detector.partner_of(0, {true, true}, limits) < 0) crossed.step();
  EXPECT_EQ(crossed.detector.partner_of(1, {true, true}, limits), 0);
  EXPECT_EQ(crossed.detector.partner_of(1, {false, true}, limits), -1);
  EXPECT_EQ(crossed.detector.find({true, true}, limits).one, -1) << "by itself that is too little";
  EXPECT_GT(crossed.detector.evidence(0, 1, limits), limits.swap_support);
  EXPECT_LT(crossed.detector.evidence(0, 1, limits), limits.swap_limit);
}

TEST(ExchangeDetector, what_has_been_seen_counts_for_an_hour) {
  const HealthLimits limits;
  TwoPlaces crossed;
  crossed.exchanged = true;
  const auto evidence_after = [&](int seconds) {
    while (crossed.t < seconds) crossed.step();
    return crossed.detector.evidence(0, 1, limits);
  };
  const double hour = evidence_after(3600), five_hours = evidence_after(18000);
  // Of steady movement 1 − e^(−t/τ) has been kept: 0.99 / 0.63; with twice or half the memory it would be 2.3 or 1.2.
  EXPECT_NEAR(five_hours / hour, 1.57, 0.2);
}

TEST(ExchangeDetector, a_place_whose_model_is_wrong_in_shape_is_not_exchanged) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> unit(0.0, 1.0);
  constexpr std::array time_constant_s{100.0, 200.0, 400.0, 800.0, 1600.0};
  for (int run = 0; run < 40; ++run) {
    constexpr std::size_t n = time_constant_s.size();
    ExchangeDetector detector(std::vector<double>(n, 0.03));
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

}  // namespace health_exchange_detector_test
}  // namespace spindle_twin::correction::test
