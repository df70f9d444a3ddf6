#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <string>
#include <vector>

#include "rom/laws/smooth.hpp"

/// Reference numbers and the two checks every law has to pass: its slopes, and their continuity.
namespace spindle_twin::rom::test {

constexpr double celsius_zero_K = 273.15;
constexpr double room_K = 300.15;

/// One state of tests/rom/laws/reference_values.json.
struct ReferenceRow {
  std::vector<std::pair<std::string, double>> numbers;  ///< NaN where the equation has no value
  std::string oil;

  double operator[](const std::string& key) const;  ///< a missing key fails the test
  bool has(const std::string& key) const { return std::isfinite((*this)[key]); }
};
std::vector<ReferenceRow> reference_rows(const std::string& law);

inline void expect_close(double found, double expected, const std::string& what, double relative = 1e-10) {
  EXPECT_LE(std::abs(found - expected), relative * std::abs(expected)) << what << ": " << found << " for " << expected;
}

/// Slope of a law of one number, by Dual.
template <class Law>
double slope(const Law& law, double x) {
  return law(Dual<1>::variable(x, 0)).slope[0];
}

/// Every slope against a complex step, f'(x) = Im f(x + ih)/h, which has no difference to cancel.
template <class Law>
void expect_slope(const Law& law, const std::vector<double>& points, const std::string& what) {
  for (const double x : points) {
    constexpr double step = 1e-40;
    const double expected = law(std::complex<double>(x, step)).imag() / step;
    EXPECT_NEAR(slope(law, x), expected, 1e-7 * std::abs(expected) + 1e-18) << what << " at " << x;
    EXPECT_NEAR(law(Dual<1>(x)).value, law(x), 1e-14 * std::abs(law(x))) << what << " at " << x;
    EXPECT_EQ(law(Dual<1>(x)).slope[0], 0.0) << what << ": a constant has no slope";
  }
}

/// Largest jump of value and of slope, relative to their spans over [low, high]: each of the cells is halved towards
/// its larger change down to neighbouring numbers or 1e-18 of a cell. What is continuous has nothing left then.
struct Jumps {
  double value = 0.0;
  double slope = 0.0;
  double at = 0.0;  ///< of the larger one
};

inline double largest_jump(const std::function<double(double)>& f, double low, double high, double& at) {
  double a = low, b = high, fa = f(a), fb = f(b);
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (a + b), fm = f(middle);
    if (middle == a || middle == b) break;
    if (std::abs(fm - fa) >= std::abs(fb - fm)) {
      b = middle;
      fb = fm;
    } else {
      a = middle;
      fa = fm;
    }
  }
  at = a;
  return std::abs(fb - fa);
}

inline Jumps scan(const std::function<double(double)>& value, const std::function<double(double)>& derivative,
                  double low, double high, int cells = 1000) {
  Jumps found;
  for (const bool of_slope : {false, true}) {
    const std::function<double(double)>& f = of_slope ? derivative : value;
    double smallest = f(low), largest = smallest, worst = 0.0, at = 0.0;
    for (int c = 0; c < cells; ++c) {
      const double a = low + (high - low) * c / cells, b = low + (high - low) * (c + 1) / cells;
      const double here = f(b);
      EXPECT_TRUE(std::isfinite(here)) << "at " << b;
      smallest = std::min(smallest, here);
      largest = std::max(largest, here);
      double place = a;
      const double jump = largest_jump(f, a, b, place);
      if (jump <= worst) continue;
      worst = jump;
      at = place;
    }
    // A law that does not depend on this input at all has a span of rounding only.
    const double span = std::max(largest - smallest, 1e-9 * std::max(std::abs(largest), std::abs(smallest)));
    const double relative = span > 0.0 ? worst / span : 0.0;
    if (relative >= std::max(found.value, found.slope)) found.at = at;
    (of_slope ? found.slope : found.value) = relative;
  }
  return found;
}

template <class Law>
Jumps scan(const Law& law, double low, double high) {
  return scan([&](double x) { return law(x); }, [&](double x) { return slope(law, x); }, low, high);
}

template <class Law>
void expect_smooth(const Law& law, double low, double high, const std::string& what) {
  const Jumps jumps = scan(law, low, high);
  EXPECT_LT(jumps.value, 1e-6) << what << " near " << jumps.at;
  EXPECT_LT(jumps.slope, 1e-6) << what << " near " << jumps.at;
}

}  // namespace spindle_twin::rom::test
