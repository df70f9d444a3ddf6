#pragma once

#include <cmath>
#include <complex>
#include <cstdint>

#include "rom/laws/dual.hpp"

/// What keeps a law's value and slope continuous, and the vocabulary all laws share. The laws are templates over the
/// scalar: double, Dual<N> for value and slopes, std::complex<double> where a test differentiates by a complex step.
namespace spindle_twin::rom {

/// Which reading of a law is evaluated.
enum class LawMode : std::uint8_t {
  standard,      ///< continuous in value and slope: what an integrator needs
  as_published,  ///< the source's own pieces, jumps included
  as_printed,    ///< the seed paper's text, errors included; where it prints no such law, as_published
};

/// Why a value is outside what its law was measured for. Bits; a law never throws.
enum LawFlag : std::uint16_t {
  in_range = 0,
  below_range = 1,          ///< Reynolds, Taylor, Rayleigh number, relative pressure, frequency below the correlation's
  above_range = 2,          ///< the same above
  temperature_clamped = 4,  ///< fluid or lubricant properties at the end of their range
  joint_open = 8,           ///< no pressure left in a fit, no preload left in a bearing
  thin_film = 16,           ///< lubricant below 2 mm²/s: the friction law does not hold
  shape_out_of_range = 32,  ///< a ratio of lengths outside the correlation's range
  undefined = 64,           ///< the printed formula has no value here; a neutral one is returned
};

template <class Scalar>
struct LawValue {
  Scalar value{};
  std::uint16_t flags = in_range;
};

inline double real_part(double x) { return x; }
template <int N>
double real_part(const Dual<N>& x) {
  return x.value;
}
template <class T>
double real_part(const std::complex<T>& x) {
  return x.real();
}

/// |x| with the kink at zero.
template <class Scalar>
Scalar magnitude(const Scalar& x) {
  return real_part(x) < 0.0 ? Scalar(-x) : x;
}

/// 1 − exp(−x) without cancellation at small x.
template <class Scalar>
Scalar one_minus_exp(const Scalar& x) {
  using std::exp;
  using std::sinh;
  if (real_part(x) > 700.0) return Scalar(1.0);
  return 2.0 * exp(-0.5 * x) * sinh(0.5 * x);
}
inline double one_minus_exp(double x) { return -std::expm1(-x); }
template <int N>
Dual<N> one_minus_exp(const Dual<N>& x) {
  return x.value > 700.0 ? Dual<N>(1.0) : -expm1(-x);
}

/// max(u, 0) with its corner rounded between −e and e: 0, (u+e)²/4e, u. At u = 0 it is e/4.
template <class Scalar>
Scalar ramp(const Scalar& u, double e) {
  if (real_part(u) <= -e) return Scalar(0.0);
  if (real_part(u) >= e) return u;
  return (u + e) * (u + e) / (4.0 * e);
}

/// max(a, b), exact where they differ by more than e.
template <class Scalar>
Scalar smooth_max(const Scalar& a, const Scalar& b, double e) {
  return b + ramp(Scalar(a - b), e);
}

/// x where it is above 2·floor, never below floor; flat for x <= 0.
template <class Scalar>
Scalar floor_at(const Scalar& x, double floor) {
  return floor + ramp(Scalar(x - floor), floor);
}

/// x inside [low + e, high − e], never outside [low, high].
template <class Scalar>
Scalar soft_limit(const Scalar& x, double low, double high, double e) {
  const Scalar raised = low + ramp(Scalar(x - low), e);
  return high - ramp(Scalar(high - raised), e);
}

/// Larger of two power laws that cross, a, b >= 0: y = a exp(ramp(ln(b/a), e)). Exact where |ln(b/a)| > e, at the
/// crossing too high by exp(e/4).
template <class Scalar>
Scalar logmax(const Scalar& a, const Scalar& b, double e) {
  using std::exp;
  using std::log;
  if (real_part(b) <= real_part(a) * std::exp(-e)) return a;
  if (real_part(b) >= real_part(a) * std::exp(e)) return b;
  return a * exp(ramp(Scalar(log(b / a)), e));
}

/// Smaller of two power laws that cross.
template <class Scalar>
Scalar logmin(const Scalar& a, const Scalar& b, double e) {
  using std::exp;
  using std::log;
  if (real_part(a) <= real_part(b) * std::exp(-e)) return a;
  if (real_part(a) >= real_part(b) * std::exp(e)) return b;
  return a * exp(-ramp(Scalar(log(a / b)), e));
}

/// Weight 3s² − 2s³, s = (x − low)/(high − low): 0 below, 1 above.
template <class Scalar>
Scalar smoothstep(const Scalar& x, double low, double high) {
  if (real_part(x) <= low) return Scalar(0.0);
  if (real_part(x) >= high) return Scalar(1.0);
  const Scalar s = (x - low) / (high - low);
  return s * s * (3.0 - 2.0 * s);
}

/// |x|^p for |x| >= small, below it the even cubic that meets value and slope there and is flat at zero:
/// small^p u²(3 − p + (p − 2)u), u = |x|/small. For 0 < p < 2, whose |x|^p has a corner or a cusp at reversal.
template <class Scalar>
Scalar smooth_power(const Scalar& x, double exponent, double small) {
  using std::pow;
  const Scalar u = magnitude(x) / small;
  if (real_part(u) >= 1.0) return pow(magnitude(x), exponent);
  return std::pow(small, exponent) * u * u * (3.0 - exponent + (exponent - 2.0) * u);
}

inline double square(double x) { return x * x; }
template <class Scalar>
Scalar square(const Scalar& x) {
  return x * x;
}
template <class Scalar>
Scalar cube(const Scalar& x) {
  return x * x * x;
}

/// below_range or above_range where x is outside [low, high].
template <class Scalar>
std::uint16_t range_flags(const Scalar& x, double low, double high) {
  if (real_part(x) < low) return below_range;
  return real_part(x) > high ? above_range : in_range;
}

}  // namespace spindle_twin::rom
