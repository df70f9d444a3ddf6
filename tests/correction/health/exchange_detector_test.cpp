#include "correction/health/exchange_detector.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace spindle_twin::correction::test {
namespace {

/// Two places that answer the same square wave with different time constants; the model has another gain at each.
struct TwoPlaces {
  ExchangeDetector detector{2};
  std::array<double, 2> truth_K{}, time_constant_s{120.0, 900.0}, gain{0.5, 2.0};
  bool exchanged = false;
  double rise_K = 10.0;

  bool found_within(int seconds) {
    for (int t = 0; t < seconds; ++t) {
      const double level_K = t % 1200 < 600 ? rise_K : 0.0;
      for (std::size_t i = 0; i < 2; ++i) truth_K[i] += (level_K - truth_K[i]) / time_constant_s[i];
      for (std::size_t i = 0; i < 2; ++i) {
        detector.note_model(i, gain[i] * truth_K[i], 1.0, {});
        detector.note_reading(i, truth_K[exchanged ? 1 - i : i], 1.0, {});
      }
      detector.accumulate(1.0, {});
      if (detector.move_exchanged(0, 1, {})) return true;
    }
    return false;
  }
};

TEST(ExchangeDetector, two_that_move_as_each_others_model_are_exchanged_whatever_its_gain) {
  TwoPlaces places;
  EXPECT_FALSE(places.found_within(7200));
  TwoPlaces crossed;
  crossed.exchanged = true;
  EXPECT_TRUE(crossed.found_within(1200));
}

TEST(ExchangeDetector, what_moves_by_less_than_swap_K_is_not_judged) {
  TwoPlaces crossed;
  crossed.exchanged = true;
  crossed.rise_K = 0.2;
  EXPECT_FALSE(crossed.found_within(7200));
}

}  // namespace
}  // namespace spindle_twin::correction::test
