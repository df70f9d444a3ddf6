#include "firmware/acquire/conversion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spindle_twin::firmware {
namespace {

// IEC 60751: R = R0 (1 + A t + B t^2 + C (t - 100) t^3), C below 0 degC only.
constexpr double r0_ohm = 100.0;
constexpr double a_per_K = 3.9083e-3;
constexpr double b_per_K2 = -5.775e-7;
constexpr double c_per_K4 = -4.183e-12;
constexpr double pt100_coldest_degC = -200.0;
constexpr double pt100_hottest_degC = 850.0;

// NAMUR NE 43, in mA and as shares of the span from 4 to 20 mA.
constexpr double low_mA = 4.0;
constexpr double span_mA = 16.0;
constexpr double least_mA = 3.8;
constexpr double most_mA = 20.5;
constexpr double failure_low_mA = 3.6;
constexpr double failure_high_mA = 21.0;
constexpr double share(double current_mA) { return (current_mA - low_mA) / span_mA; }

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

Converted from_ohm(double resistance_ohm) {
  const double lowest_ohm = pt100_ohm(pt100_coldest_degC);
  const double highest_ohm = pt100_ohm(pt100_hottest_degC);
  const double x = (resistance_ohm - lowest_ohm) / (highest_ohm - lowest_ohm);
  if (x <= share(failure_low_mA)) return {pt100_coldest_degC, WireFault::shorted};
  if (x >= share(failure_high_mA)) return {pt100_hottest_degC, WireFault::open};
  if (x < 0.0) return {pt100_coldest_degC, WireFault::under};
  if (x > 1.0) return {pt100_hottest_degC, WireFault::over};
  return {pt100_degC(resistance_ohm), WireFault::none};
}

Converted from_mA(const Conversion& conversion, double current_mA) {
  if (current_mA <= failure_low_mA) return {not_a_number, WireFault::shorted};
  if (current_mA >= failure_high_mA) return {not_a_number, WireFault::open};
  const double held_mA = std::clamp(current_mA, least_mA, most_mA);
  const double value = conversion.at_4mA + (conversion.at_20mA - conversion.at_4mA) * share(held_mA);
  if (current_mA < least_mA) return {value, WireFault::under};
  return {value, current_mA > most_mA ? WireFault::over : WireFault::none};
}

}  // namespace

double pt100_ohm(double temperature_degC) {
  const double t = temperature_degC;
  const double below = t < 0.0 ? c_per_K4 * (t - 100.0) * t * t * t : 0.0;
  return r0_ohm * (1.0 + a_per_K * t + b_per_K2 * t * t + below);
}

double pt100_degC(double resistance_ohm) {
  const double ratio = resistance_ohm / r0_ohm;
  const double root = a_per_K * a_per_K - 4.0 * b_per_K2 * (1.0 - ratio);
  double t = (-a_per_K + std::sqrt(root)) / (2.0 * b_per_K2);
  if (ratio >= 1.0) return t;
  // The quadratic is 2.4 K off at -200 degC; each step of Newton's squares what is left.
  for (int i = 0; i < 4; ++i) {
    const double slope = a_per_K + 2.0 * b_per_K2 * t + c_per_K4 * t * t * (4.0 * t - 300.0);
    t -= (pt100_ohm(t) / r0_ohm - ratio) / slope;
  }
  return t;
}

const char* wire_fault_name(WireFault fault) {
  switch (fault) {
    case WireFault::none:
      return "good";
    case WireFault::under:
      return "under its range";
    case WireFault::over:
      return "over its range";
    case WireFault::shorted:
      return "shorted or without current";
    case WireFault::open:
      return "open or at failure current";
  }
  return "";
}

Converted convert(const Conversion& conversion, double number) {
  const double scaled = number * conversion.scale + conversion.offset;
  if (std::isnan(scaled)) return {scaled, WireFault::none};
  Converted converted{scaled, WireFault::none};
  if (conversion.kind == ConversionKind::pt100) converted = from_ohm(scaled);
  if (conversion.kind == ConversionKind::ma_4_20) converted = from_mA(conversion, scaled);
  converted.value = converted.value * conversion.unit.factor + conversion.unit.shift;
  return converted;
}

double step_of(const Conversion& conversion) {
  const double step = std::abs(conversion.scale);
  switch (conversion.kind) {
    case ConversionKind::pt100:
      return step / (r0_ohm * a_per_K);
    case ConversionKind::ma_4_20:
      return step * std::abs(conversion.at_20mA - conversion.at_4mA) / span_mA;
    default:
      return step;
  }
}

}  // namespace spindle_twin::firmware
