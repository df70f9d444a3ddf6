#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace spindle_twin::rom {

/// A number with its exact partial derivatives with respect to N inputs (chain rule in forward direction). A law that
/// is written once for any scalar gives its value with double and value and slopes with Dual: the two cannot fall
/// apart. No heap, cycle-safe. A direction in which a number does not vary stays zero even where the slope itself is
/// infinite.
template <int N>
struct Dual {
  double value = 0.0;
  std::array<double, static_cast<std::size_t>(N)> slope{};

  Dual() = default;
  Dual(double constant) : value(constant) {}  // NOLINT: constants mix with numbers that vary

  /// The input of direction `direction`, slope 1.
  static Dual variable(double at, int direction) {
    Dual result(at);
    result.slope[static_cast<std::size_t>(direction)] = 1.0;
    return result;
  }

  friend Dual operator-(const Dual& a) { return a.chain(-a.value, -1.0); }
  friend Dual operator+(const Dual& a, const Dual& b) { return combine(a, b, a.value + b.value, 1.0, 1.0); }
  friend Dual operator-(const Dual& a, const Dual& b) { return combine(a, b, a.value - b.value, 1.0, -1.0); }
  friend Dual operator*(const Dual& a, const Dual& b) { return combine(a, b, a.value * b.value, b.value, a.value); }
  friend Dual operator/(const Dual& a, const Dual& b) {
    const double quotient = a.value / b.value;
    return combine(a, b, quotient, 1.0 / b.value, -quotient / b.value);
  }
  Dual& operator+=(const Dual& b) { return *this = *this + b; }
  Dual& operator*=(const Dual& b) { return *this = *this * b; }

  friend Dual exp(const Dual& x) {
    const double result = std::exp(x.value);
    return x.chain(result, result);
  }
  friend Dual expm1(const Dual& x) { return x.chain(std::expm1(x.value), std::exp(x.value)); }
  friend Dual log(const Dual& x) { return x.chain(std::log(x.value), 1.0 / x.value); }
  friend Dual sqrt(const Dual& x) {
    const double result = std::sqrt(x.value);
    return x.chain(result, 0.5 / result);
  }
  friend Dual pow(const Dual& x, double exponent) {
    return x.chain(std::pow(x.value, exponent), exponent * std::pow(x.value, exponent - 1.0));
  }
  friend Dual sin(const Dual& x) { return x.chain(std::sin(x.value), std::cos(x.value)); }
  friend Dual cos(const Dual& x) { return x.chain(std::cos(x.value), -std::sin(x.value)); }
  friend Dual sinh(const Dual& x) { return x.chain(std::sinh(x.value), std::cosh(x.value)); }
  friend Dual cosh(const Dual& x) { return x.chain(std::cosh(x.value), std::sinh(x.value)); }

 private:
  static double times(double factor, double slope) { return slope == 0.0 ? 0.0 : factor * slope; }
  Dual chain(double result_value, double derivative) const {
    Dual result(result_value);
    for (std::size_t i = 0; i < slope.size(); ++i) result.slope[i] = times(derivative, slope[i]);
    return result;
  }
  static Dual combine(const Dual& a, const Dual& b, double result_value, double by_a, double by_b) {
    Dual result(result_value);
    for (std::size_t i = 0; i < a.slope.size(); ++i) {
      result.slope[i] = times(by_a, a.slope[i]) + times(by_b, b.slope[i]);
    }
    return result;
  }
};

}  // namespace spindle_twin::rom
